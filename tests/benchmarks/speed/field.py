"""The field and the scale fields, beside the bare Fourier transforms that a convolution consists of."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np
import scipy

from cpm_core.field.convolution import convolved_field
from cpm_core.field.edge_map import edge_map
from cpm_core.field.electric_field import electric_field
from cpm_core.numerics.types import Array
from cpm_core.parameters import PRESETS
from cpm_core.segmentation.engine import Engine
from tests.benchmarks.speed.measurement import Measurement, Patience, milliseconds_of
from tests.benchmarks.speed.scenes import HAND, objects

_PLACES = 20
"""Pixels at which the field is compared with eq. (8)."""

_PEER = "1 padded FFT and 2 back"


def fields(patience: Patience) -> Iterator[Measurement]:
    """The field at several sizes and in both precisions; scale fields from scratch and after a parameter changed."""
    for side in (64, 128) if patience.quick else (256, 512, 1024):
        f = edge_map(objects((side, side)))
        methods: dict[str, Callable[[Array], Array]] = {"": electric_field, ", single precision": _single}
        *ours, bare = milliseconds_of(
            patience, *(partial(method, f) for method in methods.values()), partial(_bare, 2 * side)
        )
        for (name, method), value in zip(methods.items(), ours, strict=True):
            what, error = f"field {side} x {side}{name}", field_error(f, np.asarray(method(f)))
            yield Measurement("field", what, value, "ms", _PEER, bare, error)
    yield from _scale_fields(patience)


def _single(f: Array) -> Array:
    """The field as the Lorentz force uses it."""
    return convolved_field(f, precision=np.float32)


def _bare(side: int) -> None:
    """Only the transforms of a convolution with two components."""
    spectrum = scipy.fft.rfft2(np.zeros((side, side)), workers=-1)
    for _ in range(2):
        scipy.fft.irfft2(spectrum, workers=-1)


def field_error(f: Array, field: Array) -> float:
    """Largest deviation of a field from eq. (8) at some pixels, as a fraction of the largest vector there."""
    random = np.random.default_rng(0)
    row, col = np.indices(f.shape)
    worst, largest = 0.0, 0.0
    for r, c in zip(*(random.integers(0, n, _PLACES) for n in f.shape), strict=True):
        down, right = r - row, c - col
        cube = np.hypot(down, right) ** 3
        cube[r, c] = np.inf
        exact = -np.array([(f * down / cube).sum(), (f * right / cube).sum()])
        worst = max(worst, float(np.abs(field[:, r, c] - exact).max()))
        largest = max(largest, float(np.abs(exact).max()))
    return worst / largest


def _scale_fields(patience: Patience) -> Iterator[Measurement]:
    """The fields of all scales; then that of the finest one after a change of a parameter to a new value."""
    values, start = objects((160, 220) if patience.quick else HAND), PRESETS["automatic"]
    size = " x ".join(map(str, values.shape))
    (ours,) = milliseconds_of(patience, lambda: Engine(values, start))
    yield Measurement("field", f"scale fields, {size}, {start.scales} scales", ours)
    engine = Engine(values, start)
    for name, step in (("smoothing", 0.01), ("edge_floor", 0.0001), ("beta", 0.001)):
        moved = [replace(start, **{name: getattr(start, name) + step * k}) for k in range(1, patience.repeats + 2)]
        (again,) = milliseconds_of(patience, lambda: engine.scale_field(moved.pop()))  # noqa: B023  # called within this pass
        yield Measurement("field", f"the finest scale for another {name}", again, "ms", "all scales from scratch", ours)
