"""Images: the laws of the model on images of any size, type and range, with any start and any parameters."""

from __future__ import annotations

from pathlib import Path
from random import Random
from typing import Any

import numpy as np
from hypothesis import strategies as st

from cpm_core import PARAMETERS, Parameters, Result, edge_map, electric_field, segment, uniform_grid
from cpm_core.numerics.types import Array
from cpm_core.warm_up import warm_up

from .chunks import chunk
from .limits import check_sentence

prepare = warm_up

_MOST_STEPS = 60
_TYPES = ("u1", "i2", "u2", "i4", "f2", "f4", "f8", ">f4", "?", "i8")
_KINDS = ("noise", "disc", "stripes", "constant", "pixel", "ramp", "levels", "no data")
_STEERING = (
    "beta",
    "annealing",
    "time_step",
    "d_min",
    "d_max",
    "smoothing",
    "edge_floor",
    "max_gap",
    "min_length",
    "w2",
)


@st.composite
def pictures(draw: st.DrawFn, least: int = 1) -> Array:
    """An image: small, of any type, now and then with values that are no numbers."""
    shape = draw(st.tuples(st.integers(least, 26), st.integers(least, 26)))
    kind, scale = draw(st.sampled_from(_KINDS)), 10.0 ** draw(st.sampled_from((0, 0, 0, -60, -12, -3, 2, 12, 34, 200)))
    random, (row, col) = np.random.default_rng(draw(st.integers(0, 99))), np.indices(shape)
    values: dict[str, Any] = {
        "noise": random.normal(size=shape),
        "disc": 1.0 * (np.hypot(row - shape[0] / 2, col - shape[1] / 2) < min(shape) / 3),
        "stripes": 1.0 * ((row + col) // 4 % 2),
        "constant": np.ones(shape),
        "pixel": 1.0 * ((row == shape[0] // 2) & (col == shape[1] // 2)),
        "ramp": 1.0 * row,
        "levels": random.integers(0, 3, shape),
        "no data": np.where(row + col < 9, -3.4e38, random.normal(size=shape)),
    }
    pixels = np.asarray(values[kind] * (scale if kind != "no data" else 1.0), dtype=float)
    if draw(st.integers(0, 15)) == 0:
        pixels.flat[draw(st.integers(0, pixels.size - 1))] = draw(st.sampled_from((np.nan, np.inf, -np.inf)))
    with np.errstate(all="ignore"):
        return (pixels * draw(st.sampled_from((1.0, 100.0, -1.0)))).astype(draw(st.sampled_from(_TYPES)))


@st.composite
def settings_of_runs(draw: st.DrawFn) -> Parameters:
    """Parameters, each within its range."""
    chosen = draw(st.lists(st.sampled_from(_STEERING), max_size=3, unique=True))
    values = {name: draw(st.floats(PARAMETERS[name].low, PARAMETERS[name].high)) for name in chosen}
    values["w2"] = max(values.get("w2", 0.0), 1.61)
    return Parameters(scales=draw(st.integers(1, 3)), **values)


_seeds = st.one_of(
    st.just(None),
    st.lists(st.tuples(st.floats(-5.0, 30.0), st.floats(-5.0, 30.0)), min_size=1, max_size=12).map(np.array),
)


def attempt(given: tuple[Array, Parameters, Array | None]) -> None:
    """Run; fails unless the run ends, all it finds lies within the image, or it is refused in one sentence."""
    values, parameters, seeds = given
    try:
        start = uniform_grid(values.shape, 3.0) if seeds is None else seeds
        found = segment(values, start, parameters, max_steps=_MOST_STEPS)
    except ValueError as error:
        check_sentence(error)
        return
    check(found)


def check(found: Result) -> None:
    """Fail unless a result is finite, within the image, and says why it ended."""
    high = np.array(found.shape) - 0.5
    assert found.stop_reason, "a run without an end"
    assert found.steps <= _MOST_STEPS, f"{found.steps} steps"
    for points in (found.particles, *(contour.points for contour in found.contours)):
        assert np.isfinite(points).all(), "a place that is not finite"
        assert ((points >= -0.5) & (points <= high)).all(), "a place outside the image"
    for contour in found.contours:
        assert np.isfinite([contour.length, contour.area, contour.strength]).all(), "a measure that is not finite"


def attempt_fields(given: tuple[Array, int, int]) -> None:
    """Edges and field of a turned, mirrored or brighter image are turned, mirrored and as much stronger."""
    values, turns, power = given
    pixels = np.nan_to_num(values.astype(float), nan=0.0, posinf=1.0, neginf=0.0)
    if np.ptp(pixels) > 1e12 or (np.ptp(pixels) and np.ptp(pixels) < 1e-12):
        return
    edges = edge_map(pixels)
    tolerance = 1e-9 * (1.0 + float(edges.max()))
    np.testing.assert_allclose(edge_map(np.rot90(pixels, turns)), np.rot90(edges, turns), atol=tolerance)
    np.testing.assert_allclose(edge_map(pixels[::-1]), edges[::-1], atol=tolerance)
    np.testing.assert_array_equal(edge_map(pixels * 2.0**power), edges * 2.0**power)
    field = electric_field(edges)
    again = electric_field(edges[:, ::-1])[:, :, ::-1] * np.array([1.0, -1.0])[:, None, None]
    np.testing.assert_allclose(again, field, atol=1e-5 * (1.0 + float(np.abs(field).max())))


@st.composite
def _discs(draw: st.DrawFn) -> tuple[Array, Array, tuple[int, int], int, int]:
    """An image of an ellipse, a start on it, a whole displacement, a number of quarter turns and a power of two."""
    radii = draw(st.tuples(st.floats(5.0, 8.0), st.floats(5.0, 8.0)))
    row, col = np.indices((28, 28))
    depth = np.hypot((row - 13.5) / radii[0], (col - 13.5) / radii[1])
    values = 100.0 / (1.0 + np.exp(8.0 * (depth - 1.0)))
    angle = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
    start = 13.5 + 4.0 * np.stack([np.sin(angle), np.cos(angle)], axis=1)
    shift = draw(st.tuples(st.integers(0, 9), st.integers(0, 9)))
    return values, start, shift, draw(st.integers(0, 3)), draw(st.integers(-20, 20))


def attempt_runs(given: tuple[Array, Array, tuple[int, int], int, int]) -> None:
    """The contour of a displaced, turned or brighter object is displaced, turned, and the same."""
    values, start, shift, turns, power = given
    parameters = Parameters(scales=1)
    (found,) = segment(values, start, parameters).contours
    (brighter,) = segment(values * 2.0**power, start, parameters).contours
    np.testing.assert_array_equal(brighter.points, found.points)
    moved = np.pad(values, [(by, 9 - by) for by in shift], mode="edge")
    (there,) = segment(moved, start + shift, parameters).contours
    assert _apart(there.points - shift, found.points) < 0.2, "the contour of a displaced object is another one"
    middle = 13.5
    turned = start - middle
    for _ in range(turns):
        turned = turned[:, ::-1] * (-1.0, 1.0)
    (there,) = segment(np.rot90(values, turns), turned + middle, parameters).contours
    back = there.points - middle
    for _ in range(turns):
        back = back[:, ::-1] * (1.0, -1.0)
    assert _apart(back + middle, found.points) < 0.2, "the contour of a turned object is another one"


def _apart(one: Array, other: Array) -> float:
    """Largest distance of a vertex to the polygon of the other, sampled."""
    closed = np.concatenate([other, other[:1]])
    share = np.linspace(0.0, 1.0, 20)[:, None, None]
    samples = (closed[:-1] * (1.0 - share) + closed[1:] * share).reshape(-1, 2)
    distances = np.linalg.norm(one[:, None] - samples, axis=2).min(axis=1)
    return float(distances.max())


_runs = chunk(st.tuples(pictures(), settings_of_runs(), _seeds), attempt, 20.0)
_fields = chunk(st.tuples(pictures(8), st.integers(0, 3), st.integers(-20, 20)), attempt_fields, 10.0)
_objects = chunk(_discs(), attempt_runs, 60.0)


def trial(random: Random, folder: Path, examples: int = 50) -> int:
    """Try laws of runs, of fields, and of contours."""
    return (
        _runs(random, folder, examples) + _fields(random, folder, examples) + _objects(random, folder, examples // 10)
    )
