"""The parts of the window, in the order in which their entries stand in the menus."""

from __future__ import annotations

from app.views.part import Part
from app.views.parts.animation import AnimationPart
from app.views.parts.clipboard import ClipboardPart
from app.views.parts.contours import ContoursPart
from app.views.parts.drawing import DrawingPart
from app.views.parts.editing import EditingPart
from app.views.parts.files import FilesPart
from app.views.parts.helping import HelpingPart
from app.views.parts.history import HistoryPart
from app.views.parts.keys import KeysPart
from app.views.parts.looks import LooksPart
from app.views.parts.modes import ModesPart
from app.views.parts.mosaic import MosaicPart
from app.views.parts.parameters import ParametersPart
from app.views.parts.preferring import PreferringPart
from app.views.parts.recovery import RecoveryPart
from app.views.parts.running import RunningPart
from app.views.parts.tasks import TasksPart
from app.views.parts.timeline import TimelinePart
from app.views.parts.truth import TruthPart
from app.views.parts.viewing import ViewingPart

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
