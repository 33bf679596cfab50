"""A state of a run as JSON: lossless, and checked when it is read, because compiled loops trust it.

Parameters, regions and charges follow from the actions of the run and are not repeated here.
"""

from __future__ import annotations

import math
from dataclasses import fields
from typing import Any, get_type_hints

import numpy as np
from numpy.typing import DTypeLike

from cpm_core.field.volume_field import pitch_of
from cpm_core.formats.common.json_values import (
    array_from_json,
    array_to_json,
    expect_mapping,
    expect_number,
    expect_text,
)
from cpm_core.image.pyramid import shape_at_scale
from cpm_core.model.coverage import COVERAGE_CELL, NEVER_COVERED, Coverage, SurfaceCoverage, no_coverage
from cpm_core.model.plane.repulsion import (
    MESH_PITCH,
    NO_MESH,
    MeshForce,
    mesh_corner,
    mesh_shape,
    softening_coefficients,
)
from cpm_core.model.plane.state import PlaneState
from cpm_core.model.starts import is_inside_image
from cpm_core.model.state import HISTORY_STEPS, Particles, State
from cpm_core.model.volume.state import VolumeParticles, VolumeState
from cpm_core.numerics.types import Extent, JsonDict, Numbers, Sides
from cpm_core.published import Published, PublishedState

_SCALAR_FIELDS = {name: kind for name, kind in get_type_hints(State).items() if kind in (int, float, bool, str)}
"""Fields of a state that are single values -> their type."""

_PARTICLE_ARRAYS = tuple(field.name for field in fields(Particles))
"""Arrays of the particles of any state."""

_MAX_STATE_NUMBER = 2**40
"""Largest magnitude of such a value."""


def state_to_json(state: State) -> JsonDict:
    """Convert a state to JSON; values that are not finite become null."""
    known = {name: kind(getattr(state, name)) for name, kind in _SCALAR_FIELDS.items()}
    plain = {name: None if isinstance(one, float) and not math.isfinite(one) else one for name, one in known.items()}
    arrays: dict[str, Numbers] = {"start": state.start}
    arrays |= {name: getattr(state.particles, name) for name in _PARTICLE_ARRAYS}
    if isinstance(state, VolumeState):
        particles = state.particles
        arrays |= {"normal": particles.normal, "seated": particles.on_surface.astype(np.int32)}
        arrays |= {"strength": particles.strength, "woken": particles.reactivated_at, "covered": state.coverage.cells}
        plain["side"] = state.coverage.side
    elif isinstance(state, PlaneState):
        arrays |= {"found": state.coverage.found, "latest": state.coverage.latest}
        if state.window is not None:
            arrays["window"] = np.array([(side.start, side.stop) for side in state.window])
        if state.mesh is not None:
            plain["mesh"] = _mesh_to_json(state.mesh)
    elif isinstance(state, PublishedState):
        plain["method"] = Published.name
    return plain | {name: array_to_json(array) for name, array in arrays.items()}


