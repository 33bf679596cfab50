"""The image border is distinguished from objects."""

import numpy as np
import pytest

from cpm_core.field.edge_map import smoothed_gradient, vector_magnitudes
from cpm_core.image.border import find_pixels_inside_border
from cpm_core.model.starts import uniform_grid
from cpm_core.parameters import Parameters
from cpm_core.segmentation.evolve import segment


def bordered(width, gray=20.0, sides=("top", "bottom", "left", "right")):
    image = np.full((160, 200), 120.0)
    row, col = np.indices(image.shape)
    image[np.hypot(row - 80, col - 90) < 30] = 180.0
    if "top" in sides:
        image[:width] = gray
    if "bottom" in sides:
        image[160 - width :] = gray
    if "left" in sides:
        image[:, :width] = gray
    if "right" in sides:
        image[:, 200 - width :] = gray
    return image


def inside_of(grad, widest):
    return find_pixels_inside_border(lambda window: grad[(slice(None), *window)], vector_magnitudes(grad), 1.0, widest)


@pytest.mark.parametrize("gray", [20.0, 250.0])
@pytest.mark.parametrize("sides", [("top", "bottom", "left", "right"), ("left",), ("bottom", "right")])
def test_a_border_and_its_edge_are_left_out_and_nothing_else(gray, sides):
    inside = inside_of(smoothed_gradient(bordered(8, gray, sides), 1.0), 0.1)
    row, col = np.indices(inside.shape)
    depth = {"top": row, "bottom": 159 - row, "left": col, "right": 199 - col}
    nearest = np.min([depth[side] for side in sides], axis=0)
    assert not inside[nearest < 9].any()
    assert inside[nearest > 16].all()


def test_an_object_at_the_side_of_the_image_is_no_border():
    image = np.full((160, 200), 120.0)
    image[:10, 40:120] = 20.0  # along less than half of the side
    row, col = np.indices(image.shape)
    image[np.hypot(row - 8, col - 160) < 20] = 200.0
    assert inside_of(smoothed_gradient(image, 1.0), 0.1).all()


def test_contours_of_an_object_do_not_depend_on_a_border():
    seeds = uniform_grid((160, 200))
    parameters = Parameters(w1=0.6, w2=0.7, beta=0.4, max_border=0.1)
    alone = segment(bordered(0, sides=()), seeds, parameters).contours
    (contour,) = segment(bordered(8), seeds, parameters).contours
    assert contour.closed
    assert len(alone) == 1
    distance = np.hypot(*(contour.points - [80.0, 90.0]).T)
    assert np.abs(distance - 30.0).max() < 1.0
