"""Effects of parameter values, as numbers next to their sliders: from the state of a run and its contours."""

from __future__ import annotations

import math
from collections.abc import Mapping

from cpm_app.model.display.lengths import format_measured_length
from cpm_app.model.document.document import ImageReference
from cpm_app.model.parameters.controls import RATIO_CONTROL
from cpm_app.model.text.language import localize_number, tr
from cpm_core import Parameters, State
from cpm_core.model.equations import creeping_range
from cpm_core.model.plane.state import PlaneState
from cpm_core.model.volume.state import VolumeState
from cpm_core.parameters import UNLIMITED_REACH
from cpm_core.segmentation import MethodState

FILTER_PARAMETERS = ("min_strength", "min_length", "min_contrast")
"""Parameters that leave out contours."""

MOTION_PARAMETERS = ("beta", RATIO_CONTROL, "annealing")
"""Parameters of the motion of particles."""


def _is_limited(state: State, parameters: Parameters) -> bool:
    """Return whether fronts of a run creep only so far: in a volume, or out of the area of their start."""
    return isinstance(state, VolumeState) or (isinstance(state, PlaneState) and parameters.reach < UNLIMITED_REACH)


def measure_motion(state: State, parameters: Parameters, length: float) -> Mapping[str, float]:
    """Measure what each parameter of `MOTION_PARAMETERS` acts on [px of the image].

    Damping slows particles down: their mean motion in the last step. Repulsion spreads them: the `length` of all
    contours that they have found. Annealing ends insertion: how far a front creeps outside the area of its start or
    in a volume, and where the reach has no limit in an image, the widest gap that still gets a particle.
    """
    size, widest = 2.0**state.scale, creeping_range(parameters)
    if not _is_limited(state, parameters):
        widest = size * (parameters.d_min + min(state.annealed, parameters.annealing**state.idle) * parameters.d_max)
    return {"beta": size * state.displacement, RATIO_CONTROL: length, "annealing": widest}


def describe_effects(
    state: MethodState | None, parameters: Parameters, length: float, image: ImageReference | None
) -> Mapping[str, str]:
    """Return `measure_motion` in words, by the names of the parameters; empty where nothing is known."""
    words = dict.fromkeys(MOTION_PARAMETERS, "")
    if not isinstance(state, State) or not state.step or image is None:
        return words
    found = measure_motion(state, parameters, length)
    speed = tr("{speed} px per step", speed=localize_number(f"{found['beta']:.2f}"))
    words["beta"] = tr("at rest") if state.converged else speed
    if length:
        words[RATIO_CONTROL] = tr(
            "{length} of contours", length=format_measured_length(length, image.spacing, image.unit, 0)
        )
    far = tr("creeps up to {length} px") if _is_limited(state, parameters) else tr("fills gaps up to {length} px")
    words["annealing"] = far.format(length=localize_number(f"{found['annealing']:.1f}"))
    if math.isinf(found["annealing"]):
        words["annealing"] = tr("creeps without end")
    return words


def describe_contours_left(left: int, before: int | None) -> str:
    """Tell in words how many contours a filter leaves; `before` is their number before its slider moved."""
    if not left and before is None:
        return ""
    if before is None:
        return tr("1 contour") if left == 1 else tr("{count} contours", count=left)
    return tr("{before} → {after} contours", before=before, after=left)
