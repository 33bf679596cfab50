"""Measures against what is known of them: lengths, angles, and gray levels in an ellipse."""

from __future__ import annotations

import csv
import io
import math

import numpy as np
import pytest

from cpm_core import Image
from cpm_core.formats import encode_measures_table
from cpm_core.shapes import Angle, Oval, Ruler

RNG = np.random.default_rng(5)


def volume(**known) -> Image:
    return Image(RNG.normal(40.0, 5.0, (20, 60, 80)), spacing=(5.0, 0.5, 0.25), unit="mm", **known)


def test_a_ruler_measures_in_the_unit_of_the_image() -> None:
    assert Ruler(((1.0, 10.0, 10.0), (2.0, 34.0, 10.0))).measure(volume()).length == pytest.approx(13.0)
    assert Ruler(((0.0, 0.0), (3.0, 4.0))).measure(Image(np.eye(9))).length == pytest.approx(5.0)


@pytest.mark.parametrize("degrees", [0.01, 30.0, 90.0, 120.0, 179.99])
def test_an_angle_is_that_in_space_whatever_the_sides_of_a_voxel(degrees) -> None:
    turn = math.radians(degrees)
    ends = np.array([(0.0, 7.0, 0.0), (0.0, 0.0, 0.0), (3 * math.sin(turn), 3 * math.cos(turn), 0.0)]) / (5, 0.5, 0.25)
    assert Angle(tuple(map(tuple, ends.tolist()))).measure(volume()).angle == pytest.approx(degrees)


@pytest.mark.parametrize(("axis", "sides"), [(0, 0.5 * 0.25), (1, 5.0 * 0.25), (2, 5.0 * 0.5)])
def test_an_ellipse_has_the_area_mean_and_deviation_of_its_slice(axis, sides) -> None:
    image, center = volume(), (9.0, 30.2, 40.0)
    found = Oval(center, (6.0, 8.0), axis).measure(image)
    place = np.delete(np.indices(image.shape, float), axis, axis=0) - np.delete(center, axis)[:, None, None, None]
    inside = (np.hypot(*(place / np.array([6.0, 8.0])[:, None, None, None])) <= 1.0) & (
        np.indices(image.shape)[axis] == round(center[axis])
    )
    levels = image.values[inside]
    assert found.area == pytest.approx(math.pi * 48.0 * sides)
    assert (found.mean, found.deviation, found.pixels) == pytest.approx((levels.mean(), levels.std(), levels.size))


def test_an_ellipse_of_even_noise_finds_its_mean_and_deviation() -> None:
    found = Oval((200.0, 200.0), (150.0, 150.0)).measure(Image(RNG.normal(-20.0, 8.0, (400, 400))))
    assert (found.mean, found.deviation) == pytest.approx((-20.0, 8.0), rel=0.02)
    assert found.area == pytest.approx(found.pixels, rel=1e-3)


def test_an_ellipse_measures_the_channel_in_use_and_nothing_outside() -> None:
    colored = np.stack([np.full((30, 30), 10.0), np.full((30, 30), 90.0), np.zeros((30, 30))], axis=-1)
    assert Oval((10.0, 10.0), (4.0, 4.0)).measure(Image(colored), "green").mean == 90.0
    outside = Oval((100.0, 10.0), (4.0, 4.0)).measure(Image(np.eye(30)))
    assert (outside.mean, outside.deviation, outside.pixels) == (None, None, 0)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_handle_is_moved_to_a_place_and_the_other_radius_stays(axis) -> None:
    oval = Oval((9.0, 30.0, 40.0), (6.0, 8.0), axis)
    for which, handle in enumerate(oval.handles()):
        wider = np.array(handle) + 0.5 * (np.array(handle) - oval.center)
        changed = oval.with_handle_at(handle, tuple(wider.tolist())).radii
        assert changed == ((6.0, 12.0) if which % 2 == 0 else (9.0, 8.0))
    assert oval.encloses(oval.center)
    assert oval.distance_to(oval.handles()[0]) == pytest.approx(0.0, abs=0.01)


def test_the_table_names_the_units_and_leaves_empty_what_is_not_measured() -> None:
    measures = Ruler(((1.0, 10.0, 10.0), (2.0, 34.0, 10.0))), Oval((9.0, 30.0, 40.0), (6.0, 8.0))
    one, other = csv.DictReader(io.StringIO(encode_measures_table(measures, volume(hounsfield=True)).decode()))
    assert (one["measure"], one["length_mm"], one["mean_HU"], one["place"]) == ("ruler", "13", "", "1 10 10; 2 34 10")
    assert (other["length_mm"], float(other["area_mm2"])) == ("", pytest.approx(math.pi * 6.0, rel=1e-6))
    assert float(other["mean_HU"]) == pytest.approx(40.0, abs=2.0)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: Ruler(((0.0, 0.0), (1.0, 1.0), (2.0, 2.0))), "3 points are given for the ruler, but it has 2"),
        (lambda: Angle(((0.0, 0.0), (1.0, 1.0))), "2 different points are given but at least 3"),
        (lambda: Oval((0.0, 0.0), (0.1, 1.0)), "radii is 0.1 but must be a number from 0.5"),
        (lambda: Oval((0.0, 0.0, 0.0), (1.0, 1.0), 3), "axis is 3 but must be 0, 1 or 2"),
    ],
)
def test_a_wrong_value_is_named(make, sentence) -> None:
    with pytest.raises(ValueError, match=sentence):
        make()
