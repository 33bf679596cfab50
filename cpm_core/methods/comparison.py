"""All methods by name, whole runs, and the report on a run."""

from __future__ import annotations

import time
from collections import ChainMap
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from types import MappingProxyType
from typing import Any, TypeVar

from numpy.typing import ArrayLike

from cpm_core.contours.agreement import compare
from cpm_core.contours.contour import Contour, sample_contours
from cpm_core.contours.ground_truth import Truth
from cpm_core.field.edge_map import edge_map
from cpm_core.field.interpolation import interpolate_field
from cpm_core.image.image import Image, as_image
from cpm_core.methods.level_sets import GEODESIC, GEOMETRIC_GVF
from cpm_core.methods.method import AnyMethod, ContourMethod, ContourState, Start
from cpm_core.methods.particles import PARTICLE_METHOD, PROPOSED_OBJECT
from cpm_core.methods.regions import (
    CHAN_VESE,
    MORPHOLOGICAL_CHAN_VESE,
    MORPHOLOGICAL_GAC,
    RANDOM_WALKER,
)
from cpm_core.methods.snakes import GVF_SNAKE, SNAKE
from cpm_core.numerics.real_numbers import check_finite_number
from cpm_core.numerics.types import NO_POINTS, frozen, record
from cpm_core.parameters.formatting import format_choice, format_count, format_repr, quote_value
from cpm_core.parameters.provenance import Provenance
from cpm_core.results.result import Result
from cpm_core.segmentation.method import RUN_METHODS, Method, register_run_method

_ALL_METHODS = (
    PARTICLE_METHOD,
    PROPOSED_OBJECT,
    SNAKE,
    GVF_SNAKE,
    GEODESIC,
    GEOMETRIC_GVF,
    CHAN_VESE,
    MORPHOLOGICAL_GAC,
    MORPHOLOGICAL_CHAN_VESE,
    RANDOM_WALKER,
)

_known_contour_methods: dict[str, AnyMethod] = {method.name: method for method in _ALL_METHODS}

CONTOUR_METHODS: Mapping[str, AnyMethod] = MappingProxyType(_known_contour_methods)
"""All methods that can be compared, by name. A new one is a function with its settings, and a line above."""

METHODS: Mapping[str, type[Method[Any]] | AnyMethod] = MappingProxyType(
    ChainMap(RUN_METHODS, CONTOUR_METHODS)  # type: ignore[arg-type] # nothing is written
)
"""All methods by name: classes that run step by step, each a `Method`, and the classical ones for comparison."""

NewMethod = TypeVar("NewMethod", bound=type[Method[Any]] | AnyMethod)
"""A method to be registered."""


def register_method(method: NewMethod) -> NewMethod:
    """Add a method of your own to `METHODS`, so that it can be named like any other in this process.

    Parameters
    ----------
    method : type or ContourMethod
        A class with the attributes of `Method`, which `segment` and `evolve` then run by its name; or a method from a
        drawn start, which `run_method` runs by its name and comparisons list.

    Returns
    -------
    type or ContourMethod
        The method, so that this can be the decorator of a class.

    Raises
    ------
    ValueError
        When it is neither, or there is a method with its name.

    Examples
    --------
    >>> from dataclasses import replace
    >>> @cpm.register_method
    ... class Slow(cpm.Engine):
    ...     name, title = "slow", "Half the time step"
    ...     def step(self, state, parameters, charges=()):
    ...         return super().step(state, replace(parameters, time_step=0.25), charges)
    >>> cpm.segment(cpm.example("disk"), cpm.circle((32, 32), 8), method="slow").provenance.method
    'slow'
    """
    if getattr(method, "name", None) in METHODS:
        raise ValueError(f"there is a method with the name {quote_value(method.name)}: choose another name.")
    if isinstance(method, ContourMethod):
        _known_contour_methods[method.name] = method
    else:
        register_run_method(method)
    return method


@record
class MethodStep:
    """A state of a run, and the time until then.

    Attributes
    ----------
    method : ContourMethod
        The method.
    state : ContourState
        The state.
    seconds : float
        Time for the preparation and all steps so far, without the time that is spent on the states between steps [s].
    """

    method: AnyMethod
    state: ContourState
    seconds: float

    def __repr__(self) -> str:
        return format_repr("MethodStep", self.method.name, f"step {self.state.step}", f"{self.seconds:.3g} s")


