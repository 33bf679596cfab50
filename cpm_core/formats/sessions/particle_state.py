"""A state of a run as plain JSON: exactly as it was, and checked when it is read, for compiled loops trust it.

What the actions of the run tell, its parameters, regions and charges, is not repeated here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from cpm_core.field.volume_field import pitch_of
from cpm_core.formats.sessions.plain import array_from_plain, array_to_plain, mapping, number
from cpm_core.image.pyramid import shape_of_scale
from cpm_core.model.coverage import NEVER, Coverage, SurfaceCoverage, no_coverage
from cpm_core.model.plane.repulsion import NO_MESH, PITCH, mesh_shape, softening
from cpm_core.model.starts import inside_image
from cpm_core.model.state import MEMORY, MeshForce, Particles, SpaceState, State, SurfaceContact
from cpm_core.numerics.types import Array
from cpm_core.numerics.vectors import Vector
from cpm_core.parameters.quotation import shown

_COUNTS = (
    *("step", "step_of_scale", "reactivated", "next_identity", "born", "deleted", "moving", "idle", "quiet"),
    "reseedings",
)
_COVERAGE = ("found", "latest")
_MEASURES = ("annealed", "epsilon", "displacement")
_MOST = 2**40
_UNIT = 1.0 + 1e-6
"""Greatest length of a normal, with rounding."""

_PARTICLES = ("position", "velocity", "force", "distance")


def state_to_plain(state: State) -> dict[str, Any]:
    """A state as plain JSON."""
    plain: dict[str, Any] = {"scale": state.scale, "erased": state.erased, "converged": state.converged}
    plain |= {name: int(getattr(state, name)) for name in _COUNTS}
    plain |= {name: _finite(float(getattr(state, name))) for name in _MEASURES}
    plain["stop_reason"] = state.stop_reason
    particles = state.particles
    plain |= {name: array_to_plain(getattr(particles, name)) for name in (*_PARTICLES, "identity")}
    plain["start"] = array_to_plain(state.start)
    if state.space is not None:
        return plain | _space_to_plain(state)
    plain |= {name: array_to_plain(getattr(state.coverage, name)) for name in _COVERAGE}
    if state.mesh is not None:
        far = math.isfinite(state.mesh.reach)
        plain["mesh"] = {"reach": state.mesh.reach, "force": array_to_plain(state.mesh.force)} if far else {}
    return plain


def state_from_plain(plain: object, shape: tuple[int, ...], scales: int, spacing: tuple[float, ...] = ()) -> State:
    """The state of a run on an image of this shape with so many scales; ValueError when it cannot be one.

    `spacing` has the sides of a voxel of a volume; without it they are equal.
    """
    given = mapping(plain, "state")
    scale = int(number(given.get("scale"), "scale of state"))
    if not 0 <= scale < scales:
        raise ValueError(f"scale of state is {scale} but must be from 0 to {scales - 1}.")
    size = shape_of_scale(shape, scale)
    counts = {name: int(number(given.get(name), f"{name} of state", _MOST)) for name in _COUNTS}
    if min(counts.values()) < 0:
        raise ValueError("state counts less than nothing.")
    reason = given.get("stop_reason")
    if not isinstance(reason, str):
        raise ValueError(f"stop_reason of state is {shown(reason)} but must be text.")
    pitch = pitch_of(spacing or (1.0,) * len(shape)) if len(shape) == 3 else None
    particles, start = _particles(given, size, counts["next_identity"], pitch), _places(given, "start", shape)
    coverage, space, mesh = no_coverage(size), None, None
    if pitch is not None:
        particles = replace(particles, contact=_contact(given, len(particles)))
        space = SpaceState(pitch, _covered(given))
    else:
        cells = coverage.found.shape
        found, latest = (array_from_plain(given.get(name), np.int32, cells, name) for name in _COVERAGE)
        coverage = Coverage(found, latest, int(np.count_nonzero(found != NEVER)))
        mesh = _mesh(given["mesh"], size) if "mesh" in given else None
    values: dict[str, Any] = {**counts, **{name: _measure(given.get(name), name) for name in _MEASURES}}
    return replace(
        State(particles, start, shape, scale, coverage, mesh, space=space),
        **values,
        erased=given.get("erased") is True,
        stop_reason=reason,
        converged=given.get("converged") is True,
    )


def _particles(given: Mapping[str, Any], size: tuple[int, ...], following: int, pitch: Vector | None) -> Particles:
    identity = array_from_plain(given.get("identity"), np.int64, (None,), "identity of state")
    if len(np.unique(identity)) < len(identity) or (len(identity) and not 0 <= identity.min() <= identity.max()):
        raise ValueError("identity of state holds a number twice, or one below zero.")
    if len(identity) and identity.max() >= following:
        raise ValueError("identity of state holds a number that is yet to come.")
    arrays: dict[str, Any] = {}
    axes = len(size)
    for name, rest in zip(_PARTICLES, ((axes,), (axes,), (2, axes), (MEMORY,)), strict=True):
        array = array_from_plain(given.get(name), float, (len(identity), *rest), f"{name} of state")
        if np.isinf(array).any() or (name != "distance" and np.isnan(array).any()):
            raise ValueError(f"{name} of state holds a value that is not a number.")
        arrays[name] = array
    if not inside_image(arrays["position"] / (pitch or 1.0), size).all():
        raise ValueError("position of state holds a place outside the image.")
    return Particles(**arrays, identity=identity)


def _places(given: Mapping[str, Any], name: str, shape: tuple[int, ...]) -> Array:
    places = array_from_plain(given.get(name), float, (None, len(shape)), f"{name} of state")
    if not inside_image(places, shape).all():
        raise ValueError(f"{name} of state holds a place outside the image.")
    return places


def _mesh(plain: object, size: tuple[int, ...]) -> MeshForce:
    """The force on a mesh, whose nodes follow from the size of the image and the reach."""
    given = mapping(plain, "mesh of state")
    if not given:
        return NO_MESH
    reach = number(given.get("reach"), "reach of state")
    if reach < 1.0:
        raise ValueError(f"reach of state is {reach} but must be one pixel or more.")
    nodes = mesh_shape(size, reach)
    force = array_from_plain(given.get("force"), np.float32, (*nodes, 2), "mesh of state")
    if not np.isfinite(force).all():
        raise ValueError("mesh of state holds a value that is not a number.")
    pitch = PITCH * reach
    first = tuple(0.5 * (n - 1) - 0.5 * pitch * (m - 1) for n, m in zip(size, nodes, strict=True))
    return MeshForce(force, first, pitch, reach, softening(reach))


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _measure(plain: object, name: str) -> float:
    return math.nan if plain is None else number(plain, f"{name} of state", float(_MOST))


def _space_to_plain(state: State) -> dict[str, Any]:
    """Contact of the particles with surfaces, and the coverage of a volume."""
    contact, space = state.particles.contact, state.space
    assert contact is not None
    assert space is not None
    return {
        "normal": array_to_plain(contact.normal),
        "seated": array_to_plain(contact.seated.astype(np.int32)),
        "strength": array_to_plain(contact.strength),
        "woken": array_to_plain(contact.woken),
        "covered": array_to_plain(space.covered.cells),
        "side": space.covered.side,
    }


def _contact(given: Mapping[str, Any], count: int) -> SurfaceContact:
    """Contact of so many particles; ValueError when it cannot be one."""
    normal = array_from_plain(given.get("normal"), float, (count, 3), "normal of state")
    seated = array_from_plain(given.get("seated"), np.int32, (count,), "seated of state")
    strength = array_from_plain(given.get("strength"), float, (count,), "strength of state")
    woken = array_from_plain(given.get("woken"), np.int64, (count,), "woken of state")
    if not (np.linalg.norm(normal, axis=1) <= _UNIT).all():
        raise ValueError("normal of state holds a direction longer than one.")
    if not np.isfinite(strength).all():
        raise ValueError("strength of state holds a value that is not a number.")
    return SurfaceContact(normal, seated != 0, strength, woken)


def _covered(given: Mapping[str, Any]) -> SurfaceCoverage:
    """Coverage of a volume; ValueError when it cannot be one."""
    cells = array_from_plain(given.get("covered"), np.int64, (None,), "covered of state")
    side = number(given.get("side"), "side of state")
    if not side > 0.0:
        raise ValueError(f"side of state is {side} but must be above 0.")
    if (np.diff(cells) <= 0).any():
        raise ValueError("covered of state holds cells that do not ascend.")
    return SurfaceCoverage(cells, side)
