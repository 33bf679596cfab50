"""The seam for methods: what a way to find contours has, and all that there are.

Whatever runs a method, records it or shows it knows no more than this. A new method is a module of its own and a place
in `METHODS`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, ClassVar, Protocol, Self, TypeVar, runtime_checkable

from numpy.typing import ArrayLike, NDArray

from cpm_core.contours.result import Result
from cpm_core.dynamics.forces import Forces
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.image.image import Image
from cpm_core.image.regions import Regions
from cpm_core.medial_axis.skeleton import Skeleton, SkeletonMethod
from cpm_core.numerics.types import Array
from cpm_core.parameters import Parameters
from cpm_core.particles.state import Particles
from cpm_core.segmentation.engine import Engine
from cpm_core.segmentation.interventions import Chosen


class MethodState(Protocol):
    """A moment of a run of any method: frozen, and all that the next step depends on besides image and parameters."""

    @property
    def step(self) -> int:
        """Steps done in all."""

    @property
    def scale(self) -> int:
        """Level of the image pyramid that it works on, 0 for the image itself."""

    @property
    def steering(self) -> tuple[object, ...]:
        """`Method.steering` of the last step; empty before the first."""

    @property
    def particles(self) -> Particles:
        """The points that move, with their numbers, velocities and forces; none where a method moves none."""

    @property
    def position(self) -> Array:
        """Where they are, shape (N, 2) [px of the image]."""

    @property
    def count(self) -> int:
        """Number of them."""

    @property
    def stop_reason(self) -> str:
        """Why the run ended, in words; empty while it goes on."""

    @property
    def converged(self) -> bool:
        """Whether it ended with what the method looks for."""

    def arrays(self) -> Sequence[NDArray[Any]]:
        """The arrays that keeping it costs, without those that all states of a run have in common."""

    def resumed(self) -> Self:
        """Return this state as one that goes on, for other parameters to act on."""


S = TypeVar("S", bound=MethodState)


class Method(Protocol[S]):
    """A way to find contours in one image, step by step.

    Attributes
    ----------
    name : str
        Its key in `METHODS`.
    title : str
        Name for people.
    parameters : tuple of str
        Which of `PARAMETERS` matter.
    seeded : bool
        Whether a run starts from seeds, and obeys charges, regions and seeds that come later.
    image : Image
        What it works on.
    regions : Regions or None
        Regions of interest and barriers.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    parameters: ClassVar[tuple[str, ...]]
    seeded: ClassVar[bool]
    image: Image
    regions: Regions | None

    def __init__(
        self, values: ArrayLike | Image, parameters: Parameters | None = None, regions: Regions | None = None
    ) -> None: ...

    @staticmethod
    def steering(parameters: Parameters) -> tuple[object, ...]:
        """Values of those parameters that a step obeys: a run that has ended goes on when they are others."""

    def suits(self, parameters: Parameters) -> bool:
        """Whether a run with these parameters can start; if not, another one has to be made for the image."""

    def with_regions(self, regions: Regions | None) -> Self:
        """The same for other regions, in which a state of a run can be stepped on."""

    def start(self, seeds: ArrayLike) -> S:
        """First state of a run from points, shape (N, 2) [px]."""

    def step(self, state: S, parameters: Parameters, charges: Sequence[PlacedCharge] = ()) -> S:
        """Next state, without memory of what was before; the same one if the run has stopped."""

    def result(self, state: S, parameters: Parameters) -> Result | Skeleton:
        """Contours of a state."""

    def measures(self, state: S, parameters: Parameters, thorough: bool = False) -> Mapping[str, float]:
        """Figures of a state by name, for plots and for the status; `thorough` adds those that take longer."""

    def positions(self, state: S) -> Array:
        """Points that are shown of a state, shape (N, 2) [px of the image]."""

    def edge_map(self, parameters: Parameters) -> Array:
        """Edge strength on the pixels of the image, shape (H, W)."""

    def field(self, parameters: Parameters, scale: int = 0, charges: Sequence[PlacedCharge] = ()) -> Array:
        """What draws points to edges on the pixels of a scale, shape (2, H, W)."""

    def potential(self, parameters: Parameters, charges: Sequence[PlacedCharge] = ()) -> Array:
        """Its potential on the pixels of the image, shape (H, W)."""


@runtime_checkable
class Steerable(Method[S], Protocol[S]):
    """A method in whose runs points can be added, erased and probed."""

    def joined(self, state: S, seeds: ArrayLike) -> S:
        """Put more points into a run."""

    def erased(self, state: S, inside: Chosen) -> S:
        """Take points out of a run."""

    def forces(
        self,
        state: S,
        parameters: Parameters,
        charges: Sequence[PlacedCharge] = (),
        index: ArrayLike | None = None,
    ) -> Forces:
        """Forces on points of a state."""


METHODS: Mapping[str, type[Method[Any]]] = MappingProxyType(
    {method.name: method for method in (Engine, SkeletonMethod)}
)
"""All methods by name."""
