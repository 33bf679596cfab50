"""The reconstruction, beside one triangulation of the same points."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import scipy

from cpm_core.cli.bench.measurement import Measurement, Patience, milliseconds_of
from cpm_core.cli.bench.scenes import HAND, along_curves, objects
from cpm_core.parameters import PRESETS
from cpm_core.particles.initialization import uniform_grid
from cpm_core.reconstruction import reconstruct_curve
from cpm_core.segmentation.engine import Engine

_POINTS = 5_000
_STEPS = 120
"""Steps after which contours are asked for, as a window does of a run under way."""


def reconstructions(patience: Patience) -> Iterator[Measurement]:
    """Contours through points that know of no image, and those of a run under way."""
    points = along_curves(800 if patience.quick else _POINTS)
    ours, peer = milliseconds_of(patience, lambda: reconstruct_curve(points), lambda: scipy.spatial.Delaunay(points))
    yield Measurement("reconstruction", f"curves through {len(points)} points", ours, "ms", "1 triangulation", peer)
    parameters = replace(PRESETS["automatic"], scales=1)
    engine = Engine(objects((160, 220) if patience.quick else HAND), parameters)
    state = engine.start(uniform_grid(engine.image.shape))
    for _ in range(_STEPS):
        state = engine.step(state, parameters)
    ours, peer = milliseconds_of(
        patience, lambda: engine.result(state, parameters), lambda: scipy.spatial.Delaunay(state.position)
    )
    what = f"contours of a run, {len(state.position)} particles"
    yield Measurement("reconstruction", what, ours, "ms", "1 triangulation", peer)
