"""Calls: every public function of the library, with arguments of the right and the wrong kind.

A call gives a result of finite numbers, or says in one sentence which value it refuses.
"""

from __future__ import annotations

import functools
import inspect
import itertools
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from random import Random
from typing import Any, cast

import numpy as np
from hypothesis import strategies as st

import cpm_core
from cpm_core import (
    Centerlines,
    Contour,
    Image,
    Parameters,
    PlacedCharge,
    Regions,
    Result,
    Skeleton,
    Start,
    Surface,
    Truth,
    VolumeTruth,
)
from cpm_core.formats.writers import VOLUMES_WRITABLE
from cpm_core.image.colors import Colors
from cpm_core.warm_up import warm_up
from tests.core.formats.drawn import RESULT

from .chunks import chunk
from .limits import check_sentence

_ROW, _COL = np.indices((16, 18))
DISC = np.where(np.hypot(_ROW - 7.5, _COL - 8.5) < 4.5, 200.0, 20.0)
BALL = np.where(np.linalg.norm(np.indices((12, 13, 14)) - 6.0, axis=0) < 4.0, 200.0, 20.0)
"""A volume."""
_SEEDS = np.array([[4.0, 8.0], [7.5, 8.5], [11.0, 9.0]])
_COLORED = Image(DISC, colors=Colors(np.stack([DISC, DISC[:, ::-1], DISC * 0.5], -1).astype(np.uint8), 255.0))
"""An image with colors."""
_START = Start((np.array([[3.0, 3.0], [3.0, 14.0], [12.0, 14.0], [12.0, 3.0]]),))
_FRAME = np.zeros((4, 6, 3), np.uint8)

_NUMBERS: tuple[Any, ...] = (
    0,
    1,
    -1,
    2,
    3,
    7,
    0.5,
    1.5,
    -0.5,
    1e-9,
    1e9,
    1e300,
    -1e300,
    5e-324,
    float("nan"),
    float("inf"),
    -float("inf"),
    np.float32(2.0),
    np.int64(3),
    np.uint8(2),
    True,
    10**30,
)
_WRONG: tuple[Any, ...] = (
    None,
    "",
    "auto",
    "x",
    b"x",
    object(),
    [],
    {},
    (),
    [1.0],
    [[1.0, 2.0]],
    "\x1b\n" * 30,
    "x" * 10**5,
    1j,
    [None, None],
    np.empty((0, 2)),
    np.empty((2, 0)),
    np.zeros((2, 2, 2, 2)),
    np.array(["a"]),
    np.array([1j]),
    np.array([None]),
    np.full((3, 2), np.nan),
    np.array(5.0),
    [[1.0], [1.0, 2.0]],
    set(),
    range(3),
    np.ma.masked_array([1.0], [True]),
)
_IMAGES: tuple[Any, ...] = (
    DISC,
    DISC.astype(np.uint8),
    DISC.astype(np.float32),
    DISC * 1e30,
    DISC * 1e-30,
    DISC * 0.0,
    -DISC,
    DISC > 99,
    DISC.tolist(),
    DISC[:, :9],
    DISC[:5],
    DISC[:1],
    np.where(DISC > 99, np.nan, 1.0),
    np.where(DISC > 99, np.inf, 1.0),
    np.where(DISC > 99, 1e308, -1e308),
    DISC.astype(complex),
    np.stack([DISC] * 9),
    Image(DISC),
    _COLORED,
    np.zeros((0, 0)),
    np.asfortranarray(DISC),
    DISC[::-1, ::-1],
    np.full((16, 18), 3),
    DISC.astype(np.int64) * 2**50,
    DISC[:, :, None],
    BALL,
    BALL.astype(np.float32) * 1e-30,
    BALL.T > 99,
    BALL[:8, :8, :8],
    BALL[:7],
    Image(BALL, (2.0, 1.0, 0.5), "mm"),
    Image(BALL, (1e-12, 1e-12, 1e-9)),
)
_POINTS: tuple[Any, ...] = (
    _SEEDS,
    _SEEDS.astype(np.float32),
    _SEEDS.tolist(),
    _SEEDS * 1e6,
    -_SEEDS,
    _SEEDS[:1],
    np.repeat(_SEEDS, 3, 0),
    np.empty((0, 2)),
    np.full((2, 2), np.nan),
    np.full((2, 2), np.inf),
    _SEEDS.T,
    _SEEDS[:, :1],
    _SEEDS.astype(int),
    np.c_[_SEEDS, _SEEDS[:, :1]],
    np.full((3, 2), 1e300),
    np.indices((16, 18)).reshape(2, -1).T,
    cpm_core.sphere((6.0, 6.0, 6.0), 2.0, 40),
    cpm_core.sphere((6.0, 6.0, 6.0), 2.0, 40) * (1.0, 1e-9, 1e9),
    cpm_core.seeds_on_box((2, 2, 2), (9, 9, 9)),
    np.full((5, 3), 6.0),
    np.eye(4, 3) * 1e-300,
    np.full((4, 3), 1e300) * np.eye(4, 3),
)
_CORNERS = ((2, 2, 2), (9, 9, 9), (0.0, 0.5, 1e6), (1e300, -1e300, 0), (6, 6), np.array([1, 2, 3]), (0, 0, np.nan))
_PARAMETERS: tuple[Any, ...] = (
    None,
    Parameters(scales=1),
    Parameters(scales=2, smoothing="auto"),
    Parameters(scales=8),
    Parameters(scales=1, channel="red"),
    Parameters(scales=1, channel="dab"),
    cpm_core.PRESETS["volume"],
)


