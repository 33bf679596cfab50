"""Free memory, so that work that cannot fit is refused before the system ends the program."""

from __future__ import annotations

import math
from contextlib import suppress
from pathlib import Path

from cpm_core.numerics.types import Extent

_CGROUP_FOLDER = Path("/sys/fs/cgroup")
"""Limits of the control group that this process belongs to, as in a container."""


def available_memory() -> float:
    """Return the memory that this process may still allocate [bytes]; infinite where the system does not report it."""
    room = math.inf
    with suppress(OSError, ValueError, IndexError, StopIteration):
        lines = Path("/proc/meminfo").read_text().splitlines()
        room = next(1024.0 * int(line.split()[1]) for line in lines if line.startswith("MemAvailable:"))
    with suppress(OSError, ValueError):  # "max" is no number: there is no limit
        most, taken = (int((_CGROUP_FOLDER / f"memory.{name}").read_text()) for name in ("max", "current"))
        parts = (line.split() for line in (_CGROUP_FOLDER / "memory.stat").read_text().splitlines())
        given_back = sum(int(count) for name, count in parts if name in ("inactive_file", "active_file"))
        room = min(room, float(max(most - taken + given_back, 0)))
    return room


def check_field_memory(shape: Extent, bytes_per_pixel: float, source: str) -> None:
    """Check that the fields of an image fit into memory.

    Parameters
    ----------
    shape : tuple of int
        Size of the image in each direction [px].
    bytes_per_pixel : float
        Memory for one pixel [bytes].
    source : str
        The image, as it is named in the message.

    Raises
    ------
    ValueError
        When they do not; the message names a size that would fit.
    """
    needed, there = math.prod(shape) * bytes_per_pixel, available_memory()
    if needed <= there:
        return
    fitting = tuple(int(side * (there / needed) ** (1.0 / len(shape))) for side in shape)
    raise ValueError(
        f"{source} has {_format_shape(shape)} px, which need {needed / 1e9:.2g} GB of memory, and {there / 1e9:.2g} GB "
        f"are free: make it smaller, about {_format_shape(fitting)} px, crop it, or close other programs."
    )


def _format_shape(shape: Extent) -> str:
    return " × ".join(f"{side:,}" for side in shape)