def iterate_method(
    method: AnyMethod | str, values: ArrayLike | Image, start: Start, settings: Any = None
) -> Iterator[MethodStep]:
    """Run a method, or the one of `CONTOUR_METHODS` with a name, step by step; by default with its own settings.

    Examples
    --------
    >>> start = cpm.Start((cpm.circle((32, 32), 8),))
    >>> for moment in cpm.iterate_method("chan_vese", cpm.example("disk"), start):
    ...     if moment.state.step == 3:
    ...         break
    >>> len(moment.state.contours), moment.seconds > 0
    (1, True)
    """
    if isinstance(method, str):
        method = CONTOUR_METHODS.get(method, method)
    if not isinstance(method, ContourMethod):
        raise ValueError(f"method is {quote_value(method)} but must be {format_choice(str(method), CONTOUR_METHODS)}")
    if not isinstance(start, Start):
        raise ValueError(f"the start is {quote_value(start)} but must be a Start: Start((outline,)).")
    settings = method.defaults if settings is None else settings
    if not isinstance(settings, method.settings):
        raise ValueError(
            f"the settings are {quote_value(settings)} but must be {method.settings.__name__}, those of {method.title}."
        )
    image = as_image(values)
    if image.ndim == 3:
        raise ValueError(f"{image.source} is a volume, but methods are compared in images: take a slice of it.")
    began, seconds = time.perf_counter(), 0.0
    for state in method.evolve(image, start, settings):
        seconds += time.perf_counter() - began
        yield MethodStep(method, state, seconds)
        began = time.perf_counter()


def run_method(
    method: AnyMethod | str, values: ArrayLike | Image, start: Start, settings: Any = None, max_steps: int | None = None
) -> MethodStep:
    """Run a method, or the one with a name, to its end or to `max_steps`; its seconds include those for the contours.

    Examples
    --------
    >>> start = cpm.Start((cpm.circle((32, 32), 8),))
    >>> moment = cpm.run_method("chan_vese", cpm.example("disk"), start, max_steps=20)
    >>> len(moment.state.contours), moment.state.step
    (1, 20)
    """
    if max_steps is not None:
        check_finite_number(
            "max_steps", max_steps, lambda count: count >= 0 and count == int(count), "at least 0, and whole"
        )
    for last in iterate_method(method, values, start, settings):
        if last.state.step == max_steps:
            break
    began = time.perf_counter()
    _ = last.state.contours
    return replace(last, seconds=last.seconds + time.perf_counter() - began)


@frozen
class RunReport:
    """Report on one run of a method; the last four fields are None without a ground truth.

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
        Number of contours.
    closed : int
        Number of closed ones among them, which alone have an area that overlaps another.
    dice, f : float or None
        Overlap of the areas, and agreement of the boundaries up to a tolerance.
    hausdorff, mean_distance : float or None
        Largest and mean distance of the boundaries [px].

    Examples
    --------
    >>> start = cpm.Start((cpm.circle((32, 32), 8),))
    >>> moment = cpm.run_method(cpm.CONTOUR_METHODS["cpm"], cpm.example("disk"), start)
    >>> result = cpm.segment(cpm.example("disk"), cpm.circle((32, 32), 8))
    >>> facts = cpm.report_run(moment, cpm.Truth(result.labels, result.contours))
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
        steps, contours = format_count(self.steps, "step"), format_count(self.contours, "contour")
        return format_repr("RunReport", self.method, steps, f"{self.seconds:.3g} s", contours, agreed)


def report_run(moment: MethodStep, truth: Truth | None = None) -> RunReport:
    """Report on a step of a run, with its agreement with a ground truth where one is known.

    Examples
    --------
    >>> start = cpm.Start((cpm.circle((32, 32), 8),))
    >>> moment = cpm.run_method(cpm.CONTOUR_METHODS["cpm"], cpm.example("disk"), start)
    >>> cpm.report_run(moment).contours
    1
    """
    if not isinstance(moment, MethodStep):
        raise ValueError(
            f"the moment is {quote_value(moment)} but must be one of a run: take those of `iterate_method`."
        )
    state = moment.state
    closed = sum(contour.closed for contour in state.contours)
    facts = RunReport(
        moment.method.name,
        state.step,
        moment.seconds,
        state.converged,
        state.stop_reason,
        len(state.contours),
        closed,
    )
    if truth is None:
        return facts
    seen = compare(state.contours, truth)
    return replace(facts, dice=seen.dice, f=seen.f, hausdorff=seen.hausdorff, mean_distance=seen.mean_boundary_distance)


_STRENGTH_SMOOTHING = 1.0
"""Sigma of the Gaussian before the edge strength along the contours is measured [px]."""


def build_method_result(
    facts: RunReport, contours: Sequence[Contour], image: Image, start: Start, settings: Any
) -> Result:
    """Build a result from the contours that a method has found.

    The contours have numbers from 1 and the mean edge strength along them; there are no particles.
    """
    strength = edge_map(image.values, _STRENGTH_SMOOTHING) if contours else image.values
    numbered = []
    for number, contour in enumerate(contours, start=1):
        mean = float(interpolate_field(strength[None], sample_contours([contour])).mean())
        numbered.append(replace(contour, number=number, strength=mean))
    shapes = tuple({"shape": "polygon", "points": outline.tolist()} for outline in start.outlines)
    made = Provenance(
        facts.method, asdict(settings), None, shapes, sha256=image.sha256, of_file=bool(image.file_sha256)
    )
    place = image.shape, image.spacing, image.unit, image.source
    return Result(
        NO_POINTS,
        tuple(numbered),
        None,
        facts.steps,
        facts.converged,
        facts.stop_reason,
        *place,
        image=image,
        provenance=made,
    )