@functools.cache
def sound() -> Mapping[str, tuple[Any, ...]]:
    """Name of an argument -> values that it may have, not all of them sensible."""
    found = cpm_core.segment(DISC, _SEEDS, Parameters(scales=1), max_steps=60)
    in_space = cpm_core.segment(BALL, cpm_core.sphere((6, 6, 6), 2.0), cpm_core.PRESETS["volume"], max_steps=60)
    surface = cast("Surface", in_space.surface)
    lines = cpm_core.centerlines(BALL > 99)
    partition = cpm_core.partition(DISC, Parameters(scales=1))
    selection = partition.select(np.array([[7.5, 8.5]]))
    truth = Truth((DISC > 99).astype(np.int32), found.contours)
    contours: tuple[Any, ...] = (found.contours, RESULT.contours, (), list(found.contours), RESULT.contours[:1])
    results: tuple[Any, ...] = (found, RESULT, in_space)
    return {
        "values": _IMAGES,
        "edge_map": _IMAGES,
        "inside": (*_IMAGES, BALL > 99, np.ones((9, 9, 9), bool), np.zeros((3, 3, 3)), np.ones((1, 1, 1), bool)),
        "vertices": (surface.vertices, surface.vertices[:4], surface.vertices * 1e300, *_POINTS),
        "faces": (
            surface.faces,
            surface.faces[:, ::-1],
            surface.faces[:1],
            surface.faces + 1,
            -surface.faces,
            [[0] * 3],
        ),
        "normals": (None, surface.normals, -surface.normals, *_POINTS),
        "first": _CORNERS,
        "last": _CORNERS,
        "branches": (lines.branches, ()),
        "image": (Image(DISC), _COLORED),
        "points": _POINTS,
        "positions": _POINTS,
        "seeds": _POINTS,
        "targets": (None, [0, 1], np.array([2]), [-1], [99], []),
        "parameters": _PARAMETERS,
        "max_steps": (1, 2, 5, 0, -1, np.int64(3)),
        "regions": (
            None,
            Regions(),
            Regions(interest=(((2, 2), (2, 15), (13, 15), (13, 2)),)),
            Regions(barriers=(((0, 3), (15, 3)),)),
        ),
        "charges": ((), (PlacedCharge((5.0, 5.0), 2.0),), (PlacedCharge((1e6, -1e6), -4.0),)),
        "contours": contours,
        "truth": (truth,),
        "compare_surface.truth": (VolumeTruth(BALL > 99), VolumeTruth(BALL > 99, (2.0, 1.0, 0.5), "mm")),
        "surface": (None, VolumeTruth(BALL > 99).surface, VolumeTruth(BALL[:8] > 99).surface),
        "result": results,
        "partition": (partition,),
        "selection": (selection,),
        "selections": ([selection], [], [selection] * 2),
        "center": (*_CORNERS, (8, 8), (1e6, 0), (0.0, -5.0), [4, 4]),
        "shape": ((16, 18), (0, 0), (1, 1), (10**6, 10**6), (-3, 4), (16, 18, 4), (16.5, 3)),
        "method": (
            "auto",
            "direct",
            "fast",
            "convolution",
            "pppm",
            "x",
            *cpm_core.CONTOUR_METHODS.values(),
        ),
        "suffix": (*cpm_core.formats.CONTOURS_WRITABLE, *VOLUMES_WRITABLE, ".x", "svg"),
        "of": (None, "auto", "dark", "light", "x"),
        "within": (None, DISC > 99, DISC[:3] > 0, found.contours),
        "frames": ([_FRAME], [_FRAME] * 3, [], [_FRAME, _FRAME[:2]]),
        "captions": ((), ("a",), ("a", "b", "c")),
        "names": ((), ("a",)),
        "kept": ((), (0,), (0, 1), (99,), (-1,)),
        "rejected": ((), (1,), (0,)),
        "examples": (None,),
        "spacing": (
            2.0,
            1,
            0.1,
            (1.0, 1.0),
            (0.5, 2.0),
            (0, 1),
            1e-6,
            (1, 1, 1),
            (2.0, 1.0, 0.5),
            (1e-200, 1.0, 1e200),
            (5e-324,) * 3,
        ),
        "voxel_size": ((1, 1, 1), (2.0, 1.0, 0.5), (1e-200, 1.0, 1e200), (5e-324,) * 3),
        "channel": ("luminance", "red", "x"),
        "holes": (True, False),
        "outside": (True, False),
        "contrast": (True, False),
        "columns": (None, 1, 2, 0),
        "interest": ((), (((2, 2), (2, 9), (9, 9)),), (((2, 2),),)),
        "barriers": ((), (((0, 3), (15, 3)),)),
        "position": ((5.0, 5.0), (1, 2)),
        "smoothing": ("auto", 1.0, 2.5),
        **_of_stacks_and_methods(),
    }


