"""The features of the window, in the order of their actions in the menus."""

from __future__ import annotations

from app.views.features.contours.contours import ContoursFeature
from app.views.features.contours.hand_editing import HandEditingFeature
from app.views.features.contours.objects import ObjectsFeature
from app.views.features.contours.skeletons import SkeletonsFeature
from app.views.features.contours.truth import TruthFeature
from app.views.features.edit.draw import DrawFeature
from app.views.features.edit.modes import ModesFeature
from app.views.features.edit.pixel_size import PixelSizeFeature
from app.views.features.edit.undo_selection import HistoryFeature, UndoSelectionFeature
from app.views.features.file.batch import BatchFeature
from app.views.features.file.beginning import BeginningFeature
from app.views.features.file.export import ClipboardFeature, ExportFeature
from app.views.features.file.folder import FolderFeature
from app.views.features.file.importing import ImportFeature
from app.views.features.file.large_image import LargeImageFeature
from app.views.features.file.open_save import OpenSaveFeature
from app.views.features.file.preferences import PreferencesFeature
from app.views.features.file.recovery import RecoveryFeature
from app.views.features.file.stack import StackFeature
from app.views.features.file.start import StartFeature
from app.views.features.help.help import HelpFeature
from app.views.features.run.parameters import ParametersFeature
from app.views.features.run.run_control import RunControlFeature
from app.views.features.run.tasks import TasksFeature
from app.views.features.run.timeline import TimelineFeature
from app.views.features.view.animation import AnimationFeature
from app.views.features.view.appearance import AppearanceFeature
from app.views.features.view.comparing import ComparingFeature
from app.views.features.view.comparing_runs import ComparisonFeature
from app.views.features.view.keyboard import KeyboardFeature
from app.views.features.view.layers import LayersFeature
from app.views.features.view.levels import LevelsFeature
from app.views.features.view.pages import PagesFeature
from app.views.features.view.slices import SlicesFeature
from app.views.features.view.space import SpaceFeature
from app.views.window.feature import Feature

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
    ParametersFeature,
    BeginningFeature,
    LargeImageFeature,
    StackFeature,
    PixelSizeFeature,
    ContoursFeature,
    HandEditingFeature,
    TruthFeature,
    ObjectsFeature,
    SkeletonsFeature,
    ComparisonFeature,
    HistoryFeature,
    LayersFeature,
    LevelsFeature,
    ComparingFeature,
    SlicesFeature,
    PagesFeature,
    SpaceFeature,
    KeyboardFeature,
    AppearanceFeature,
    PreferencesFeature,
    HelpFeature,
)
