"""State of the run."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from app.model.state.surface_figures import SurfaceFigures

Phase = Literal["empty", "ready", "running", "paused", "finished"]


@dataclass(frozen=True, slots=True)
class RunStatus:
    """State of the run.

    Attributes
    ----------
    phase : {"empty", "ready", "running", "paused", "finished"}
        No image; no run; stepping; stopped by the user; ended.
    busy : str
        What is being prepared, empty for nothing.
    stale : bool
        Whether a run from the document as it is now would begin otherwise than the existing one.
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
    closed, open : int
        Contours reconstructed so far.
    bridges : int
        Gaps in contours that were bridged.
    longest_bridge : float
        Length of the longest of them [px].
    length, thickness, width : float
        Of a skeleton: its length, the thickness that most of it stays below, the largest width that counted, 0 for any
        [px].
    polarity : int
        Of a skeleton: -1 if it is of what is dark, 1 of what is light, 0 of both.
    surface : SurfaceFigures or None
        Of a volume: figures of the surface that has been reconstructed last.
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
    closed: int = 0
    open: int = 0
    bridges: int = 0
    longest_bridge: float = 0.0
    length: float = 0.0
    thickness: float = 0.0
    width: float = 0.0
    polarity: int = 0
    surface: SurfaceFigures | None = None

    @property
    def started(self) -> bool:
        """Whether there is a run."""
        return self.phase in ("running", "paused", "finished")

    @property
    def moved(self) -> bool:
        """Whether particles have been shown; before the very first run the kernels may have to be compiled."""
        return self.started and (self.step > 0 or self.count > 0)
