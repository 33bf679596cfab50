"""What methods that are compared have in common: the start, the states of a run, and a description.

A method is a function that takes image, start and settings and gives the states of a run, one after the other. It is
described by a `ContourMethod`, which is all that the command line, the benchmark and the window know of it.
"""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Generic, Protocol, TypeVar

import numpy as np
import skimage
from numpy.typing import NDArray

from cpm_core.contours.contour import Contour
from cpm_core.contours.rasterize import check_plane
from cpm_core.contours.surface import Surface
from cpm_core.image.image import Image
from cpm_core.model.volume.starts import sphere
from cpm_core.numerics.polyline import resampled
from cpm_core.numerics.real_numbers import real_numbers
from cpm_core.numerics.types import Array, Mask
from cpm_core.parameters import Parameters
from cpm_core.parameters.quotation import counted, described, shown

SPACING = 2.0
"""Distance of the points that a start gives along its outlines [px]."""

_LEAST_CORNERS = 3
_FARTHEST = 1e6
"""Distance of a corner from the first pixel up to which it is usable [px]."""


@dataclass(frozen=True, eq=False)
class Start:
    """Closed outlines that a person has drawn: from these very lines every method begins.

    Attributes
    ----------
    outlines : tuple of ndarray, each of shape (K, 2)
        Corners (row, col) [px]; the last is joined to the first, which is not repeated.
    around : bool
        Whether the start lies around the objects, so that what drives a contour on must drive it inwards.
    spheres : tuple of (float, float, float, float)
        In a volume, in place of outlines: center (plane, row, col) [voxels] and radius [smallest side of a voxel].
    sides : tuple of float
        Sides of a voxel along (plane, row, col) in units of the smallest.

    Raises
    ------
    ValueError
        When there are neither outlines nor spheres, or both, an outline has fewer than three corners or corners at no
        usable place, or a sphere is not three places and a radius above 0.

    Examples
    --------
    >>> start = cpm.Start((cpm.circle((32, 32), 8),))
    >>> start
    <Start 1 outline, inside the objects>
    >>> start.ndim, cpm.Start((), spheres=((15, 15, 15, 4),)).ndim
    (2, 3)
    >>> start.onward, start.points.shape, len(start.curves(4.0)), int(start.mask((64, 64)).sum())
    (1.0, (26, 2), 1, 194)
    """

    outlines: tuple[Array, ...]
    around: bool = False
    spheres: tuple[tuple[float, float, float, float], ...] = ()
    sides: tuple[float, float, float] = (1.0, 1.0, 1.0)

    def __post_init__(self) -> None:
        if not isinstance(self.outlines, Iterable):
            raise ValueError(f"outlines is {shown(self.outlines)} but must be a sequence of outlines.")
        if not isinstance(self.around, bool | np.bool_):
            raise ValueError(f"around is {shown(self.around)} but must be True or False.")
        made = tuple(real_numbers(outline) for outline in self.outlines)
        several: Any = self.spheres
        several = tuple(several) if isinstance(several, Iterable) else (several,) if several else ()
        object.__setattr__(self, "spheres", several)
        if self.spheres:
            self._check_spheres(made)
        elif not made:
            raise ValueError("There is no start: draw a circle, an ellipse or a polygon, from which all methods begin.")
        for outline in made:
            if not np.isfinite(outline).all() or np.abs(outline).max(initial=0.0) > _FARTHEST:
                raise ValueError(f"A corner of the start is not within {_FARTHEST:g} px: choose one in the image.")
            if outline.ndim != 2 or outline.shape[1] != 2 or len(outline) < _LEAST_CORNERS:
                raise ValueError(
                    f"An outline of the start has the shape {shown(outline.shape)} but must have three or more corners "
                    "(row, col)."
                )
        object.__setattr__(self, "outlines", made)

    def _check_spheres(self, outlines: tuple[Array, ...]) -> None:
        if outlines:
            raise ValueError("A start has outlines in an image or spheres in a volume, not both: leave one out.")
        for given in self.spheres:
            numbers = real_numbers(given)
            if numbers.shape != (4,) or not (np.abs(numbers) <= _FARTHEST).all() or numbers[3] <= 0.0:
                raise ValueError(
                    f"A sphere is {shown(given)} but must be plane, row, column and a radius above 0, none beyond "
                    f"{_FARTHEST:g} voxels."
                )

    @property
    def ndim(self) -> int:
        """Number of axes of what it is a start in: 2 for an image, 3 for a volume."""
        return 3 if self.spheres else 2

    @property
    def onward(self) -> float:
        """Sign of a pressure that drives a contour on: 1 outwards, from inside the objects, -1 inwards."""
        return -1.0 if self.around else 1.0

    @cached_property
    def points(self) -> Array:
        """Points every `SPACING` along the outlines, shape (N, 2) [px]; on spheres, evenly spread, shape (N, 3)."""
        if self.spheres:
            return np.concatenate([sphere((p, r, c), radius, spacing=self.sides) for p, r, c, radius in self.spheres])
        return np.concatenate(self.curves(SPACING))

    def curves(self, spacing: float) -> tuple[Array, ...]:
        """Each outline with corners at equal distances of about `spacing` [px]."""
        closed = (np.concatenate([outline, outline[:1]]) for outline in self.outlines)
        return tuple(resampled(outline, spacing)[:-1] for outline in closed)

    def mask(self, shape: tuple[int, ...]) -> Mask:
        """The pixels inside one outline at least, shape (H, W); an outline that lies within others bounds a hole.

        Of spheres the voxels in one at least, shape (P, H, W).
        """
        found: NDArray[np.bool_] = np.zeros(shape, dtype=bool)
        for *center, radius in self.spheres:
            axes = zip(np.ogrid[tuple(map(slice, shape))], center, self.sides, strict=True)
            found |= sum((side * (at - middle)) ** 2 for at, middle, side in axes) <= radius**2
        if self.outlines:
            check_plane(shape)
        masks = (skimage.draw.polygon2mask(shape, outline) for outline in self.outlines)  # type: ignore[no-untyped-call]
        different = {mask.tobytes(): mask for mask in masks}.values()  # a line that is drawn twice bounds no hole
        for mask in sorted(different, key=np.count_nonzero, reverse=True):
            found = found & ~mask if found[mask].all() else found | mask
        return found

    def __repr__(self) -> str:
        where = "around the objects" if self.around else "inside the objects"
        what = counted(len(self.spheres), "sphere") if self.spheres else counted(len(self.outlines), "outline")
        return described("Start", what, where)


