"""The field, and the fields of all scales."""

from dataclasses import replace

import numpy as np
import pytest

from cpm_core import PRESETS, Engine, edge_map, electric_field
from cpm_core.field.convolution import convolved_field
from tests.benchmarks.speed.scenes import HAND, objects


@pytest.mark.parametrize("side", [256, 512, 1024])
@pytest.mark.parametrize("precision", [np.float64, np.float32], ids=["double", "single"])
def test_field(benchmark, timed, side, precision):
    f = edge_map(objects((side, side) if timed else (80, 80)))
    field = benchmark(convolved_field, f, precision=precision)
    assert np.abs(field - electric_field(f)).max() <= 1e-6 * np.abs(field).max()


@pytest.mark.parametrize("shape", [HAND, (1024, 1024)], ids=str)
def test_engine(benchmark, timed, shape):
    values = objects(shape if timed else (80, 80))
    assert benchmark(Engine, values, PRESETS["automatic"]).scales == 3


@pytest.mark.parametrize(("name", "step"), [("smoothing", 1e-3), ("edge_floor", 1e-5), ("beta", 1e-4)])
def test_scale_field_after_a_parameter_has_changed(benchmark, timed, name, step):
    engine = Engine(objects(HAND if timed else (80, 80)), PRESETS["automatic"])
    changed = [PRESETS["automatic"]]

    def change():
        changed.append(replace(changed[-1], **{name: getattr(changed[-1], name) + step}))
        return engine.scale_field(changed[-1])

    scale_field = benchmark.pedantic(change, rounds=30 if timed else 1, warmup_rounds=1)
    assert scale_field.shape == engine.image.shape
