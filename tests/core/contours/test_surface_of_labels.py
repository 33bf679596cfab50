"""Surfaces of labels: closed or open at the border of the volume, and the same away from it."""

import numpy as np
import pytest

from cpm_core.contours.surface import surface_from_labels

SPACING = (2.0, 1.0, 1.0)


def labels(*boxes, shape=(9, 10, 11)):
    found = np.zeros(shape, np.int32)
    for number, box in boxes:
        found[tuple(slice(a, b) for a, b in box)] = number
    return found


def triangles(surface):
    return sorted(map(tuple, surface.vertices[surface.faces].reshape(-1, 9).tolist()))


def test_away_from_the_border_both_are_the_same():
    inner = labels((1, ((2, 5), (3, 6), (4, 8))), (3, ((6, 8), (6, 9), (2, 9))))
    closed, opened = (surface_from_labels(inner, SPACING, "mm", open_border=way) for way in (False, True))
    assert closed.closed and opened.closed
    assert triangles(closed) == triangles(opened)
    assert set(closed.numbers.tolist()) == set(opened.numbers.tolist()) == {1, 3}


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("end", [0, 1])
def test_an_object_that_the_border_cuts_is_closed_there_or_open(axis, end):
    shape = (9, 10, 11)
    sides = [(3, 6)] * 3
    sides[axis] = (0, 4) if end == 0 else (shape[axis] - 4, shape[axis])
    cut = labels((1, sides))
    closed, opened = (surface_from_labels(cut, SPACING, "mm", open_border=way) for way in (False, True))
    beyond = -0.5 if end == 0 else shape[axis] - 0.5
    assert closed.closed and not opened.closed
    assert closed.vertices[:, axis].min() == beyond or closed.vertices[:, axis].max() == beyond
    assert opened.vertices.min() >= 0.0 and (opened.vertices <= np.array(shape) - 1.0).all()
    lost = {triangle for triangle in triangles(closed) if not set(triangle[axis::3]) <= {beyond}}
    assert len(opened.faces) < len(lost)  # the sides end half a voxel earlier, and nothing is added
