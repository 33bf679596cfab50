"""All measurements in the order of the table."""

from __future__ import annotations

from collections.abc import Iterator

from cpm_core.image.image import Image
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
