"""All that is measured, in the order of the table, and the machine that it was measured on."""

from __future__ import annotations

import platform
from collections.abc import Iterator
from importlib.metadata import version

from cpm_core.cli.bench.coulomb import coulomb_forces
from cpm_core.cli.bench.field import fields
from cpm_core.cli.bench.measurement import Measurement, Patience
from cpm_core.cli.bench.reconstruction import reconstructions
from cpm_core.cli.bench.runs import whole_runs
from cpm_core.cli.bench.start import starts
from cpm_core.cli.bench.steps import steps
from cpm_core.image.image import Image
from cpm_core.numerics.parallel import cores
from cpm_core.segmentation.warm_up import warm_up


def measurements(patience: Patience, image: Image | None = None) -> Iterator[Measurement]:
    """Measure one thing after the other; the loops are compiled first.

    Parameters
    ----------
    patience : Patience
        How long to look.
    image : Image, optional
        Image for the whole runs instead of the scene of our own.

    Yields
    ------
    Measurement
        One row after the other, each as soon as it is known.
    """
    warm_up()
    yield from whole_runs(patience, image)
    yield from fields(patience)
    yield from coulomb_forces(patience)
    yield from steps(patience)
    yield from reconstructions(patience)
    yield from starts(patience)


def machine() -> dict[str, str | int]:
    """What a time depends on: cores, processor, system and libraries."""
    return {
        "cores": cores(),
        "processor": platform.machine(),
        "system": platform.system(),
        "python": platform.python_version(),
        **{name: version(name) for name in ("numpy", "scipy", "scikit-image", "numba")},
    }
