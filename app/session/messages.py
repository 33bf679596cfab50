"""What goes down to the worker (commands) and what comes up from it (snapshots and reports)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from app.model.document import Document, Sown
from app.model.shades import Shades
from cpm_core.image import Image
from cpm_core.parameters import Parameters
from cpm_core.result import Result

Array = NDArray[np.float64]


# Commands: ordered, never lost.


@dataclass(frozen=True, slots=True)
class Open:
    """Read an image and prepare its engine; the image before stays when that fails."""

    generation: int
    path: Path
    parameters: Parameters
    otherwise: Path | None = None


@dataclass(frozen=True, slots=True)
class Start:
    """Begin a run from the drawing of a document, if the image it was drawn on is still the one in use."""

    generation: int
    image_generation: int
    document: Document


@dataclass(frozen=True, slots=True)
class Go:
    """Step until told otherwise, or `steps` times."""

    generation: int
    steps: int | None = None


@dataclass(frozen=True, slots=True)
class Halt:
    """Stop stepping and keep the particles."""


@dataclass(frozen=True, slots=True)
class Discard:
    """Stop stepping and forget the particles."""

    generation: int


@dataclass(frozen=True, slots=True)
class SetParameters:
    """Use these parameters from the next step on."""

    parameters: Parameters


@dataclass(frozen=True, slots=True)
class SetPace:
    """Take at most so many steps a second; None for no limit."""

    steps_per_second: float | None


@dataclass(frozen=True, slots=True)
class SetOverlays:
    """Keep the edge map and the field up to date for showing, or do not bother."""

    edge_map: bool
    field: bool


@dataclass(frozen=True, slots=True)
class Sow:
    """Find the positions from which a document starts all over the image, for showing them."""

    image_generation: int
    document: Document


@dataclass(frozen=True, slots=True)
class Export:
    """Reconstruct and write to a file whose suffix tells the format."""

    path: Path


@dataclass(frozen=True, slots=True)
class WarmUp:
    """Compile or load the kernels, so that the first step does not wait for them."""


@dataclass(frozen=True, slots=True)
class Quit:
    """End the thread."""


Command = Open | Start | Go | Halt | Discard | SetParameters | SetPace | SetOverlays | Sow | Export | WarmUp | Quit


# Snapshots: the newest wins.


@dataclass(frozen=True, eq=False, slots=True)
class Trace:
    """The run so far, for plots: arrays of equal length, one entry a step."""

    step: Array
    epsilon: Array
    count: Array


@dataclass(frozen=True, eq=False, slots=True)
class Snapshot:
    """The particles after a step, as the window shows them.

    Attributes
    ----------
    generation : int
        The run that it belongs to.
    position : ndarray, shape (N, 2)
        (row, col) in px of the image.
    resting : ndarray of bool, shape (N,)
        Particles that hardly move.
    step, scale : int
        Steps taken and current scale.
    epsilon : float
        Eq. (23).
    stop_reason : str
        Why the run ended, empty while it goes on.
    converged : bool
        Whether it ended at rest.
    steering : tuple
        `Parameters.steering` of the step.
    steps_per_second : float
        Measured speed.
    trace : Trace
        The run so far.
    """

    generation: int
    position: Array
    resting: NDArray[np.bool_]
    step: int
    scale: int
    epsilon: float
    stop_reason: str
    converged: bool
    steering: tuple[object, ...]
    steps_per_second: float
    trace: Trace


@dataclass(frozen=True, eq=False, slots=True)
class Reconstruction:
    """Contours of a recent snapshot."""

    generation: int
    result: Result


@dataclass(frozen=True, eq=False, slots=True)
class Overlays:
    """Shades of the edge map, shape (H, W), and field, shape (2, H, W); None for what is not asked for.

    They belong to the image that was opened as `generation`, whatever has been run on it since.
    """

    generation: int
    edge_map: Shades | None
    field: Array | None


# Reports: ordered, few.


@dataclass(frozen=True, eq=False, slots=True)
class Opened:
    """An image has been read and its engine is ready, with the parameters asked for as far as the image has room."""

    generation: int
    image: Image
    shades: Shades
    path: Path
    parameters: Parameters
    notes: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class NotOpened:
    """An image could not be used; everything is as before, and the user may be offered another one."""

    generation: int
    sentence: str
    otherwise: Path | None = None


@dataclass(frozen=True, slots=True)
class Failed:
    """A run could not start or go on."""

    generation: int
    sentence: str


@dataclass(frozen=True, eq=False, slots=True)
class Sowing:
    """Positions from which particles start all over the image opened as `generation`, or why there are none."""

    generation: int
    sown: Sown
    sentence: str = ""


@dataclass(frozen=True, slots=True)
class Exported:
    """A file has been written."""

    path: Path


@dataclass(frozen=True, slots=True)
class Trouble:
    """Something asked for did not work and nothing else changed."""

    sentence: str


@dataclass(frozen=True, slots=True)
class WarmedUp:
    """The kernels are ready."""


Report = Opened | NotOpened | Failed | Sowing | Exported | Trouble | WarmedUp
