"""The parts of the window, in the order in which their entries stand in the menus."""

from __future__ import annotations

from app.views.features.contours.contours import ContoursPart
from app.views.features.contours.truth import TruthPart
from app.views.features.edit.drawing import DrawingPart
from app.views.features.edit.editing import EditingPart
from app.views.features.edit.history import HistoryPart
from app.views.features.edit.modes import ModesPart
from app.views.features.file.clipboard import ClipboardPart
from app.views.features.file.files import FilesPart
from app.views.features.file.preferring import PreferringPart
from app.views.features.file.recovery import RecoveryPart
from app.views.features.help.helping import HelpingPart
from app.views.features.help.keys import KeysPart
from app.views.features.run.parameters import ParametersPart
from app.views.features.run.running import RunningPart
from app.views.features.run.tasks import TasksPart
from app.views.features.run.timeline import TimelinePart
from app.views.features.view.animation import AnimationPart
from app.views.features.view.looks import LooksPart
from app.views.features.view.mosaic import MosaicPart
from app.views.features.view.viewing import ViewingPart
from app.views.window.part import Part

PARTS: tuple[type[Part], ...] = (
    FilesPart,
    RecoveryPart,
    AnimationPart,
    EditingPart,
    ClipboardPart,
    DrawingPart,
    RunningPart,
    TimelinePart,
    TasksPart,
    ModesPart,
    ParametersPart,
    ContoursPart,
    TruthPart,
    MosaicPart,
    HistoryPart,
    ViewingPart,
    LooksPart,
    PreferringPart,
    KeysPart,
    HelpingPart,
)
