"""Features of the window."""

from __future__ import annotations

from cpm_app.views.features.animation import AnimationFeature
from cpm_app.views.features.compare import CompareFeature
from cpm_app.views.features.edit import DrawFeature, ModesFeature, UndoSelectionFeature
from cpm_app.views.features.exchange import BatchFeature, ClipboardFeature, ExportFeature, ImportFeature
from cpm_app.views.features.files import FolderFeature, OpenSaveFeature, RecoveryFeature, StartFeature
from cpm_app.views.features.help import HelpFeature, PreferencesFeature
from cpm_app.views.features.measures import MeasuresFeature
from cpm_app.views.features.models import LargerModelFeature
from cpm_app.views.features.objects import ObjectsFeature
from cpm_app.views.features.offers import FilePartsFeature, InitialSettingsFeature, PixelSizeFeature
from cpm_app.views.features.project import ProjectFeature
from cpm_app.views.features.run import (
    RunControlFeature,
    TasksFeature,
    TimelineFeature,
)
from cpm_app.views.features.second_image import SecondImageFeature
from cpm_app.views.features.view import KeyboardFeature, LayersFeature
from cpm_app.views.features.volumes import PagesFeature, SlicesFeature, SpaceFeature
from cpm_app.views.window.window import Feature

WINDOW_FEATURES: tuple[type[Feature], ...] = (
    OpenSaveFeature,
    StartFeature,
    FolderFeature,
    ProjectFeature,
    ExportFeature,
    BatchFeature,
    RecoveryFeature,
    AnimationFeature,
    UndoSelectionFeature,
    ClipboardFeature,
    ImportFeature,
    SecondImageFeature,
    DrawFeature,
    RunControlFeature,
    TimelineFeature,
    TasksFeature,
    ModesFeature,
    InitialSettingsFeature,
    LargerModelFeature,
    FilePartsFeature,
    PixelSizeFeature,
    ObjectsFeature,
    LayersFeature,
    CompareFeature,
    SlicesFeature,
    PagesFeature,
    SpaceFeature,
    MeasuresFeature,
    KeyboardFeature,
    PreferencesFeature,
    HelpFeature,
)
"""Classes of the features, in the order of their actions in the menus."""
