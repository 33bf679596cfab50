"""The interface of methods that are compared: the start, settings, the states of a run, a description.

A method is a function that takes image, start and settings and gives the states of a run, one after the other. It is
described by a `ContourMethod`, which is all that the command line and the benchmark know of it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import field, fields
from functools import cached_property, partial
from typing import Any, Generic, TypeVar

import numpy as np
import scipy
import skimage
from numpy.typing import NDArray

from cpm_core.contours.contour import Contour
from cpm_core.contours.rasterize import check_plane_shape
from cpm_core.field.edge_map import edge_map
from cpm_core.image.image import Image
from cpm_core.numerics.polyline import resample_path
from cpm_core.numerics.real_numbers import as_real_array
from cpm_core.numerics.types import NO_POINTS, Array, Arrays, Extent, Mask, frozen, record
from cpm_core.parameters import Parameters
from cpm_core.parameters.formatting import format_count, format_repr, quote_value

START_SPACING = 2.0
"""Distance of the points that a start gives along its outlines [px]."""

_MIN_CORNERS = 3
"""Least number of corners of an outline."""

_MAX_CORNER_DISTANCE = 1e6
"""Distance of a corner from the first pixel up to which it is usable [px]."""


@record
class Start:
    """Closed outlines from which every method begins.

    Attributes
    ----------
    outlines : tuple of ndarray, each of shape (K, 2)
        Corners (row, col) [px]; the last is joined to the first, which is not repeated.
    around : bool
        Whether the start lies around the objects, so that what drives a contour on must drive it inwards.

    Raises
    ------
    ValueError
        When there are no outlines, or one has fewer than three corners or corners at no usable place.

    Examples
    --------
    >>> start = cpm.Start((cpm.circle((32, 32), 8),))
    >>> start
    <Start 1 outline, inside the objects>
    >>> start.pressure_sign, start.points.shape, len(start.sample_curves(4.0)), int(start.mask((64, 64)).sum())
    (1.0, (26, 2), 1, 194)
    """

    outlines: Arrays
    around: bool = False

    def __post_init__(self) -> None:
        if not isinstance(self.outlines, Iterable):
            raise ValueError(f"outlines is {quote_value(self.outlines)} but must be a sequence of outlines.")
        made = tuple(as_real_array(outline) for outline in self.outlines)
        object.__setattr__(self, "outlines", made)
        if not made:
            raise ValueError("There is no start: draw a circle, an ellipse or a polygon, from which all methods begin.")
        for outline in made:
            if not (np.abs(outline) <= _MAX_CORNER_DISTANCE).all():
                raise ValueError(
                    f"A corner of the start is not within {_MAX_CORNER_DISTANCE:g} px: choose one in the image."
                )
            if outline.ndim != 2 or outline.shape[1] != 2 or len(outline) < _MIN_CORNERS:
                raise ValueError(
                    f"An outline of the start has the shape {quote_value(outline.shape)} but must have three or more "
                    "corners (row, col)."
                )

    @property
    def pressure_sign(self) -> float:
        """Sign of a pressure that drives a contour on: 1 outwards, from inside the objects, -1 inwards."""
        return -1.0 if self.around else 1.0

    @cached_property
    def points(self) -> Array:
        """Points every `START_SPACING` along the outlines, shape (N, 2) [px]."""
        return np.concatenate(self.sample_curves(START_SPACING))

    def sample_curves(self, spacing: float) -> Arrays:
        """Sample each outline at equal distances of about `spacing`, each of shape (K, 2) [px]."""
        closed = (np.concatenate([outline, outline[:1]]) for outline in self.outlines)
        return tuple(resample_path(outline, spacing)[:-1] for outline in closed)

    def mask(self, shape: Extent) -> Mask:
        """Return the pixels inside at least one outline, shape (H, W); an outline inside others bounds a hole."""
        check_plane_shape(shape)
        found = np.zeros(shape, bool)
        masks = (skimage.draw.polygon2mask(shape, outline) for outline in self.outlines)  # type: ignore[no-untyped-call]
        different = {mask.tobytes(): mask for mask in masks}.values()  # a line that is drawn twice bounds no hole
        for mask in sorted(different, key=np.count_nonzero, reverse=True):
            found = found & ~mask if found[mask].all() else found | mask
        return found

    def __repr__(self) -> str:
        where = "around the objects" if self.around else "inside the objects"
        return format_repr("Start", format_count(len(self.outlines), "outline"), where)


Contours = tuple[Contour, ...]


def declare_setting(default: float, low: float, high: float) -> Any:
    """Declare a field of `Settings` by its default value and its range; a whole default allows whole values."""
    return field(default=default, metadata={"range": (low, high)})


@frozen
class Settings:
    """Values of the parameters of a method; a subclass is a frozen dataclass of fields made by `declare_setting`.

    Raises
    ------
    ValueError
        When a value lies outside its range; the message names the field, the value and the range.
    """

    def __post_init__(self) -> None:
        for setting in fields(self):
            value, (low, high) = getattr(self, setting.name), setting.metadata["range"]
            whole = isinstance(setting.default, int)
            real = isinstance(value, int | float) and not isinstance(value, bool)
            if not (real and low <= value <= high and (not whole or value == int(value))):
                kind = "a whole number" if whole else "a number"
                raise ValueError(f"{setting.name} is {quote_value(value)} but must be {kind} from {low:g} to {high:g}.")


def unit_gray(image: Image) -> Array:
    """Scale gray levels to the range from 0 to 1, of the shape of the image."""
    low, high = image.gray_range
    return (image.values - low) / max(high - low, 1e-300)


def unit_edges(image: Image, smoothing: float) -> Array:
    """Compute the edge map of the charged particles, divided by its largest value, shape (H, W)."""
    strength = edge_map(unit_gray(image), smoothing)
    return strength / max(float(strength.max()), 1e-300)


def signed_region_distance(inside: Mask) -> Array:
    """Compute the signed distance from the boundary of a region, shape (H, W), above 0 inside [px]."""
    edt = scipy.ndimage.distance_transform_edt
    return np.where(inside, edt(inside) - 0.5, 0.5 - edt(~inside))


@record
class ContourState:
    """A moment of the run of any method.

    Attributes
    ----------
    step : int
        Number of steps so far.
    compute_contours : callable
        Computes the contours.
    stop_reason : str
        Why the run ended, in words; empty while it continues.
    converged : bool
        Whether it ended because nothing moved any more.
    points : ndarray, shape (N, 2)
        Particles [px]; empty for a method that has none.

    Examples
    --------
    >>> method = cpm.CONTOUR_METHODS["chan_vese"]
    >>> start = cpm.Start((cpm.circle((32, 32), 8),))
    >>> state = next(method.evolve(cpm.example("disk"), start, method.settings()))
    >>> state.step, state.stop_reason, state.converged, len(state.contours), len(state.points)
    (0, '', False, 1, 0)
    """

    step: int
    compute_contours: Callable[[], Contours]
    stop_reason: str = ""
    converged: bool = False
    points: Array = field(default_factory=lambda: NO_POINTS)

    @cached_property
    def contours(self) -> Contours:
        """The contours [px], computed when they are asked for."""
        return self.compute_contours()


def build_region_state(
    values: NDArray[Any], level: float, step: int, stop_reason: str = "", converged: bool = False
) -> ContourState:
    """Build the state of a function on pixels, shape (H, W), that is above a level inside."""
    return ContourState(step, partial(trace_boundary, values, level), stop_reason, converged)


def trace_boundary(values: NDArray[Any], level: float) -> Contours:
    """Trace the boundary of the pixels of a function, shape (H, W), that lie above a level.

    Contours are closed, also at the border of the image, and the longest is the first.
    """
    inside = np.asarray(values, dtype=float) - level
    rimmed = np.pad(inside, 1, constant_values=-max(float(np.abs(inside).max(initial=0.0)), 1e-9))
    last = np.array(values.shape) - 0.5
    lines = skimage.measure.find_contours(rimmed, 0.0)  # type: ignore[no-untyped-call]
    rings = (np.clip(line[:-1] - 1.0, -0.5, last) for line in lines if len(line) > _MIN_CORNERS)
    return tuple(sorted((Contour(ring, closed=True) for ring in rings), key=lambda contour: -contour.length))


_REST_INTERVAL = 40
"""Steps over which the change of a front is measured."""

_MAX_REST_CHANGE = 0.002
"""Largest change over these steps of a front at rest, as a fraction of its pixels."""


def iterate_until_at_rest(functions: Iterable[NDArray[Any]], level: float, most_steps: int) -> Iterator[ContourState]:
    """Yield states of a front until it is at rest, vanishes, or has done `most_steps`.

    The front is where each of `functions`, shape (H, W), crosses a level.
    """
    before: NDArray[np.bool_] | None = None
    for step, values in enumerate(functions):
        inside = values > level
        reason, at_rest = "", False
        if not inside.any():
            reason = "nothing is left"
        elif inside.all():
            reason = "the contour has left the image"
        elif step >= most_steps:
            reason = f"stopped after {step} steps"
        elif step % _REST_INTERVAL == 0:
            front = sum(np.diff(inside, axis=axis).sum() for axis in range(2))
            at_rest = before is not None and bool((inside != before).sum() <= _MAX_REST_CHANGE * front)
            reason, before = "the contour is at rest" if at_rest else "", inside
        yield build_region_state(values, level, step, reason, at_rest)
        if reason:
            return


SettingsT = TypeVar("SettingsT")


@frozen
class ContourMethod(Generic[SettingsT]):
    """A method that finds contours from a start, as described for comparisons.

    Attributes
    ----------
    name : str
        Key in `CONTOUR_METHODS`, and name on the command line.
    title : str
        Name for the user.
    about : str
        One or two sentences on what moves it.
    reference : str
        Where it was published.
    settings : type
        Its parameters: a frozen dataclass whose defaults are the values that were tuned.
    evolve : callable
        ``evolve(image, start, settings)`` gives the states of a run, the first being the start itself, until one has a
        `stop_reason`. A later state never changes an earlier one.
    preset : settings, optional
        Its settings unless others are given; those of the class by default.

    Examples
    --------
    >>> method = cpm.CONTOUR_METHODS["chan_vese"]
    >>> method.title, method.defaults.__class__.__name__, method.of_particles
    ('Chan-Vese', 'ChanVeseSettings', False)
    """

    name: str
    title: str
    about: str
    reference: str
    settings: type[SettingsT]
    evolve: Callable[[Image, Start, SettingsT], Iterator[ContourState]]
    preset: SettingsT | None = None

    @property
    def defaults(self) -> SettingsT:
        """Its settings unless others are given."""
        return self.settings() if self.preset is None else self.preset

    @property
    def of_particles(self) -> bool:
        """Whether its settings are the parameters of a run of the particles."""
        return issubclass(self.settings, Parameters)

    def __repr__(self) -> str:
        return format_repr("ContourMethod", self.name, self.title)


AnyMethod = ContourMethod[Any]