def state_from_json(plain: object, shape: Extent, scales: int, spacing: Sides = ()) -> State:
    """Build the state of a run on an image of this shape and number of scales; ValueError when it is invalid.

    `spacing` is the voxel size of a volume; without it voxels are cubes.
    """
    given = expect_mapping(plain, "state")
    values = {name: _parse_scalar(kind, given.get(name), f"{name} of state") for name, kind in _SCALAR_FIELDS.items()}
    if not values["scale"] < scales:
        raise ValueError(f"scale of state is {values['scale']} but must be from 0 to {scales - 1}.")
    size, axes = shape_at_scale(shape, values["scale"]), len(shape)

    def read_array(name: str, dtype: DTypeLike, *sides: int | None) -> Numbers:
        found = array_from_json(given.get(name), dtype, sides, f"{name} of state")
        if np.isinf(found).any() or (name != "distance" and np.isnan(found).any()):
            raise ValueError(f"{name} of state contains a value that is not a number.")
        return found

    window = None
    if "window" in given:
        first, end = read_array("window", np.int64, axes, 2).T
        if (first < 0).any() or (first % COVERAGE_CELL != 0).any() or (end <= first).any() or (end > size).any():
            raise ValueError("window of state is no part of the image.")
        window, size = tuple(map(slice, first.tolist(), end.tolist())), tuple((end - first).tolist())
    identity = read_array("identity", np.int64, None)
    count = len(identity)
    position, start = read_array("position", float, count, axes), read_array("start", float, None, axes)
    velocity, force = read_array("velocity", float, count, axes), read_array("force", float, count, 2, axes)
    # states written before particles had it begin with none
    crept = read_array("crept", float, count) if "crept" in given else np.zeros(count)
    if (crept < 0.0).any():
        raise ValueError("crept of state contains a distance below 0.")
    arrays = position, velocity, force, read_array("distance", float, count, HISTORY_STEPS), identity, crept
    published = given.get("method") == Published.name
    pitch = pitch_of(spacing or (1.0,) * axes) if axes == 3 and not published else None
    for name, places, within in (("position", position / (pitch or 1.0), size), ("start", start, shape)):
        if not is_inside_image(places, within).all():
            raise ValueError(f"{name} of state contains a position outside the image.")
    if published:
        return PublishedState(Particles(*arrays), start, shape, **values)
    if pitch is not None:
        normal, seated = read_array("normal", float, count, 3), read_array("seated", np.int32, count)
        strength, woken = read_array("strength", float, count), read_array("woken", np.int64, count)
        cells, side = read_array("covered", np.int64, None), expect_number(given.get("side"), "side of state")
        if not side > 0.0:
            raise ValueError(f"side of state is {side} but must be above 0.")
        particles = VolumeParticles(*arrays, normal, seated != 0, strength, woken)
        return VolumeState(particles, start, shape, pitch=pitch, coverage=SurfaceCoverage(cells, side), **values)
    found, latest = (read_array(name, np.int32, *no_coverage(size).found.shape) for name in ("found", "latest"))
    coverage = Coverage(found, latest, int(np.count_nonzero(found != NEVER_COVERED)))
    mesh = _parse_mesh(given["mesh"], size) if "mesh" in given else None
    return PlaneState(Particles(*arrays), start, shape, coverage=coverage, mesh=mesh, window=window, **values)


def _mesh_to_json(mesh: MeshForce) -> JsonDict:
    """Convert the force on a mesh to JSON; none where the whole force is summed over pairs."""
    far = math.isfinite(mesh.reach)
    return {"reach": mesh.reach, "force": array_to_json(mesh.force)} if far else {}


def _parse_scalar(kind: type, plain: object, where: str) -> Any:
    """Parse a single value of a state."""
    if kind is bool:
        return plain is True
    if kind is str:
        return expect_text(plain, where)
    if kind is float and plain is None:
        return math.nan
    found = expect_number(plain, where, float(_MAX_STATE_NUMBER))
    if kind is int and found < 0.0:
        raise ValueError(f"{where} is {found:g} but cannot be less than nothing.")
    return kind(found)


def _parse_mesh(plain: object, size: Extent) -> MeshForce:
    """Parse the force on a mesh, whose nodes follow from image size and reach."""
    given = expect_mapping(plain, "mesh of state")
    if not given:
        return NO_MESH
    reach = expect_number(given.get("reach"), "reach of state")
    if reach < 1.0:
        raise ValueError(f"reach of state is {reach} but must be one pixel or more.")
    force = array_from_json(given.get("force"), np.float32, (*mesh_shape(size, reach), 2), "mesh of state")
    if not np.isfinite(force).all():
        raise ValueError("mesh of state contains a value that is not a number.")
    return MeshForce(force, mesh_corner(size, reach), MESH_PITCH * reach, reach, softening_coefficients(reach))
