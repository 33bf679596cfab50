"""All measurements in the order of the table, and the machine that they were made on."""

from __future__ import annotations

import platform
from collections.abc import Iterator
from importlib.metadata import version

from cpm_core.cli.bench.coulomb import coulomb_forces
from cpm_core.cli.bench.field import fields
from cpm_core.cli.bench.measurement import Measurement, Patience
from cpm_core.cli.bench.runs import whole_runs
from cpm_core.cli.bench.start import starts
from cpm_core.cli.bench.steps import reconstructions, steps
from cpm_core.image.image import Image
from cpm_core.numerics.parallel import cores
from cpm_core.objects.warm_up import warm_up


def measurements(patience: Patience, image: Image | None = None) -> Iterator[Measurement]:
    """Measure all parts in turn, each row as soon as it is known; the loops are compiled first.

    The whole runs are done on `image` if one is given, else on a synthetic scene.
    """
    warm_up()
    yield from whole_runs(patience, image)
    for part in (fields, coulomb_forces, steps, reconstructions, starts):
        yield from part(patience)


def machine() -> dict[str, str | int]:
    """Properties that times depend on: cores, processor, system and libraries."""
    return {
        "cores": cores(),
        "processor": platform.machine(),
        "system": platform.system(),
        "python": platform.python_version(),
        **{name: version(name) for name in ("numpy", "scipy", "scikit-image", "numba")},
    }
