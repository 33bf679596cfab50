"""The situation: document, selection and run together, conditions of actions, and differences in a volume."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import field
from typing import Literal

from cpm_app.model.document.document import Document
from cpm_app.model.document.modes import needs_start
from cpm_app.model.text.language import tr
from cpm_core import RUN_METHODS, Contour, Result, Skeleton, Surface
from cpm_core.numerics.types import frozen

Phase = Literal["empty", "ready", "running", "paused", "finished"]


@frozen
class RunStatus:
    """State of the run.

    Attributes
    ----------
    phase : {"empty", "ready", "running", "paused", "finished"}
        No image; no run; stepping; stopped by the user; ended.
    busy : str
        What is being prepared, empty for nothing.
    stale : bool
        Whether a new run from the current document would begin differently from the existing one.
    steered : bool
        Whether the run has ended and the document's parameters differ from those it ended with.
    method : str
        Name of the method.
    steering : tuple
        `Method.steering` of the last step.
    step, count, scale : int
        Steps taken, particles, scale (0 is the image itself).
    epsilon : float
        Eq. (23); NaN before it is known.
    stop_reason : str
        Why the run ended.
    converged : bool
        Whether it ended in equilibrium.
    steps_per_second : float
        Measured speed of the run.
    found : Result or Skeleton or None
        Latest reconstruction.
    """

    phase: Phase = "empty"
    busy: str = ""
    stale: bool = False
    steered: bool = False
    method: str = "cpm"
    steering: tuple[object, ...] = ()
    step: int = 0
    count: int = 0
    scale: int = 0
    epsilon: float = math.nan
    stop_reason: str = ""
    converged: bool = False
    steps_per_second: float = 0.0
    found: Result | Skeleton | None = None

    @property
    def contours(self) -> tuple[Contour, ...]:
        """Contours, or the lines of a skeleton."""
        return () if self.found is None else self.found.contours

    @property
    def surface(self) -> Surface | None:
        """The surface that has been found in a volume."""
        return None if self.found is None else self.found.surface

    @property
    def started(self) -> bool:
        """Whether there is a run."""
        return self.phase in ("running", "paused", "finished")

    @property
    def unfinished(self) -> bool:
        """Whether the run has ended before its particles came to rest, so that it can be continued."""
        return self.phase == "finished" and not self.converged and self.count > 0

    @property
    def has_particles(self) -> bool:
        """Whether particles have been shown; before the very first run the kernels may have to be compiled."""
        return self.started and (self.step > 0 or self.count > 0)


@frozen
class Situation:
    """Everything that determines what the window shows and enables.

    The names of undo and redo are empty when there is nothing to undo or redo; `selected` is the index of a shape.
    """

    document: Document = field(default_factory=Document)
    status: RunStatus = field(default_factory=RunStatus)
    undo_name: str = ""
    redo_name: str = ""
    selected: int | None = None


Condition = Callable[[Situation], bool]


def always(situation: Situation) -> bool:
    """Return True in any situation."""
    return True


def has_image(situation: Situation) -> bool:
    """Tell whether an image is open."""
    return situation.document.image is not None


def has_shapes(situation: Situation) -> bool:
    """Tell whether there are shapes."""
    return bool(situation.document.shapes)


def is_started(situation: Situation) -> bool:
    """Tell whether there is a run."""
    return situation.status.started


def is_running(situation: Situation) -> bool:
    """Tell whether steps are being taken."""
    return situation.status.phase == "running"


def has_particles(situation: Situation) -> bool:
    """Tell whether particles of a run have been shown."""
    return situation.status.has_particles


def has_contours(situation: Situation) -> bool:
    """Tell whether contours have been found."""
    return bool(situation.status.contours)


def moves_particles(situation: Situation) -> bool:
    """Tell whether the run moves particles, or without a run the next one."""
    status = situation.status
    return RUN_METHODS[status.method].seeded if status.started else needs_start(situation.document.mode)


def can_step(situation: Situation) -> bool:
    """Tell whether a single step can be taken.

    It cannot during a run, nor after one that has come to rest and for which nothing has changed.
    """
    status = situation.status
    over = status.phase == "finished" and not (status.stale or status.steered or status.unfinished)
    return has_image(situation) and status.phase != "running" and not over


HIDDEN_IN_VOLUMES = frozenset(("outline", "apply_to_folder"))
"""Names of actions and tools that are hidden while a volume is open."""


TEXTS_IN_VOLUMES = {
    "circle": (tr("Sphe&re"), tr("Drag from the center to draw a sphere.")),
    "ellipse": (
        tr("Bo&x"),
        tr("Drag from corner to corner to draw a box, as deep as its shorter side; Shift makes it a square."),
    ),
    "grid_area": (
        tr("&Grid"),
        tr("Drag a box, as deep as its shorter side, to fill with an even grid; [ and ] change its spacing."),
    ),
    "threshold": (
        tr("T&hreshold"),
        tr("Drag a box, as deep as its shorter side, in which to start on strong edges; [ and ] change how strong."),
    ),
    "points": (tr("&Points"), tr("Click to place a point in the slice.")),
    "import_contours": (
        tr("&Import surface…"),
        tr("Import a surface, labels or center lines as a start, as objects or as ground truth."),
    ),
    "mend": (
        tr("&Brush"),
        tr("Drag in a slice to paint an object, Shift-drag to erase, Ctrl-drag for a new one; [ and ] size it."),
    ),
    "split": (tr("Spli&t"), tr("Click one half of an object, then the other: it is split at the neck between them.")),
    "region": (
        tr("Region of &interest"),
        tr("Drag a box, or click corner by corner, around the region that particles must stay in, through all slices."),
    ),
    "barrier": (
        tr("&Barrier"),
        tr("Drag, or click corner by corner, to draw a line that no particle crosses, through all slices."),
    ),
}
"""Names of actions that do something else in a volume -> their text and tip there."""

ICONS_IN_VOLUMES = {"ellipse": "box"}
"""Names of actions with another icon in a volume -> its name."""


def has_volume(situation: Situation) -> bool:
    """Tell whether a volume is open."""
    return situation.document.has_volume


MIN_ESTIMATE_TIME = 1.0
"""Shortest time after which an estimate is shown [s]."""

_MIN_ESTIMATE_FRACTION = 0.02
"""Smallest fraction of the work from which an estimate is shown."""


def estimate_seconds_left(elapsed: float, fraction: float | None) -> float | None:
    """Estimate the remaining time [s] after `elapsed` seconds for a `fraction` from 0 to 1; None while unknown."""
    if fraction is None or fraction < _MIN_ESTIMATE_FRACTION or elapsed < MIN_ESTIMATE_TIME:
        return None
    return elapsed * (1.0 - min(fraction, 1.0)) / fraction


def format_remaining_time(seconds: float | None) -> str:
    """Format a remaining time [s]; empty when it is not known."""
    if seconds is None:
        return ""
    if seconds < 10.0:
        return tr("a few seconds left")
    if seconds < 100.0:
        return tr("about {seconds} s left", seconds=5 * round(seconds / 5))
    if seconds < 6000.0:
        return tr("about {minutes} min left", minutes=round(seconds / 60))
    return tr("about {hours} h left", hours=round(seconds / 3600))
