"""The field of a scale: the normalized Lorentz force on known edges."""

import numpy as np
import pytest
from scipy import ndimage, special

from cpm_core import Engine, Parameters, Regions, circle, electric_field, segment
from cpm_core.field import scale_field as scale_field_module
from cpm_core.field.convolution import convolved_potential
from cpm_core.field.edge_map import vector_magnitudes
from cpm_core.field.interpolation import interpolate_field
from cpm_core.field.scale_field import WEAKEST_EDGE, build_scale_field, write_lorentz_force

from ..scenes import disk, outline_distance, ring, u_shape

SINGLE = 5e-6
"""What single precision leaves of forces of unit size."""


def straight_edge(shape, angle, offset, width=0.6):
    """Smooth step from 0 to 100 across a line through the center, moved by `offset` along its normal."""
    row, col = np.indices(shape).astype(float)
    centre = 0.5 * (np.array(shape) - 1.0)
    across = (row - centre[0]) * np.sin(angle) + (col - centre[1]) * np.cos(angle) - offset
    return 50.0 * (1.0 + special.erf(across / (np.sqrt(2.0) * width)))


def uneven_edge():
    """An upright edge whose contrast doubles from top to bottom: the field has a part along it."""
    return straight_edge((60, 60), 0.0, 0.2) * np.linspace(1.0, 2.0, 60)[:, None]


def test_force_on_an_edge_has_no_part_along_it():
    scale_field = build_scale_field(uneven_edge(), 1.0, 0.0)
    summit = ndimage.maximum_filter(scale_field.edge_map, size=5)
    ridge = (scale_field.edge_map > 0.9 * summit) & (summit > 0.5 * scale_field.edge_map.max())
    # the ends of the edge at the border are no straight edge
    ridge[:5] = ridge[-5:] = False
    normal = scale_field.gradient / np.maximum(np.hypot(*scale_field.gradient), 1e-30)
    along = scale_field.lorentz[0] * normal[1] - scale_field.lorentz[1] * normal[0]
    field = electric_field(scale_field.edge_map)
    plain = (field[0] * normal[1] - field[1] * normal[0]) / np.hypot(*field)
    assert ridge.sum() > 40
    assert np.abs(plain[ridge]).max() > 0.1  # it would have one otherwise
    assert np.abs(along[ridge]).max() < SINGLE


@pytest.mark.parametrize("angle", [0.0, 0.3, 0.8, 1.4, 2.5])
def test_force_is_a_unit_vector_of_the_field_away_from_edges(angle):
    """To single precision; seen: 1e-6 at most."""
    scale_field = build_scale_field(straight_edge((50, 56), angle, 0.3), 1.0, 0.0)
    field = electric_field(scale_field.edge_map)
    away = ndimage.maximum_filter(scale_field.edge_map, size=7) < 0.05 * scale_field.edge_map.max()
    assert away.sum() > 500
    np.testing.assert_allclose(scale_field.lorentz[:, away], (field / np.hypot(*field))[:, away], rtol=0, atol=SINGLE)


@pytest.mark.parametrize("offset", [-0.4, -0.2, 0.0, 0.25, 0.5])
def test_force_points_to_a_straight_edge_and_vanishes_on_it(offset):
    """Its zero lies within 0.1 px of the edge, wherever between the pixels that is."""
    scale_field = build_scale_field(straight_edge((61, 61), 0.0, offset), 1.0, 0.0)
    edge = 30.0 + offset
    col = np.linspace(edge - 6.0, edge + 6.0, 481)
    across = interpolate_field(scale_field.lorentz, np.stack([np.full(481, 30.0), col], axis=1))[:, 1]
    assert np.all(across[col < edge - 0.1] > 0.0)
    assert np.all(across[col > edge + 0.1] < 0.0)


def test_floor_is_above_the_background_of_a_noisy_image():
    image = disk((96, 96), (48.0, 47.0), 25.0).values + np.random.default_rng(0).normal(0.0, 15.0, (96, 96))
    scale_field = build_scale_field(image, 1.0, 0.0)
    away = np.hypot(*(np.indices(image.shape) - 47.5)) > 32.0
    assert np.mean(scale_field.edge_map[away] > scale_field.floor) < 0.005
    assert scale_field.floor >= WEAKEST_EDGE * scale_field.edge_map.max()
    assert scale_field.floor < 0.5 * scale_field.edge_map.max()


@pytest.mark.parametrize(
    ("values", "seeds"),
    [
        (disk((110, 104), (54.2, 51.7), 30.3).values, circle((60, 60), 12)),
        (ring((110, 112), (54.3, 55.8), 20.0, 40.0).values, circle((54, 84), 10)),
        (u_shape().values, circle((60, 40), 12)),
    ],
    ids=["disk", "ring", "U"],
)
def test_single_precision_of_the_field_moves_contours_by_less_than_a_thousandth_of_a_pixel(monkeypatch, values, seeds):
    """Seen: 1e-4 at most."""
    single = segment(values, seeds).contours
    monkeypatch.setattr(scale_field_module, "FIELD_PRECISION", np.float64)
    double = segment(values, seeds).contours
    assert len(single) == len(double)
    apart = np.concatenate([outline_distance(one.points, outlines(double)) for one in single])
    assert 0.0 < apart.max() < 1e-3


def outlines(contours):
    """Polygonal lines of closed contours."""
    return [np.concatenate([contour.points, contour.points[:1]]) for contour in contours]


@pytest.mark.parametrize("smoothing", [1.0, "auto"])
@pytest.mark.parametrize("edge_floor", [0.0, 0.2])
def test_the_fixed_charges_are_those_that_the_field_is_made_of(edge_floor, smoothing):
    """Outside the regions of interest there is none, and the potential is that of the others."""
    image = disk((96, 96), (40.0, 47.0), 22.0).values
    image[:, 70:] += 40.0
    regions = Regions(interest=(((10, 10), (10, 60), (80, 60), (80, 10)),))
    parameters = Parameters(smoothing=smoothing, edge_floor=edge_floor, scales=1)
    engine = Engine(image, parameters, regions)
    shown, scale_field = engine.edge_map(parameters), engine.scale_field(parameters)
    inside = regions.pixel_mask(image.shape)
    assert shown[inside].max() > 0.0
    assert not shown[~inside].any()
    floor = edge_floor * scale_field.edge_map[inside].max()
    expected = np.where(inside & (scale_field.edge_map >= floor), scale_field.edge_map, 0.0)
    np.testing.assert_array_equal(shown, expected)
    slope, packed = scale_field.gradient, np.empty((*image.shape, 5), np.float32)
    field = electric_field(shown).astype(np.float32)
    write_lorentz_force(field, slope, vector_magnitudes(slope), scale_field.holding, packed)
    np.testing.assert_allclose(scale_field.packed[..., :4], packed[..., :4], atol=1e-4)
    np.testing.assert_allclose(engine.scale_field(parameters).potential, convolved_potential(expected))
