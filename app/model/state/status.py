"""How the run stands."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

Phase = Literal["empty", "ready", "running", "paused", "finished"]


@dataclass(frozen=True, slots=True)
class RunStatus:
    """How the run stands.

    Attributes
    ----------
    phase : {"empty", "ready", "running", "paused", "finished"}
        Without an image; with nothing started; stepping; stopped by hand; stopped by itself.
    busy : str
        What is being prepared meanwhile, empty when nothing is.
    stale : bool
        Whether the document's recipe differs from the one that the run started from.
    steered : bool
        Whether the run has ended and the document's parameters differ from those it ended with.
    method : str
        Name of the method that is run.
    steering : tuple
        `Method.steering` of the last step.
    step, count, scale : int
        Steps taken, particles, scale (0 is the image itself).
    epsilon : float
        Eq. (23); NaN before it is known.
    stop_reason : str
        Why the run stopped by itself.
    converged : bool
        Whether it stopped at rest.
    steps_per_second : float
        Measured speed of the run.
    closed, open : int
        Contours reconstructed so far.
    bridges : int
        Gaps in contours that were bridged.
    longest_bridge : float
        Length of the longest of them [px].
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

    @property
    def started(self) -> bool:
        """Whether a run has been begun."""
        return self.phase in ("running", "paused", "finished")

    @property
    def moved(self) -> bool:
        """Whether anything of a run has been seen: the very first one may have to wait for loops to be compiled."""
        return self.started and (self.step > 0 or self.count > 0)
