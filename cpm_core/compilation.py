"""Compiling the model's loops ahead of their first use."""

from __future__ import annotations

import numpy as np

from cpm_core.initialization import circle
from cpm_core.noise import clean
from cpm_core.parameters import Parameters
from cpm_core.regions import Regions
from cpm_core.segmentation import segment


def warm_up() -> None:
    """Run every compiled loop once on a small disk.

    The first time ever this compiles them, which takes some twenty seconds, and keeps them on disk; later it loads
    them. It may run in a thread of its own while a window is being shown.
    """
    row, col = np.indices((32, 32))
    disk = 255.0 * (np.hypot(row - 15.5, col - 15.5) < 9.0)
    regions = Regions(interest=(((1, 1), (1, 30), (30, 30), (30, 1)),), barriers=(((5.3, 2.2), (6.1, 28.4)),))
    segment(disk, circle((15.5, 15.5), 5.0), Parameters(scales=2), max_steps=12, regions=regions)
    clean(disk)
