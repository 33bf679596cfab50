"""The engine: starts a run, takes its steps by the law for an image or a volume, and finds contours or surfaces.

``Engine(image, parameters)`` prepares the fields; ``start`` makes the first state of a run; ``step`` makes the next one
from any state, without memory of its own, so that a run can be paused, changed, replayed and branched.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.field.placed_charges import PlacedCharge, check_charges
from cpm_core.field.scale_field import ScaleField
from cpm_core.image.image import Image
from cpm_core.image.volume_regions import AnyRegions, plane_regions
from cpm_core.model import interventions
from cpm_core.model.image_fields import FieldMeasure, ImageFields
from cpm_core.model.measures import Energies, Forces
from cpm_core.model.plane import step as plane
from cpm_core.model.plane.state import PlaneState
from cpm_core.model.starts import check_seeds
from cpm_core.model.state import State
from cpm_core.model.volume import step as volume
from cpm_core.model.volume.state import VolumeState
from cpm_core.numerics.types import Array, Mask, Texts
from cpm_core.parameters import PARAMETERS, SKELETON_PARAMETERS, Parameters
from cpm_core.parameters.choices import CHOICE_PARAMETERS
from cpm_core.parameters.formatting import format_count, format_repr, format_size
from cpm_core.parameters.provenance import select_parameters
from cpm_core.results.result import Result, describe_origin
from cpm_core.segmentation.finer_scale import drop_explained_seeds, thin_seeds
from cpm_core.segmentation.local_fields import LocalFields
from cpm_core.segmentation.outcome import find_state_contours, find_state_surface


class _Law(NamedTuple):
    """What differs between a run in an image and one in a volume: the class of states, and how each value is computed.

    The functions take a `ScaleField` in an image and a `VolumeField` in a volume.
    """

    state: type[State]
    step: Callable[..., State]
    forces: Callable[..., Forces]
    energies: Callable[..., Energies]
    result: Callable[..., Result]


_LAW_BY_AXES: Mapping[int, _Law] = MappingProxyType(
    {
        2: _Law(PlaneState, plane.step_in_plane, plane.plane_forces, plane.plane_energies, find_state_contours),
        3: _Law(VolumeState, volume.step_in_volume, volume.volume_forces, volume.volume_energies, find_state_surface),
    }
)
"""Law of a run by the number of axes of its image."""


class Engine(ImageFields, interventions.ParticleMethod):
    """The charged-particle model on one image: a `Method` whose states are `State`.

    `ImageFields` describes image, parameters and regions and the errors that they raise. In a volume positions are
    (plane, row, col) in voxels.

    Examples
    --------
    >>> engine = cpm.Engine(cpm.example("disk"), cpm.Parameters())
    >>> state = engine.start(cpm.circle((32, 32), 8))
    >>> while not state.stop_reason:
    ...     state = engine.step(state, cpm.Parameters())
    >>> engine.result(state, cpm.Parameters())
    <Result disk, 1 contour (1 closed), 81 particles, at rest after 103 steps>
    >>> engine.forces(state, cpm.Parameters())
    <Forces on 81 particles>
    >>> engine.measure_state(state, cpm.Parameters())["count"] == state.count
    True
    >>> engine.energies(state, cpm.Parameters()).kinetic < 1e-3
    True
    >>> engine.add_particles(state, [(10, 10)]).count - state.count
    1
    >>> engine.erase_particles(state, state.position[:, 0] < 32).count < state.count
    True
    >>> engine.can_start(cpm.Parameters()), engine.scales
    (True, 3)
    >>> engine.steering(cpm.Parameters()) == cpm.Parameters().steering
    True
    >>> edges, force = engine.edge_map(cpm.Parameters()), engine.force_field(cpm.Parameters())
    >>> edges.shape, force.shape, engine.potential(cpm.Parameters()).shape
    ((64, 64), (2, 64, 64), (64, 64))
    >>> engine.scale_field(cpm.Parameters()).edge_map.shape, engine.start_area(state.start, cpm.Parameters()) is None
    ((64, 64), True)
    >>> half = engine.with_regions(cpm.Regions(interest=[[(0, 0), (63, 0), (63, 31), (0, 31)]]))
    >>> half.regions
    <Regions 1 region of interest, 0 barriers>
    """

    name: ClassVar[str] = "cpm"
    title: ClassVar[str] = "Charged particles"
    parameters: ClassVar[Texts] = tuple(
        name for name in (*PARAMETERS, *CHOICE_PARAMETERS) if name not in SKELETON_PARAMETERS
    )
    seeded: ClassVar[bool] = True

    def __init__(
        self,
        values: ArrayLike | Image,
        parameters: Parameters | str | None = None,
        regions: AnyRegions | None = None,
        measured: FieldMeasure | None = None,
    ) -> None:
        super().__init__(values, parameters, regions, measured)
        self._law = _LAW_BY_AXES[self.image.ndim]
        self._local_fields = LocalFields(self.scale_field, plane_regions(regions))

    def with_regions(self, regions: AnyRegions | None) -> Self:
        """Return this engine with other regions; see `ImageFields.with_regions`."""
        other = super().with_regions(regions)
        other._local_fields = LocalFields(other.scale_field, plane_regions(regions))
        return other

    def start_area(self, start: Array, parameters: Parameters) -> Mask | None:
        """Return the area of a start, shape (N, 2) [px], as a mask, shape (H, W); None where a run has no limit.

        Outside of it a front creeps only for a while; see `Parameters.reach`.
        """
        area = None if self.image.ndim == 3 else self._local_fields.area_of(start, parameters)
        return None if area is None else area.inside

    @staticmethod
    def steering(parameters: Parameters) -> tuple[object, ...]:
        """Return the values that a step depends on; see `Method.steering`."""
        return parameters.steering

    def start(self, seeds: ArrayLike) -> State:
        """Return the first state of a run.

        Parameters
        ----------
        seeds : array_like, shape (N, 2)
            Positions (row, col) [px]; those outside the image or the regions of interest, and those on a barrier, are
            left out.

        Returns
        -------
        State
            Particles at rest on the coarsest scale.

        Raises
        ------
        ValueError
            When there is no particle, or none inside the image and the regions of interest.
        """
        points = check_seeds(seeds, self.image.shape, self.regions)
        first = self._law.state.from_seeds(points, self.image, self.scales, self.regions)
        return thin_seeds(interventions.start_scale(first, self.scales - 1, self.regions))

    def step(self, state: State, parameters: Parameters, charges: Sequence[PlacedCharge] = ()) -> State:
        """Advance a run by one time step.

        Parameters
        ----------
        state : State
            Any state of a run on this image.
        parameters : Parameters
            Effective at once, `scales` from the next start. Values that differ from the last step's reactivate all
            particles.
        charges : sequence of PlacedCharge, optional
            Effective at once. One that is added, removed or moved reactivates the particles within its old and new
            reach; a run that has ended continues from `State.resume`.

        Returns
        -------
        State
            The next state: the same one if the run has stopped. A state of an engine with other regions continues with
            the particles inside the regions of this one.
        """
        if state.stop_reason:
            return state
        state = interventions.apply_interventions(state, self.regions, parameters, charges).widen_window()
        field = self._field_with(self._field_of(state, parameters), state.scale, state.charges)
        after = self._law.step(state, field, self.regions, parameters)
        if after.scale == state.scale:
            return after
        return drop_explained_seeds(after, self._field_of(after, parameters))

    def forces(
        self,
        state: State,
        parameters: Parameters,
        charges: Sequence[PlacedCharge] = (),
        index: ArrayLike | None = None,
    ) -> Forces:
        """Compute the forces on the particles of a state, with which a step from it begins; each of shape (M, D).

        Parameters
        ----------
        state : State
            A state of a run on this image.
        parameters : Parameters
            Of the step.
        charges : sequence of PlacedCharge, optional
            Of the step.
        index : array_like of int, optional
            Indices of particles in the order of `state.position`; by default all.

        Returns
        -------
        Forces
            In the order of `index`. As exact as in a step: near pairs in single precision (2e-4 of a unit force),
            distant particles by a mesh that is used for four steps (see `mesh_force`). A step also extrapolates the
            force, eq. (15), integrates the damping exactly and applies friction along the edge at once; these are not
            forces.
        """
        asked = np.arange(state.count) if index is None else np.atleast_1d(np.asarray(index, dtype=np.int64))
        changed = interventions.apply_interventions(state, state.regions, parameters, charges)
        field = self._field_of(state, parameters)
        charged = self._field_with(field, state.scale, changed.charges)
        return self._law.forces(changed, field, charged, parameters, asked)

    def energies(self, state: State, parameters: Parameters, charges: Sequence[PlacedCharge] = ()) -> Energies:
        """Compute kinetic and potential energy of the particles of a state, as defined in `cpm_core.model.measures`.

        The potential of the fixed charges is computed at the first call for a scale and cached with the field.
        """
        placed = replace(state, charges=check_charges(charges, self.image.ndim))
        return self._law.energies(placed, self._field_of(state, parameters), parameters)

    def result(self, state: State, parameters: Parameters) -> Result:
        """Compute contours and metrics of any state of a run.

        Parameters
        ----------
        state : State
            A state of a run on this image.
        parameters : Parameters
            For the reconstruction.

        Returns
        -------
        Result
            In px of the image.
        """
        found = self._law.result(state, self.image, self._field_of(state, parameters), parameters)
        origin = describe_origin(self.name, self.image, state, select_parameters(parameters, self.parameters))
        return replace(found, provenance=origin)

    def _field_of(self, state: State, parameters: Parameters) -> ScaleField:
        """Return the fields of the scale of a state, limited to the area of its start."""
        return self._local_fields.field_at(state.scale, state.start, parameters, state.window)

    def __repr__(self) -> str:
        return format_repr(
            "Engine", self.image.source, format_size(self.image.shape, ""), format_count(self.scales, "scale")
        )