def _of_stacks_and_methods() -> Mapping[str, tuple[Any, ...]]:
    """Name of an argument of what follows pages or compares methods -> values that it may have."""
    moment = cpm_core.run_method(cpm_core.CONTOUR_METHODS["chan_vese"], Image(DISC), _START, max_steps=3)
    return {
        "pages": ([DISC] * 2, [DISC, DISC[:5]], np.stack([DISC] * 3), [], [None], "ab", BALL, [DISC * np.nan, DISC]),
        "numbers": (None, (1,), [2, 1], [0], [1, 1], np.array([1]), np.array([1.0]), np.array(1), "1"),
        "start": (_START, Start((_SEEDS * 4.0,), around=True), Start((_SEEDS, _SEEDS + 1e5))),
        "settings": (None, {}, *(method.settings() for method in cpm_core.CONTOUR_METHODS.values())),
        "moment": (moment,),
        "outlines": ((_SEEDS,), [_SEEDS.tolist()], (_SEEDS[:2],), (), True, False),
        "line": _POINTS,
        "axis": (0, 1, 2, 3, -1, 0.5),
        "name": (*cpm_core.EXAMPLES, "x") if hasattr(cpm_core, "EXAMPLES") else ("disk", "x"),
    }


def prepare() -> None:
    """Compile the loops of all that is called: that is no time of a call."""
    warm_up()
    sound()


