"""The method `published`: the model of sections 3 to 5.4 to the letter, and no rule that the text does not have.

Both forces are normalized to unit vectors unless others are asked for. Of the three that can be chosen, only these
recover the comb of `docs/published.md` at the published values.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.field.convolution import convolved_potential
from cpm_core.field.interpolation import interpolate_field
from cpm_core.field.placed_charges import (
    PlacedCharge,
    charge_radius_at,
    charges_at_scale,
    check_charges,
    placed_forces,
)
from cpm_core.image.image import Image, as_image
from cpm_core.image.pyramid import build_pyramid, check_scales, shape_at_scale, to_image
from cpm_core.image.surface import Surface
from cpm_core.image.volume_regions import AnyRegions, check_regions
from cpm_core.model import EPSILON_BOUND, interventions
from cpm_core.model.measures import Forces
from cpm_core.model.starts import check_seeds, is_allowed, is_inside_image
from cpm_core.model.state import Particles, State
from cpm_core.numerics.types import Array, Arrays, Texts, copy_with
from cpm_core.parameters import Parameters, choose_parameters
from cpm_core.parameters.formatting import format_count, format_repr, format_size
from cpm_core.parameters.provenance import select_parameters
from cpm_core.published import dynamics
from cpm_core.published.crust import reconstruct_curve
from cpm_core.published.lorentz_force import FIELDS, NORMALIZATIONS, fixed_charges, minima_charges
from cpm_core.published.surface_from_points import reconstruct_surface
from cpm_core.results.result import Result, build_result, describe_origin

USUAL_SIGMA = 1.0
"""Width of the Gaussian where it is "auto", which the text does not have [px]."""


@dataclass(frozen=True, eq=False, repr=False)
class PublishedState(State):
    """State of a run as published, on an image or in a volume, with particles in px of their scale."""

    def begin_scale(self, scale: int, places: Array) -> Self:
        """Return the first state of a scale, with particles at rest at places of shape (N, D) [px of the scale]."""
        begun = super().begin_scale(scale, places)
        return replace(begun, particles=Particles.at_rest(places, self.next_identity))

    def reactivate_all(self) -> Self:
        """Return the state as it is: no particle is ever at rest for good."""
        return self

    def reactivate_near(self, charges: Array) -> Self:
        """Return the state as it is; charges have the shape (K, D + 1)."""
        return self


class Published(interventions.ParticleMethod):
    """The charged-particle model as published, on one image or volume: a `Method`.

    Lengths are in px along every axis. Particles that leave the image, or the regions of interest, are removed.

    Parameters
    ----------
    values : array_like, shape (H, W) or (P, H, W), or Image
        Image or volume.
    parameters : Parameters or str, optional
        For the number of scales.
    regions : Regions or VolumeRegions, optional
        Regions of interest and barriers.
    field : {"exact", "pppm"}
        How the field of the fixed charges is computed: by eq. (8), or by eq. (16) to (22).
    coulomb, lorentz : {"unit", "largest", "mean"}
        How each force is normalized: to unit vectors, or by the largest or the mean length.
    skeleton : bool
        Whether the fixed charges lie at the minima of the field of the edges (section 5.3).

    Raises
    ------
    ValueError
        For an unusable image, or one too small for the scales.

    Examples
    --------
    >>> published = cpm.METHODS["published"](cpm.example("disk"))
    >>> state = published.start(cpm.circle((32, 32), 8))
    >>> while not state.stop_reason:
    ...     state = published.step(state, cpm.Parameters())
    >>> published.result(state, cpm.Parameters()).converged
    True
    """

    name: ClassVar[str] = "published"
    title: ClassVar[str] = "As published"
    parameters: ClassVar[Texts] = (
        "beta", "w1", "w2", "annealing", "time_step", "d_min", "d_max", "smoothing", "scales", "channel",
    )  # fmt: skip
    seeded: ClassVar[bool] = True

    def __init__(
        self,
        values: ArrayLike | Image,
        parameters: Parameters | str | None = None,
        regions: AnyRegions | None = None,
        *,
        field: str = "exact",
        coulomb: str = "unit",
        lorentz: str = "unit",
        skeleton: bool = False,
    ) -> None:
        self.image, self.regions = as_image(values), regions
        self.scales = choose_parameters(parameters, Parameters()).scales
        check_scales(self.scales, self.image.shape)
        check_regions(regions, self.image.shape)
        self._choices: dict[str, Any] = {"field": field, "coulomb": coulomb, "lorentz": lorentz, "skeleton": skeleton}
        self._field, self._skeleton = FIELDS[field], skeleton
        self._normalize, self._normalize_lorentz = NORMALIZATIONS[coulomb], NORMALIZATIONS[lorentz]
        self._pyramid = lru_cache(1)(lambda channel: build_pyramid(self.image.gray_levels(channel), self.scales))
        self._fields = lru_cache(2 * self.scales)(self._compute_fields)

    @classmethod
    def steering(cls, parameters: Parameters) -> tuple[object, ...]:
        """Return the values that a step depends on; see `Method.steering`."""
        return tuple(getattr(parameters, name) for name in cls.parameters if name != "scales")

    def with_regions(self, regions: AnyRegions | None) -> Self:
        """Return the method with other regions."""
        check_regions(regions, self.image.shape)
        return copy_with(self, regions=regions)

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(type(self), **self._choices), (self.image, Parameters(scales=self.scales), self.regions)

    def start(self, seeds: ArrayLike) -> PublishedState:
        """Return the first state of a run from points, shape (N, D) [px], at the coarsest scale."""
        points = check_seeds(seeds, self.image.shape, self.regions)
        before = PublishedState.from_seeds(points, self.image, self.scales, self.regions)
        return self._begin_scale(before, self.scales - 1, points)

    def _begin_scale(self, state: PublishedState, scale: int, solution: Array) -> PublishedState:
        """Begin a scale with the solution of the coarser one alone, shape (N, D) [px of the image] (section 4.2)."""
        return state.begin_scale(scale, interventions.allowed_places(solution, scale, state.shape, self.regions))

    def step(
        self, state: PublishedState, parameters: Parameters, charges: Sequence[PlacedCharge] = ()
    ) -> PublishedState:
        """Return the state after one step of algorithm 1, and after the end of its scale or its run if that has come.

        Regions and placed charges act from the same step on.
        """
        if state.stop_reason:
            return state
        placed = check_charges(charges, self.image.ndim)
        state = replace(state, steering=self.steering(parameters), regions=self.regions, charges=placed)
        p, born, deleted = dynamics.advance(
            state.particles, self._lorentz_at(state, parameters) + self._placed_at(state),
            parameters.w1, parameters.w2, parameters.beta, parameters.time_step, parameters.d_min,
            parameters.d_max * state.annealed, self._normalize, state.next_identity,
        )  # fmt: skip
        inside = is_inside_image(p.position, shape_at_scale(state.shape, state.scale))
        p = p.keep(inside & is_allowed(to_image(p.position, state.scale, state.shape), self.regions))
        state = replace(
            state,
            particles=p,
            step=state.step + 1,  # line 9
            step_of_scale=state.step_of_scale + 1,
            annealed=state.annealed * parameters.annealing,  # line 8
            next_identity=state.next_identity + born,
            born=born,
            deleted=deleted,
            epsilon=dynamics.convergence(p.distance) if len(p) else math.nan,
            displacement=parameters.time_step * float(np.linalg.norm(p.velocity, axis=1).mean()) if len(p) else 0.0,
        )
        if not state.count:
            return state.stop("all particles left the image")
        if not state.epsilon < EPSILON_BOUND:  # line 10
            return state
        if state.scale:
            return self._begin_scale(state, state.scale - 1, state.position)
        return state.stop("at rest: the criterion of the publication holds", True)

    def result(self, state: PublishedState, parameters: Parameters) -> Result:
        """Return the crust of the particles, line 11: contours, or in a volume a surface."""
        plane = self.image.ndim == 2
        contours = reconstruct_curve(state.position) if plane else ()
        surface = None if plane else _surface_through(state.position, self.image)
        made = describe_origin(self.name, self.image, state, select_parameters(parameters, self.parameters))
        return build_result(state, self.image, parameters, contours=contours, surface=surface, provenance=made)

    def forces(
        self,
        state: PublishedState,
        parameters: Parameters,
        charges: Sequence[PlacedCharge] = (),
        index: ArrayLike | None = None,
    ) -> Forces:
        """Return the forces of eq. (12) on particles of a state, shape (M, D); `index` selects some of them."""
        state = replace(state, charges=check_charges(charges, self.image.ndim))
        chosen = np.arange(state.count) if index is None else np.atleast_1d(np.asarray(index, np.int64))
        coulomb = self._normalize(dynamics.coulomb_sums(state.particles.position).T).T
        parts = (
            parameters.w1 * coulomb, parameters.w2 * self._lorentz_at(state, parameters),
            parameters.w2 * self._placed_at(state), np.zeros(coulomb.shape),
            -parameters.beta * state.particles.velocity,
        )  # fmt: skip
        return Forces(*(part[chosen] for part in parts))

    def edge_map(self, parameters: Parameters) -> Array:
        r"""Return the size of the fixed charges, shape (\*shape)."""
        return -self._fields_at(parameters, 0)[0]

    def force_field(self, parameters: Parameters, scale: int = 0, charges: Sequence[PlacedCharge] = ()) -> Array:
        r"""Return ``F_l`` on the pixels of a scale, shape (D, \*shape), with the force of placed charges."""
        force = self._fields_at(parameters, scale)[1]
        places = np.moveaxis(np.indices(force.shape[1:], float), 0, -1)
        placed = charges_at_scale(check_charges(charges, self.image.ndim), scale, self.image.shape)
        return force + np.moveaxis(placed_forces(placed, charge_radius_at(scale), places), -1, 0)

    def potential(self, parameters: Parameters, charges: Sequence[PlacedCharge] = ()) -> Array:
        r"""Return the potential of the fixed charges on the pixels of the image, shape (\*shape)."""
        return convolved_potential(-self._fields_at(parameters, 0)[0], exponent=2.0)

    def _lorentz_at(self, state: PublishedState, parameters: Parameters) -> Array:
        """Interpolate the Lorentz force between the pixels, shape (N, D)."""
        return interpolate_field(self._fields_at(parameters, state.scale)[1], state.particles.position)

    def _placed_at(self, state: PublishedState) -> Array:
        return placed_forces(state.placed, charge_radius_at(state.scale), state.particles.position)

    def _fields_at(self, parameters: Parameters, scale: int) -> Arrays:
        smoothing = parameters.smoothing
        return self._fields(parameters.channel, USUAL_SIGMA if smoothing == "auto" else float(smoothing), scale)

    def _compute_fields(self, channel: str, sigma: float, scale: int) -> Arrays:
        """Return fixed charges and Lorentz force of a scale: part 1 of the algorithm."""
        e = fixed_charges(self._pyramid(channel)[scale], sigma)
        field = self._field(e)
        if self._skeleton:
            e = minima_charges(field)
            field = self._field(e)
        return e, self._normalize_lorentz(field)  # line 6

    def __repr__(self) -> str:
        size, scales = format_size(self.image.shape, ""), format_count(self.scales, "scale")
        return format_repr("Published", self.image.source, size, scales)


def _surface_through(points: Array, image: Image) -> Surface | None:
    """Return the surface through particles, shape (N, 3); None where they span none."""
    try:
        surface = reconstruct_surface(points)
    except ValueError:
        return None
    return replace(surface, spacing=image.spacing, unit=image.unit)
