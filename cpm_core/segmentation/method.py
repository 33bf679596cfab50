"""The interface of methods that find contours, and the table of all methods.

All code that runs, records or shows a method uses only this interface. A new method is a module and an entry in
`RUN_METHODS`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, ClassVar, Protocol, Self, TypeVar, runtime_checkable

from numpy.typing import ArrayLike

from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.image.image import Image
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.medial_axis.skeleton import Skeleton
from cpm_core.medial_axis.skeleton_method import SkeletonMethod
from cpm_core.model.interventions import ParticleSelection
from cpm_core.model.measures import Forces
from cpm_core.model.state import Particles
from cpm_core.numerics.types import Array, Numbers, Texts
from cpm_core.parameters import Parameters
from cpm_core.parameters.formatting import quote_value
from cpm_core.published import Published
from cpm_core.results.result import Result
from cpm_core.segmentation.engine import Engine


class MethodState(Protocol):
    """State of a run: frozen, and complete input of the next step besides image and parameters."""

    @property
    def step(self) -> int:
        """Number of steps so far."""

    @property
    def scale(self) -> int:
        """Scale of the image pyramid, 0 for the image itself."""

    @property
    def steering(self) -> tuple[object, ...]:
        """`Method.steering` of the last step; empty before the first."""

    @property
    def particles(self) -> Particles:
        """The moving points with identities, velocities and forces; empty where a method has none."""

    @property
    def position(self) -> Array:
        """Positions of the points, shape (N, 2) [px of the image]."""

    @property
    def count(self) -> int:
        """Number of points."""

    @property
    def stop_reason(self) -> str:
        """Why the run ended, in words; empty while it continues."""

    @property
    def converged(self) -> bool:
        """Whether the run ended with a result."""

    def list_arrays(self) -> Sequence[Numbers]:
        """Return the arrays that take up memory, without those that all states of a run share."""

    def resume(self) -> Self:
        """Return this state as one of a running run, to continue with other parameters."""


S = TypeVar("S", bound=MethodState)
"""State of a method."""


class Method(Protocol[S]):
    """Way to find contours in one image, step by step.

    Attributes
    ----------
    name : str
        Key in `RUN_METHODS`.
    title : str
        Name for the user.
    parameters : tuple of str
        The `PARAMETERS` that have an effect.
    seeded : bool
        Whether a run starts from seeds, and responds to charges, regions and further seeds.
    image : Image
        The image.

    Examples
    --------
    >>> {"cpm", "published", "skeleton", "snake", "gvf", "geodesic"} <= set(cpm.METHODS)
    True
    >>> image, parameters = cpm.example("disk"), cpm.Parameters()
    >>> method = cpm.METHODS["cpm"](image, parameters)
    >>> method.seeded, method.regions, method.can_start(parameters)
    (True, None, True)
    >>> state = method.step(method.start(cpm.circle((32, 32), 8)), parameters)
    >>> method.result(state, parameters).steps
    1
    >>> method.measure_state(state, parameters)["count"] == state.count
    True
    >>> method.edge_map(parameters).shape, method.force_field(parameters).shape, method.potential(parameters).shape
    ((64, 64), (2, 64, 64), (64, 64))
    >>> method.with_regions(cpm.Regions(barriers=[[(0, 32), (63, 32)]])).regions
    <Regions 0 regions of interest, 1 barrier>
    >>> method.steering(parameters) == parameters.steering
    True
    """

    name: ClassVar[str]
    title: ClassVar[str]
    parameters: ClassVar[Texts]
    seeded: ClassVar[bool]
    image: Image

    @property
    def regions(self) -> AnyRegions | None:
        """Regions of interest and barriers."""

    def __init__(
        self, values: ArrayLike | Image, parameters: Parameters | str | None = None, regions: Any = None
    ) -> None: ...

    @staticmethod
    def steering(parameters: Parameters) -> tuple[object, ...]:
        """Return the values of the parameters that a step depends on; a run continues when they change."""

    def can_start(self, parameters: Parameters) -> bool:
        """Return whether a run with these parameters can start; if not, a new method object is needed."""

    def with_regions(self, regions: Any) -> Self:
        """Return this method with other regions, which can continue a run."""

    def start(self, seeds: ArrayLike) -> S:
        """Return the first state of a run from points, shape (N, 2) [px]."""

    def step(self, state: S, parameters: Parameters, charges: Sequence[PlacedCharge] = ()) -> S:
        """Return the next state, computed from this one alone; the same one if the run has stopped."""

    def result(self, state: S, parameters: Parameters) -> Result | Skeleton:
        """Return the contours of a state."""

    def measure_state(self, state: S, parameters: Parameters) -> Mapping[str, float]:
        """Return the metrics of a state by name, for plots and the status."""

    def edge_map(self, parameters: Parameters) -> Array:
        """Return the edge strength on the pixels of the image, shape (H, W)."""

    def force_field(self, parameters: Parameters, scale: int = 0, charges: Sequence[PlacedCharge] = ()) -> Array:
        """Return the field that attracts points to edges, on the pixels of a scale, shape (2, H, W)."""

    def potential(self, parameters: Parameters, charges: Sequence[PlacedCharge] = ()) -> Array:
        """Return the potential of the field on the pixels of the image, shape (H, W)."""


@runtime_checkable
class Steerable(Method[S], Protocol[S]):
    """Method whose points can be added, erased and examined during a run."""

    def add_particles(self, state: S, seeds: ArrayLike) -> S:
        """Add points to a run."""

    def erase_particles(self, state: S, inside: ParticleSelection) -> S:
        """Remove points from a run."""

    def forces(
        self,
        state: S,
        parameters: Parameters,
        charges: Sequence[PlacedCharge] = (),
        index: ArrayLike | None = None,
    ) -> Forces:
        """Return the forces on points of a state, shape (N, D); `index`, shape (M,), selects some of them."""


_known_run_methods: dict[str, type[Method[Any]]] = {
    method.name: method for method in (Engine, Published, SkeletonMethod)
}

RUN_METHODS: Mapping[str, type[Method[Any]]] = MappingProxyType(_known_run_methods)
"""All methods that run step by step, by name."""


def register_run_method(method: type[Method[Any]]) -> None:
    """Add a class to `RUN_METHODS`; ValueError where it lacks one of the attributes of `Method`."""
    wanted = {name for name in (*Method.__annotations__, *vars(Method)) if not name.startswith("_")}
    if missing := sorted(name for name in wanted - {"image", "regions"} if not hasattr(method, name)):
        raise ValueError(f"{quote_value(method)} is no method, since it has no {missing[0]}: see cpm_core.Method.")
    _known_run_methods[method.name] = method
