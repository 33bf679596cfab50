"""Accuracy and speed of the recovery of shapes with known boundaries; prints a table.

Run by itself: ``python tests/benchmarks/recovery.py``. Each shape is drawn antialiased and started from one circle with
the default parameters. The error is the mean distance of points every quarter of a pixel along the contours from the
true boundary; the time is the median of five whole runs, compilation left out.
"""

from __future__ import annotations

import statistics
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from cpm_core import circle, segment
from cpm_core.contours.contour import sample_contours
from cpm_core.warm_up import warm_up
from tests.core.scenes import disk, ring, u_shape

CASES = {
    "disk, radius 50 px": (disk((200, 200), (100.2, 99.7), 50.3), circle((120, 120), 20)),
    "ring, radii 30 and 60 px": (ring((192, 192), (96.3, 95.8), 30.0, 60.0), circle((96, 140), 15)),
    "U": (u_shape(), circle((60, 40), 12)),
}


def main() -> None:
    """Print a line for each shape."""
    warm_up()
    for name, (scene, seeds) in CASES.items():
        seconds = []
        for _ in range(5):
            began = time.perf_counter()
            result = segment(scene.values, seeds)
            seconds.append(time.perf_counter() - began)
        error = np.abs(scene.distance(sample_contours(result.contours)))
        closed = sum(contour.closed for contour in result.contours)
        sys.stdout.write(
            f"{name}: {len(result.contours)} contours, {closed} closed, mean error {error.mean():.3f} px, "
            f"95 % within {np.percentile(error, 95):.3f} px, {len(result.particles)} particles, {result.steps} steps, "
            f"{statistics.median(seconds):.2f} s\n"
        )


if __name__ == "__main__":
    main()