_SKIPPED = {
    "Engine",
    "METHODS",
    "MODELS",
    "fetch_model",
    "PARAMETERS",
    "PRESETS",
    "Method",
    "register_method",
    "Comparison",
    "Energies",
    "Forces",
    "Particles",
    "Partition",
    "Result",
    "Selection",
    "Skeleton",
    "State",
    "Truth",
    "Bridge",
    "Face",
    "Centerlines",
    "export",
    "load_centerlines",
    "load_contours",
    "load_image",
    "load_pages",
    "load_points",
    "load_surface",
    "ContourState",
    "VolumePartition",
    "load_truth",
    "load_volume",
    "load_volume_truth",
    "write_animation",
    "write_figure",
    "Evolution",
    "RunState",
    "Table",
    "Contour",
}
"""What is no function, what the library makes for others to read, and what needs files, which has a part of its own."""

_SKIPPED_ARGUMENTS = ("progress", "cancelled", "measure_contrast", "colors", "unit", "source", "notes")
"""Functions, and what the library passes on without looking at it."""

_OF_THE_LIBRARY = {
    "contours",
    "truth",
    "surface",
    "result",
    "partition",
    "selection",
    "selections",
    "image",
    "parameters",
    "regions",
    "charges",
    "examples",
    "holes",
    "outside",
    "outlines",
    "contrast",
}
"""Arguments that are objects of the library, for which nothing else is tried."""

FUNCTIONS: dict[str, Callable[..., Any]] = {
    name: getattr(cpm_core, name)
    for name in cpm_core.__all__
    if name not in _SKIPPED and callable(getattr(cpm_core, name))
}


@st.composite
def calls(draw: st.DrawFn) -> tuple[str, dict[str, Any]]:
    """A function and its arguments by name."""
    name = draw(st.sampled_from(sorted(FUNCTIONS)))
    arguments = {}
    for key, known in inspect.signature(FUNCTIONS[name]).parameters.items():
        optional = known.default is not inspect.Parameter.empty
        if key in _SKIPPED_ARGUMENTS or (optional and draw(st.booleans())):
            continue
        wrong = key not in _OF_THE_LIBRARY and draw(st.integers(0, 7)) == 0
        arguments[key] = draw(st.sampled_from(_WRONG if wrong else _sound_for(name, key)))
    return name, arguments


def _sound_for(name: str, key: str) -> tuple[Any, ...]:
    """Values of the right kind for an argument of a function."""
    values = sound()
    found: tuple[Any, ...] = values.get(f"{name}.{key}", values.get(key, _NUMBERS))
    return found


def attempt(call: tuple[str, dict[str, Any]]) -> None:
    """Call a function; fails unless its result is finite, or it says in one sentence what it refuses."""
    name, arguments = call
    if name in ("segment", "run_method", "follow_pages"):
        arguments = {"max_steps": 3, **arguments}
    try:
        found = FUNCTIONS[name](**arguments)
        if isinstance(found, Iterator):
            found = list(itertools.islice(found, 3))
    except ValueError as error:
        check_sentence(error)
    else:
        check(found)


def check(found: Any) -> None:
    """Fail unless a result is of finite numbers."""
    if isinstance(found, np.ndarray) and found.dtype.kind == "f":
        assert np.isfinite(found).all(), "a result that is not finite"
    elif isinstance(found, Contour):
        assert np.isfinite(found.points).all(), "a contour that is not finite"
    elif isinstance(found, Image):
        assert np.isfinite(found.values).all(), "gray levels that are not finite"
    elif isinstance(found, Surface):
        assert np.isfinite(found.vertices).all(), "a surface that is not finite"
        assert np.isfinite(found.normals).all(), "normals that are not finite"
    elif isinstance(found, Centerlines):
        assert all(np.isfinite(branch.points).all() for branch in found.branches), "a center line that is not finite"
        assert all(np.isfinite(branch.radii).all() for branch in found.branches), "a radius that is not finite"
    elif isinstance(found, Result | Skeleton):
        check(getattr(found, "surface", None))
        for contour in found.contours:
            check(contour)
            limits = np.array(found.shape) - 0.5
            assert (contour.points >= -0.5).all(), "a contour outside the image"
            assert (contour.points <= limits).all(), "a contour outside the image"
    elif isinstance(found, tuple | list):
        for one in found:
            check(one)


_trial = chunk(calls(), attempt, 10.0)


def trial(random: Random, folder: Path, examples: int = 50) -> int:
    """Make some calls."""
    return _trial(random, folder, examples)