class ContourState(Protocol):
    """A moment of the run of any method.

    Examples
    --------
    >>> method = cpm.CONTOUR_METHODS["chan_vese"]
    >>> start = cpm.Start((cpm.circle((32, 32), 8),))
    >>> state = next(method.evolve(cpm.example("disk"), start, method.settings()))
    >>> state.step, state.stop_reason, state.converged, len(state.contours), state.surface, len(state.points)
    (0, '', False, 1, None, 0)
    """

    @property
    def step(self) -> int:
        """Number of steps so far."""

    @property
    def stop_reason(self) -> str:
        """Why the run ended, in words; empty while it continues."""

    @property
    def converged(self) -> bool:
        """Whether it ended because nothing moved any more."""

    @property
    def contours(self) -> tuple[Contour, ...]:
        """The contours [px], computed when they are asked for."""

    @property
    def surface(self) -> Surface | None:
        """The surface in a volume, computed when it is asked for; None in an image."""

    @property
    def points(self) -> Array:
        """Particles, shape (N, 2) [px] or (N, 3) [voxels]; empty for a method that has none."""


S = TypeVar("S")


@dataclass(frozen=True)
class Needed:
    """A package that a method needs and that need not be installed.

    Attributes
    ----------
    name : str
        Name by which it is imported.
    package : str
        Name by which it is installed.
    extra : str
        What of this program is installed with it.
    """

    name: str
    package: str
    extra: str

    @property
    def installed(self) -> bool:
        """Whether it is there."""
        return importlib.util.find_spec(self.name) is not None

    def module(self) -> Any:
        """The package itself, imported when it is needed first."""
        return importlib.import_module(self.name)


@dataclass(frozen=True)
class ContourMethod(Generic[S]):
    """A method that finds contours from a start, as those see it who compare methods.

    Attributes
    ----------
    name : str
        Key in `CONTOUR_METHODS`, and name on the command line.
    title : str
        Name for the user.
    about : str
        One or two sentences: what moves it.
    reference : str
        Where it was published.
    settings : type
        Its parameters: a frozen dataclass whose defaults are the values that were tuned.
    evolve : callable
        ``evolve(image, start, settings)`` gives the states of a run, the first being the start itself, until one has a
        `stop_reason`. A later state never changes an earlier one.
    most_steps : int
        Steps after which a run that is not at rest is ended.
    needs : Needed, optional
        A package that it needs and that need not be installed.
    in_volumes : bool
        Whether it finds surfaces in volumes as well.
    preset : settings, optional
        Its settings unless others are given; those of the class by default.

    Examples
    --------
    >>> method = cpm.CONTOUR_METHODS["chan_vese"]
    >>> method.title, method.defaults.__class__.__name__, method.most_steps, method.of_particles
    ('Chan-Vese', 'ChanVeseSettings', 500, False)
    >>> method.check()
    >>> method.missing == ""  # all that it needs is installed
    True
    """

    name: str
    title: str
    about: str
    reference: str
    settings: type[S]
    evolve: Callable[[Image, Start, S], Iterator[ContourState]]
    most_steps: int
    needs: Needed | None = None
    in_volumes: bool = False
    preset: S | None = None

    @property
    def defaults(self) -> S:
        """Its settings unless others are given."""
        return self.settings() if self.preset is None else self.preset

    @property
    def of_particles(self) -> bool:
        """Whether its settings are the parameters of a run of the particles."""
        return issubclass(self.settings, Parameters)

    def check(self) -> None:
        """ValueError, which says how it is installed, when a package is missing that it needs."""
        needs = self.needs
        if needs is not None and not needs.installed:
            raise ValueError(
                f"{self.title} needs the package {needs.package}: install it "
                f'(pip install "cpm-particles[{needs.extra}]").'
            )

    @property
    def missing(self) -> str:
        """What `check` says; empty where nothing is missing."""
        try:
            self.check()
        except ValueError as error:
            return str(error)
        return ""

    def __repr__(self) -> str:
        return described("ContourMethod", self.name, self.title)


AnyMethod = ContourMethod[Any]
