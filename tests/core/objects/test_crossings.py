"""Crossings of lines with the links between pixels, against the definition."""

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from cpm_core.numerics import polyline
from cpm_core.objects.boundaries.crossings import find_crossings

seeds = st.integers(0, 2**32 - 1)


def links(shape):
    """Pairs of neighboring pixels, and whether one is below or right of the other."""
    for r in range(shape[0]):
        for c in range(shape[1]):
            for down, right in ((0, 1), (1, 0)):
                if r + down < shape[0] and c + right < shape[1]:
                    yield (r, c), (r + down, c + right), down


@settings(deadline=None, max_examples=24)
@given(seeds)
def test_a_closed_line_parts_the_pixels_inside_from_those_outside(seed):
    random = np.random.default_rng(seed)
    shape = (12, 14)
    angle = np.sort(random.random(9)) * 2.0 * np.pi
    radius = random.uniform(1.0, 8.0, 9)
    corners = np.stack([5.5 + radius * np.sin(angle), 6.5 + radius * np.cos(angle)], axis=1)
    if random.random() < 0.5:
        corners = np.rint(corners)  # through the centers of pixels
    found = find_crossings([np.concatenate([corners, corners[:1]])], shape)
    pixels = np.indices(shape).reshape(2, -1).T.astype(float)
    inside = polyline.points_inside(corners - [1.37e-7, -2.61e-7] + [2.74e-7, 0.0], pixels).reshape(shape)
    crossed = [(found.down if down else found.right)[p] for p, q, down in links(shape) if inside[p] != inside[q]]
    assume(crossed)
    assert min(crossed) >= 0.0
