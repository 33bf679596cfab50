"""The scale fields: all from scratch, and the finest one after a parameter changed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from cpm_core.parameters import PRESETS
from cpm_core.segmentation.engine import Engine
from tests.benchmarks.speed.measurement import Measurement, Patience, milliseconds_of
from tests.benchmarks.speed.scenes import HAND, objects


def fields(patience: Patience) -> Iterator[Measurement]:
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
