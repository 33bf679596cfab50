"""Volumes: the laws of the model in volumes of any shape, type and voxel, and of the surfaces that are written."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
from hypothesis import strategies as st
from scipy.spatial import KDTree

from cpm_core import (
    PARAMETERS,
    PRESETS,
    Image,
    Parameters,
    Result,
    centerlines,
    seeds_on_box,
    segment,
    sphere,
    to_bytes,
)
from cpm_core.formats.writers import VOLUMES_WRITABLE
from cpm_core.numerics.types import Array

from .chunks import chunk
from .limits import check_sentence

_MOST_STEPS = 60
_TYPES = ("u1", "i2", "u2", "i4", "f4", "f8", ">f4", "?")
_KINDS = ("noise", "ball", "box", "sheet", "tube", "shell", "constant", "voxel", "ramp", "levels", "no data")
_SIDES = (1.0, 1.0, 1.0, 0.1, 0.5, 2.0, 5.0, 1e-9, 1e9, 1e-200, 1e200, 5e-324)
_STEERING = ("beta", "time_step", "d_min", "smoothing", "edge_floor", "w2")
_UNITS = (None, None, "mm", "µm", "\x1b[31m\n")


Voxels = tuple[Array, tuple[float, ...], str | None]
"""Values, the sides of a voxel, and their unit."""


@st.composite
def volumes(draw: st.DrawFn) -> Voxels:
    """A small volume of any type and shape, with voxels of any sides."""
    shape = draw(st.tuples(*[st.integers(8, 22)] * 3))
    kind, scale = draw(st.sampled_from(_KINDS)), 10.0 ** draw(st.sampled_from((0, 0, 0, -60, -3, 2, 34, 200)))
    random, (plane, row, col) = np.random.default_rng(draw(st.integers(0, 99))), np.indices(shape)
    middle = np.array(shape) / 2.0
    away = np.sqrt((plane - middle[0]) ** 2 + (row - middle[1]) ** 2 + (col - middle[2]) ** 2)
    most = min(shape) / 3.0
    values: dict[str, Any] = {
        "noise": random.normal(size=shape),
        "ball": 1.0 * (away < most),
        "box": 1.0 * (np.abs(np.stack([plane, row, col], -1) - middle).max(-1) < most),
        "sheet": 1.0 * (np.abs(plane - middle[0]) < 1.0),
        "tube": 1.0 * (np.hypot(row - middle[1], col - middle[2]) < 2.0),
        "shell": 1.0 * (np.abs(away - most) < 1.0),
        "constant": np.ones(shape),
        "voxel": 1.0 * (away < 0.9),
        "ramp": 1.0 * plane,
        "levels": random.integers(0, 3, shape),
        "no data": np.where(plane + row < 9, -3.4e38, random.normal(size=shape)),
    }
    voxels = np.asarray(values[kind] * (scale if kind != "no data" else 1.0), dtype=float)
    with np.errstate(all="ignore"):
        typed = (voxels * draw(st.sampled_from((1.0, 100.0, -1.0)))).astype(draw(st.sampled_from(_TYPES)))
    if draw(st.integers(0, 15)) == 0 and typed.dtype.kind == "f":
        typed.flat[draw(st.integers(0, typed.size - 1))] = draw(st.sampled_from((np.nan, np.inf, -np.inf)))
    if draw(st.booleans()):
        typed = np.asfortranarray(typed)
    sides = tuple(draw(st.sampled_from(_SIDES)) for _ in range(3)) if draw(st.booleans()) else ()
    return typed, sides, draw(st.sampled_from(_UNITS))


@st.composite
def settings_of_runs(draw: st.DrawFn) -> Parameters:
    """Settings of volumes with a few others, each within its range."""
    chosen = draw(st.lists(st.sampled_from(_STEERING), max_size=2, unique=True))
    values: dict[str, Any] = {name: draw(st.floats(PARAMETERS[name].low, PARAMETERS[name].high)) for name in chosen}
    values["w2"] = max(values.get("w2", 0.0), 0.7)
    return replace(PRESETS["volume"], scales=draw(st.integers(1, 3)), **values)


_seeds = st.one_of(
    st.just(None),
    st.builds(sphere, st.tuples(*[st.floats(0.0, 20.0)] * 3), st.floats(0.5, 20.0), st.integers(1, 80)),
    st.builds(
        seeds_on_box,
        st.tuples(*[st.floats(-5.0, 6.0)] * 3),
        st.tuples(*[st.floats(7.0, 30.0)] * 3),
        st.floats(2.0, 9.0),
    ),
    st.lists(st.tuples(*[st.floats(-5.0, 30.0)] * 3), min_size=1, max_size=12).map(np.array),
)


def attempt(given: tuple[Voxels, Parameters, Array | None]) -> None:
    """Run; fails unless all that is found lies in the volume, or the run is refused in one sentence."""
    voxels, parameters, seeds = given
    try:
        volume = Image(*voxels)
        start = sphere(tuple(0.5 * side for side in volume.shape), 5.0, 60) if seeds is None else seeds
        found = segment(volume, start, parameters, max_steps=_MOST_STEPS)
    except ValueError as error:
        check_sentence(error)
        return
    check(found)


def check(found: Result) -> None:
    """Fail unless a result is finite, within the volume, says why it ended, and is written or refused as a whole."""
    assert found.stop_reason, "a run without an end"
    assert found.steps <= _MOST_STEPS, f"{found.steps} steps"
    surface = found.surface
    assert surface is not None, "a volume without a surface"
    for points, beyond in ((found.particles, 0.5), (surface.vertices, 1.0)):  # what the border cuts ends flat behind it
        assert np.isfinite(points).all(), "a place that is not finite"
        last = np.array(found.shape) - 1.0 + beyond
        outside = points[((points < -beyond) | (points > last)).any(1)]
        assert not len(outside), f"{outside[0]} lies outside the volume"
    if len(surface.faces):
        assert np.isfinite([surface.area, surface.volume]).all(), f"area {surface.area}, volume {surface.volume}"
        assert np.isfinite(surface.normals).all(), "normals that are not finite"
        assert not surface.nonmanifold_edges, f"{surface.nonmanifold_edges} edges with more than two triangles"
    for suffix in VOLUMES_WRITABLE:
        try:
            content = to_bytes(found, suffix)
        except ValueError as error:
            check_sentence(error)
        else:
            assert content, f"an empty {suffix}"


def attempt_lines(given: tuple[Voxels, float]) -> None:
    """Center lines of what is bright lie in the volume, with a radius of at least nothing."""
    voxels, pruning = given
    try:
        volume = Image(*voxels)
        found = centerlines(volume.values > volume.values.mean(), volume.spacing, volume.unit, pruning)
    except ValueError as error:
        check_sentence(error)
        return
    for branch in found.branches:
        assert len(branch.points) == len(branch.radii), "a radius for each point"
        assert np.isfinite(branch.points).all() and np.isfinite(branch.radii).all(), "a line that is not finite"
        assert ((branch.points >= -0.5) & (branch.points <= np.array(volume.shape) - 0.5)).all(), "a line outside"
        assert (branch.radii >= 0.0).all(), "a radius below nothing"
    assert np.isfinite(found.lengths).all(), "a length that is not finite"


@st.composite
def _balls(draw: st.DrawFn) -> tuple[Array, Array, tuple[int, int, int], tuple[int, int, int], int]:
    """An ellipsoid, a start in it, a whole displacement, an order of axes and a power of two."""
    radii = draw(st.tuples(*[st.floats(4.0, 6.0)] * 3))
    away = np.sqrt(sum(((x - 9.5) / radius) ** 2 for x, radius in zip(np.indices((20,) * 3), radii, strict=True)))
    values = 100.0 / (1.0 + np.exp(6.0 * (away - 1.0)))
    shift = draw(st.tuples(*[st.integers(0, 5)] * 3))
    order = tuple(draw(st.permutations(range(3))))
    return values, sphere((9.5, 9.5, 9.5), 2.5, 60), shift, order, draw(st.integers(-20, 20))


def attempt_runs(given: tuple[Array, Array, tuple[int, int, int], tuple[int, int, int], int]) -> None:
    """The surface of an object that is brighter or of larger voxels is the same; displaced or turned, it is as much."""
    values, start, shift, order, power = given
    found = segment(values, start, PRESETS["volume"])
    brighter = segment(values * 2.0**power, start, PRESETS["volume"])
    larger = segment(Image(values, (2.0**power,) * 3), start, PRESETS["volume"])
    for other in (brighter, larger):
        np.testing.assert_allclose(other.surface.vertices, found.surface.vertices, rtol=0, atol=1e-5)
    assert found.surface.euler == 2, f"Euler characteristic {found.surface.euler} of a ball"
    moved = np.pad(values, [(by, 5 - by) for by in shift], mode="edge")
    there = segment(moved, start + shift, PRESETS["volume"])
    assert _apart(there.surface.vertices - shift, found.surface.vertices) < 0.4, "displaced, it is another surface"
    there = segment(np.transpose(values, order), start[:, order], PRESETS["volume"])
    assert _apart(there.surface.vertices, found.surface.vertices[:, order]) < 0.4, "turned, it is another surface"


def _apart(one: Array, other: Array) -> float:
    """Largest of the differences of two surfaces around the same center, in directions all over the sphere."""
    reach = []
    for vertices in (one, other):
        out = vertices - 9.5
        lengths = np.linalg.norm(out, axis=1)
        nearest = KDTree(out / lengths[:, None]).query(sphere((0.0, 0.0, 0.0), 1.0, 200))[1]
        reach.append(lengths[nearest])
    return float(np.abs(reach[0] - reach[1]).max())


_runs = chunk(st.tuples(volumes(), settings_of_runs(), _seeds), attempt, 20.0)
_lines = chunk(st.tuples(volumes(), st.floats(0.0, 5.0)), attempt_lines, 10.0)
_objects = chunk(_balls(), attempt_runs, 60.0)


def prepare() -> None:
    """Compile the loops of runs in volumes and of center lines."""
    ball = 100.0 * (np.linalg.norm(np.indices((20, 20, 20)) - 9.5, axis=0) < 5.0)
    segment(ball, sphere((9.5, 9.5, 9.5), 2.5, 60), PRESETS["volume"])
    centerlines(ball)


def trial(random: Random, folder: Path, examples: int = 50) -> int:
    """Try laws of runs, of center lines, and of surfaces."""
    return (
        _runs(random, folder, examples)
        + _lines(random, folder, examples // 2)
        + _objects(random, folder, examples // 10)
    )
