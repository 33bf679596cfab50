"""The features of the window, in the order of their actions in the menus."""

from __future__ import annotations

from app.views.features.animation import AnimationFeature
from app.views.features.compare import CompareFeature
from app.views.features.edit import DrawFeature, ModesFeature, UndoSelectionFeature
from app.views.features.exchange import BatchFeature, ClipboardFeature, ExportFeature, ImportFeature
from app.views.features.files import FolderFeature, OpenSaveFeature, RecoveryFeature, StartFeature
from app.views.features.help import HelpFeature, PreferencesFeature
from app.views.features.objects import ObjectsFeature
from app.views.features.offers import BeginningFeature, PixelSizeFeature, StackFeature
from app.views.features.run import (
    RunControlFeature,
    TasksFeature,
    TimelineFeature,
)
from app.views.features.view import KeyboardFeature, LayersFeature
from app.views.features.volumes import PagesFeature, SlicesFeature, SpaceFeature
from app.views.window.window import Feature

FEATURES: tuple[type[Feature], ...] = (
    OpenSaveFeature,
    StartFeature,
    FolderFeature,
    ExportFeature,
    BatchFeature,
    RecoveryFeature,
    AnimationFeature,
    UndoSelectionFeature,
    ClipboardFeature,
    ImportFeature,
    DrawFeature,
    RunControlFeature,
    TimelineFeature,
    TasksFeature,
    ModesFeature,
    BeginningFeature,
    StackFeature,
    PixelSizeFeature,
    ObjectsFeature,
    LayersFeature,
    CompareFeature,
    SlicesFeature,
    PagesFeature,
    SpaceFeature,
    KeyboardFeature,
    PreferencesFeature,
    HelpFeature,
)
