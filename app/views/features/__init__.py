"""The parts of the window, in the order in which their entries stand in the menus."""

from __future__ import annotations

from app.views.features.contours.contours import ContoursFeature
from app.views.features.contours.truth import TruthFeature
from app.views.features.edit.drawing import DrawingFeature
from app.views.features.edit.editing import EditingFeature
from app.views.features.edit.history import HistoryFeature
from app.views.features.edit.modes import ModesFeature
from app.views.features.file.clipboard import ClipboardFeature
from app.views.features.file.files import FilesFeature
from app.views.features.file.preferring import PreferringFeature
from app.views.features.file.recovery import RecoveryFeature
from app.views.features.help.helping import HelpingFeature
from app.views.features.help.keys import KeysFeature
from app.views.features.run.parameters import ParametersFeature
from app.views.features.run.running import RunningFeature
from app.views.features.run.tasks import TasksFeature
from app.views.features.run.timeline import TimelineFeature
from app.views.features.view.animation import AnimationFeature
from app.views.features.view.looks import LooksFeature
from app.views.features.view.mosaic import MosaicFeature
from app.views.features.view.viewing import ViewingFeature
from app.views.window.feature import Feature

FEATURES: tuple[type[Feature], ...] = (
    FilesFeature,
    RecoveryFeature,
    AnimationFeature,
    EditingFeature,
    ClipboardFeature,
    DrawingFeature,
    RunningFeature,
    TimelineFeature,
    TasksFeature,
    ModesFeature,
    ParametersFeature,
    ContoursFeature,
    TruthFeature,
    MosaicFeature,
    HistoryFeature,
    ViewingFeature,
    LooksFeature,
    PreferringFeature,
    KeysFeature,
    HelpingFeature,
)
