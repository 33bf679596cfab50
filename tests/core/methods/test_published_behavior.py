"""What the publication says of the classical methods (Fig. 1 to 3), and the charged particles on the same images."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from cpm_core.contours.contour import sample_contours
from cpm_core.contours.rasterize import rasterize_mask
from cpm_core.methods import CONTOUR_METHODS, report_run, run_method
from cpm_core.methods.level_sets import GeodesicSettings, GeometricGvfSettings
from cpm_core.methods.method import unit_edges
from cpm_core.methods.snakes import GvfSnakeSettings, gradient_vector_flow

from .published import (
    AROUND,
    BAY_END,
    BAY_MOUTH,
    COL,
    ROW,
    depth_in_bay,
    drawing_with_gap,
    fading_disk,
    long_bay,
    two_objects,
)

DEPTH = BAY_END - BAY_MOUTH

UNIT_FIELD = GeometricGvfSettings(mu=0.2, curvature=0.05, smoothing=1.0, evenness=1.0)
"""The field as Xu and Prince have it, all vectors of the length 1."""

PUBLISHED = GeodesicSettings(balloon=1.0, curvature=0.05, pull=1.0, contrast=0.1, smoothing=1.0)
"""A geodesic contour that is driven on by a balloon, as that of Fig. 3."""


def end_of(name, image, start, settings=None):
    return run_method(CONTOUR_METHODS[name], image, start, settings)


@pytest.mark.parametrize("mu", [0.02, 0.2, 2.0])
def test_the_gvf_snake_stops_in_the_mouth_of_a_long_thin_bay(mu):
    image, _ = long_bay()
    end = end_of("gvf", image, AROUND, GvfSnakeSettings(mu=mu, alpha=0.05))
    assert end.state.converged
    assert 0.0 < depth_in_bay(end.state.contours) < 0.3 * DEPTH


def test_the_particles_reach_the_end_of_the_same_bay():
    image, truth = long_bay()
    end = end_of("cpm", image, AROUND)
    assert depth_in_bay(end.state.contours) > DEPTH - 1.0
    assert report_run(end, truth).f > 0.99


def test_the_geometric_gvf_contour_does_not_part_between_two_objects():
    image, _ = two_objects()
    end = end_of("geometric_gvf", image, AROUND, replace(UNIT_FIELD, pressure=0.0))
    assert end.state.converged
    assert len(end.state.contours) == 1


def test_where_the_geometric_gvf_contour_stops_between_objects_the_field_has_sources_and_saddles():
    image, _ = two_objects()
    (contour,) = end_of("geometric_gvf", image, AROUND, replace(UNIT_FIELD, pressure=0.0)).state.contours
    field = gradient_vector_flow(unit_edges(image, UNIT_FIELD.smoothing), UNIT_FIELD.mu)
    between = np.array([at for at in sample_contours([contour]) if 44.0 < at[1] < 51.5])
    assert len(between) > 10  # it spans the space between the objects
    row, col = (map_coordinates(part, between.T, order=1) for part in field)
    apart = np.gradient(field[1], axis=1)
    assert (map_coordinates(apart, between.T, order=1) > 0.0).all()  # to both sides it flows away, to the objects
    longest = np.hypot(*field).max()
    assert np.abs(row).max() < 0.01 * longest  # nothing drives it on between them
    assert np.hypot(row, col).min() < 0.01 * longest  # and in the middle there is no force at all


def test_with_pressure_the_geometric_gvf_contour_parts_between_two_objects():
    image, truth = two_objects()
    end = end_of("geometric_gvf", image, AROUND, replace(UNIT_FIELD, pressure=0.3))
    assert len(end.state.contours) == 2
    assert report_run(end, truth).f > 0.95


@pytest.mark.parametrize(("pressure", "leaks"), [(0.0, False), (0.3, True)])
def test_with_pressure_the_geometric_gvf_contour_leaks_through_a_gap(pressure, leaks):
    image, _ = drawing_with_gap()
    settings = replace(UNIT_FIELD, pressure=pressure, evenness=0.0)
    end = end_of("geometric_gvf", image, AROUND, settings)
    core = np.hypot(ROW - 48, COL - 48) < 15
    covered = rasterize_mask(end.state.contours, (96, 96))[core].mean()
    assert covered == (0.0 if leaks else 1.0)


def test_the_particles_find_both_objects_and_do_not_pass_the_gap():
    image, truth = two_objects()
    end = end_of("cpm", image, AROUND)
    assert len(end.state.contours) == 2
    assert report_run(end, truth).f > 0.99
    image, away = drawing_with_gap()
    points = np.rint(sample_contours(end_of("cpm", image, AROUND).state.contours)).astype(int)
    assert away[tuple(points.T)].max() < 3.0


def test_the_geodesic_contour_leaks_with_a_small_exponent_and_sticks_with_a_large_one():
    image, start, truth = fading_disk()
    area = (truth.labels > 0).sum()
    ends = {}
    for exponent in (2.0, 8.0):
        settings = replace(PUBLISHED, exponent=exponent)
        state = end_of("geodesic", image, start, settings).state
        ends[exponent] = state
    assert ends[2.0].stop_reason == "the contour has left the image"
    assert sum(contour.area for contour in ends[8.0].contours) < 0.65 * area


def test_the_particles_find_the_fading_disk():
    image, start, truth = fading_disk()
    assert report_run(end_of("cpm", image, start), truth).f > 0.99
