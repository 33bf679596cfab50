"""Whole runs of methods, with the time that their steps take."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from cpm_core.contours.agreement import Comparison, compare
from cpm_core.contours.ground_truth import Truth
from cpm_core.contours.surface.agreement import SurfaceComparison, compare_surface
from cpm_core.contours.surface.ground_truth import VolumeTruth
from cpm_core.image.image import Image, as_image
from cpm_core.numerics.real_numbers import checked_number
from cpm_core.objects.methods.method import AnyMethod, ContourMethod, ContourState, Start
from cpm_core.parameters.quotation import counted, described, shown


@dataclass(frozen=True, eq=False)
class Moment:
    """A state of a run, and the time that it took to come there.

    Attributes
    ----------
    method : ContourMethod
        The method.
    state : ContourState
        The state.
    seconds : float
        Time for the preparation and all steps so far, without that of whoever looks at the states [s].
    """

    method: AnyMethod
    state: ContourState
    seconds: float

    def __repr__(self) -> str:
        return described("Moment", self.method.name, f"step {self.state.step}", f"{self.seconds:.3g} s")


def moments(method: AnyMethod, image: Image, start: Start, settings: Any = None) -> Iterator[Moment]:
    """Run a method step by step; `settings` are the defaults of the method unless given.

    Examples
    --------
    >>> start = cpm.Start((cpm.circle((32, 32), 8),))
    >>> for moment in cpm.moments(cpm.CONTOUR_METHODS["chan_vese"], cpm.example("disk"), start):
    ...     if moment.state.step == 3:
    ...         break
    >>> len(moment.state.contours), moment.seconds > 0
    (1, True)
    """
    if not isinstance(method, ContourMethod):
        raise ValueError(f"the method is {shown(method)} but must be one of CONTOUR_METHODS.")
    if not isinstance(start, Start):
        raise ValueError(f"the start is {shown(start)} but must be a Start: Start((outline,)).")
    settings = method.defaults if settings is None else settings
    if not isinstance(settings, method.settings):
        raise ValueError(
            f"the settings are {shown(settings)} but must be {method.settings.__name__}, those of {method.title}."
        )
    method.check()
    image = as_image(image)
    if image.ndim == 3 and not method.in_volumes:
        raise ValueError(f"{image.source} is a volume, but {method.title} is for images: choose another method.")
    if image.ndim != start.ndim:
        wanted = "spheres, Start((), spheres=(...,))" if image.ndim == 3 else "outlines, Start((outline,))"
        raise ValueError(f"The start does not fit {image.source}, which has {image.ndim} axes: give {wanted}.")
    states = method.evolve(image, start, settings)
    seconds = 0.0
    while True:
        began = time.perf_counter()
        state = next(states, None)
        seconds += time.perf_counter() - began
        if state is None:
            return
        yield Moment(method, state, seconds)


def run_method(
    method: AnyMethod, image: Image, start: Start, settings: Any = None, max_steps: int | None = None
) -> Moment:
    """The last moment of a whole run, or that after `max_steps`; the time includes that for the contours.

    Examples
    --------
    >>> start = cpm.Start((cpm.circle((32, 32), 8),))
    >>> moment = cpm.run_method(cpm.CONTOUR_METHODS["chan_vese"], cpm.example("disk"), start, max_steps=20)
    >>> len(moment.state.contours), moment.state.step
    (1, 20)
    """
    if max_steps is not None:
        checked_number(
            "max_steps", max_steps, lambda count: count >= 0 and count == int(count), "at least 0, and whole"
        )
    last = None
    for last in moments(method, image, start, settings):
        if last.state.step == max_steps:
            break
    if last is None:
        raise ValueError(f"{method.title} gave no state.")
    began = time.perf_counter()
    _ = last.state.contours, last.state.surface
    return Moment(method, last.state, last.seconds + time.perf_counter() - began)


@dataclass(frozen=True)
class Facts:
    """What a comparison says of one run; the last four are None where no ground truth is known.

    Attributes
    ----------
    method : str
        Name of the method.
    steps : int
        Number of steps.
    seconds : float
        Time of the run [s].
    converged : bool
        Whether it came to rest.
    stop_reason : str
        Why it ended.
    contours : int
        Number of contours, in a volume of parts of the surface.
    closed : int
        Number of closed ones among them, which alone have an area that overlaps another; in a volume all, if the
        surface is closed.
    dice, f : float or None
        Overlap of the areas, and agreement of the boundaries up to a tolerance.
    hausdorff, mean_distance : float or None
        Largest and mean distance of the boundaries [px], in a volume in the unit of its voxels.

    Examples
    --------
    >>> start = cpm.Start((cpm.circle((32, 32), 8),))
    >>> moment = cpm.run_method(cpm.CONTOUR_METHODS["cpm"], cpm.example("disk"), start)
    >>> result = cpm.segment(cpm.example("disk"), cpm.circle((32, 32), 8))
    >>> facts = cpm.facts_of(moment, cpm.Truth(result.labels, result.contours))
    >>> facts.method, facts.contours, facts.closed, round(facts.dice, 2), facts.f
    ('cpm', 1, 1, 1.0, 1.0)
    """

    method: str
    steps: int
    seconds: float
    converged: bool
    stop_reason: str
    contours: int
    closed: int = 0
    dice: float | None = None
    f: float | None = None
    hausdorff: float | None = None
    mean_distance: float | None = None

    def __repr__(self) -> str:
        agreed = "" if self.f is None else f"F {self.f:.3f}"
        steps, contours = counted(self.steps, "step"), counted(self.contours, "contour")
        return described("Facts", self.method, steps, f"{self.seconds:.3g} s", contours, agreed)


def facts_of(moment: Moment, truth: Truth | VolumeTruth | None = None) -> Facts:
    """What is said of a moment of a run, beside a ground truth where one is known.

    Examples
    --------
    >>> start = cpm.Start((cpm.circle((32, 32), 8),))
    >>> moment = cpm.run_method(cpm.CONTOUR_METHODS["cpm"], cpm.example("disk"), start)
    >>> cpm.facts_of(moment).contours
    1
    """
    if not isinstance(moment, Moment):
        raise ValueError(f"the moment is {shown(moment)} but must be one of a run: take those of `moments`.")
    state, surface = moment.state, moment.state.surface
    contours, closed = len(state.contours), sum(contour.closed for contour in state.contours)
    if surface is not None:
        contours = surface.components
        closed = contours if surface.closed else 0
    plain = Facts(moment.method.name, state.step, moment.seconds, state.converged, state.stop_reason, contours, closed)
    if isinstance(truth, VolumeTruth):
        sized = None if surface is None else replace(surface, spacing=truth.spacing, unit=truth.unit)
        return _beside(plain, compare_surface(sized, truth))
    return plain if truth is None else _beside(plain, compare(state.contours, truth))


def _beside(facts: Facts, seen: Comparison | SurfaceComparison) -> Facts:
    return replace(facts, dice=seen.dice, f=seen.f, hausdorff=seen.hausdorff, mean_distance=seen.mean_boundary_distance)
