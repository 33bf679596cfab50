"""Particles of a run in a volume as a table, one in each line."""

from __future__ import annotations

from cpm_core.contours.result import Result
from cpm_core.medial_axis.skeleton import Skeleton


def encode(result: Result | Skeleton) -> bytes:
    """Positions ``plane,row,col`` in voxels, below a header; ValueError for what has no particles in a volume."""
    if not isinstance(result, Result) or result.particles.shape[1] != 3 or not len(result.particles):
        raise ValueError("There are no particles in a volume to write: run in a volume first.")
    lines = ["plane,row,col", *(f"{plane:.7g},{row:.7g},{col:.7g}" for plane, row, col in result.particles.tolist())]
    return ("\n".join(lines) + "\n").encode()
