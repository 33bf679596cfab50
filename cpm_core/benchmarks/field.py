"""The field and what else particles feel, beside the bare Fourier transforms that a convolution consists of."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from cpm_core.benchmarks.measurement import Measurement, Patience, milliseconds_of
from cpm_core.benchmarks.scenes import HAND, objects
from cpm_core.edge_map import edge_map
from cpm_core.engine import Engine
from cpm_core.field.convolution import convolved_field
from cpm_core.field.electric import electric_field
from cpm_core.parameters import PRESETS

Array = NDArray[np.float64]

_PLACES = 20
"""Pixels at which the field is compared with eq. (8)."""

_PEER = "1 padded FFT and 2 back"


def fields(patience: Patience) -> Iterator[Measurement]:
    """The field at several sizes, in both precisions; and the levels of a scene, anew and after one parameter moved."""
    for side in (64, 128) if patience.quick else (256, 512, 1024):
        f = edge_map(objects((side, side)))
        bare = milliseconds_of(lambda: _bare(2 * side), patience)  # noqa: B023  # done with before the next round
        for name, field in (("", electric_field), (", single precision", _single)):
            ours = milliseconds_of(lambda: field(f), patience)  # noqa: B023
            yield Measurement(
                "field", f"field {side} x {side}{name}", ours, "ms", _PEER, bare, field_error(f, np.asarray(field(f)))
            )
    yield from _levels(patience)


def _single(f: Array) -> Array:
    """The field as the Lorentz force uses it."""
    return convolved_field(f, precision=np.float32)


def _bare(side: int) -> None:
    """The transforms of a convolution that has two components, with nothing between them."""
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


def _levels(patience: Patience) -> Iterator[Measurement]:
    """What particles feel, at all scales; then at the finest one when a parameter moves to where it has never been."""
    values, start = objects((160, 220) if patience.quick else HAND), PRESETS["automatic"]
    size = " x ".join(map(str, values.shape))
    ours = milliseconds_of(lambda: Engine(values, start), patience)
    yield Measurement("field", f"engine {size}, {start.scales} scales", ours)
    engine = Engine(values, start)
    for name, step in (("smoothing", 0.01), ("edge_floor", 0.0001), ("beta", 0.001)):
        moved = [replace(start, **{name: getattr(start, name) + step * k}) for k in range(1, patience.repeats + 2)]
        anew = milliseconds_of(lambda: engine.level(moved.pop()), patience)  # noqa: B023
        yield Measurement("field", f"another {name}, finest scale", anew, "ms", "engine", ours)
