"""All measurements in the order of the table, and the machine that they were made on."""

from __future__ import annotations

import platform
from collections.abc import Iterator
from importlib.metadata import version

from cpm_core.image.image import Image
from cpm_core.numerics.parallel import count_cores
from cpm_core.warm_up import warm_up
from tests.benchmarks.speed.field import fields
from tests.benchmarks.speed.measurement import Measurement, Patience
from tests.benchmarks.speed.runs import whole_runs
from tests.benchmarks.speed.start import starts
from tests.benchmarks.speed.steps import reconstructions, steps


def measurements(patience: Patience, image: Image | None = None) -> Iterator[Measurement]:
    """Measure all parts in turn, each row as soon as it is known; the loops are compiled first.

    The whole runs are done on `image` if one is given, else on a synthetic scene.
    """
    warm_up()
    yield from whole_runs(patience, image)
    for part in (fields, steps, reconstructions, starts):
        yield from part(patience)


def machine() -> dict[str, str | int]:
    """Properties that times depend on: cores, processor, system and libraries."""
    return {
        "cores": count_cores(),
        "processor": platform.machine(),
        "system": platform.system(),
        "python": platform.python_version(),
        **{name: version(name) for name in ("numpy", "scipy", "scikit-image", "numba")},
    }
