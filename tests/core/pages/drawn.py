"""Stacks of drawn disks, whose places are known on every page."""

import numpy as np

from ..scenes import disk

SHAPE = (64, 88)


def page(*disks):
    """An image of disks, given as row, column and radius."""
    return np.max([disk(SHAPE, (row, col), radius).values for row, col, radius in disks], axis=0)


MOVING = [page((32, 22 + 7 * step, 9 + step)) for step in range(5)]
"""A disk that moves to the right and grows."""

SPLITTING = [page((32, 44 - apart, 11), (32, 44 + apart, 11)) for apart in (0, 0, 9, 16, 22)]
"""A disk of which two are made; on the last two pages they are apart."""
