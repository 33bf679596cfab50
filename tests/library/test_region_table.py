"""What contours enclose is measured as it is, against shapes of known measures and against scikit-image on masks."""

from __future__ import annotations

import numpy as np
import pytest
import skimage.measure
from hypothesis import given
from hypothesis import strategies as st

import cpm_core as cpm
from cpm_core.contours.rasterize import rasterize_labels
from cpm_core.contours.region_table import measure_regions, measure_volume_objects

SHAPE = (120, 140)
SAME = (
    "area", "area_filled", "area_convex", "perimeter", "axis_major_length", "axis_minor_length", "eccentricity",
    "equivalent_diameter_area", "solidity", "intensity_mean", "intensity_std", "intensity_min", "intensity_max",
)  # fmt: skip


def ellipse(center, half_axes, angle=0.0, count=720):
    """An ellipse whose first half axis is turned by an angle from the direction of rows to that of columns."""
    turn = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    along, across = half_axes[0] * np.cos(turn), half_axes[1] * np.sin(turn)
    row, col = along * np.cos(angle) - across * np.sin(angle), along * np.sin(angle) + across * np.cos(angle)
    return cpm.Contour(np.stack([row, col], axis=1) + center, closed=True)


def table_of(contours, spacing=(1.0, 1.0), unit=None, gray=None):
    return measure_regions(contours, rasterize_labels(contours, SHAPE), gray, spacing, unit)


@given(st.floats(8.0, 30.0), st.floats(0.3, 0.95), st.floats(-1.5, 1.5), st.floats(50.0, 60.0))
def test_an_ellipse_has_the_measures_of_its_formula(long, ratio, angle, row):
    table = table_of([ellipse((row, 70.0), (long, long * ratio), angle)])
    expected = {
        "area": np.pi * long**2 * ratio,
        "axis_major_length": 2.0 * long,
        "axis_minor_length": 2.0 * long * ratio,
        "eccentricity": np.sqrt(1.0 - ratio**2),
        "orientation": angle,
        "solidity": 1.0,
        "centroid-0": row,
        "centroid-1": 70.0,
    }
    assert {name: table[name][0] for name in expected} == pytest.approx(expected, rel=1e-3)


def test_a_circle_is_round_and_a_square_is_not():
    square = cpm.Contour(np.array([(10.0, 10.0), (10.0, 30.0), (30.0, 30.0), (30.0, 10.0)]), closed=True)
    table = table_of([ellipse((70.0, 70.0), (20.0, 20.0)), square])
    assert table["circularity"] == pytest.approx([1.0, np.pi / 4.0], rel=1e-4)
    assert table["perimeter"] == pytest.approx([40.0 * np.pi, 80.0], rel=1e-4)
    assert [float(table[f"bbox-{k}"][1]) for k in range(4)] == [10.0, 10.0, 30.0, 30.0]


def test_what_lies_inside_is_not_part_of_the_area_and_has_a_row_of_its_own():
    table = table_of([ellipse((60.0, 70.0), (40.0, 40.0)), ellipse((60.0, 80.0), (15.0, 15.0))])
    whole, hole = np.pi * 40.0**2, np.pi * 15.0**2
    assert table["area"] == pytest.approx([whole - hole, hole], rel=1e-4)
    assert table["area_filled"] == pytest.approx([whole, hole], rel=1e-4)
    assert table["centroid-1"][0] == pytest.approx((70.0 * whole - 80.0 * hole) / (whole - hole), rel=1e-5)
    assert table["perimeter"][0] == pytest.approx(2.0 * np.pi * 55.0, rel=1e-4)
    assert table["circularity"][0] == pytest.approx(1.0, rel=1e-4)


def test_lengths_are_in_the_unit_and_pixels_need_not_be_square():
    contour = ellipse((60.0, 70.0), (20.0, 10.0))
    table = table_of([contour], (0.5, 2.0), "µm")
    assert table["axis_major_length"][0] == pytest.approx(40.0, rel=1e-4)
    assert table["axis_minor_length"][0] == pytest.approx(20.0, rel=1e-4)
    assert (table.units["area"], table.units["perimeter"], table.units["solidity"]) == ("µm²", "µm", "")
    assert abs(table["orientation"][0]) == pytest.approx(np.pi / 2.0, abs=1e-6)


@given(st.lists(st.floats(0.7, 1.3), min_size=8, max_size=8), st.floats(25.0, 45.0), st.integers(0, 9))
def test_large_regions_have_the_measures_that_scikit_image_finds_in_their_label_mask(bumps, size, seed):
    turn = np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)
    radius = size * np.interp(turn, np.linspace(0.0, 2.0 * np.pi, 9), [*bumps, bumps[0]])
    outline = np.stack([60.0 + radius * np.cos(turn), 70.0 + radius * np.sin(turn)], axis=1)
    contours = [cpm.Contour(np.clip(outline, 1.0, 118.0), closed=True), ellipse((60.0, 70.0), (10.0, 8.0), 0.4)]
    gray = np.random.default_rng(seed).uniform(0.0, 255.0, SHAPE)
    labels = rasterize_labels(contours, SHAPE)
    table = measure_regions(contours, labels, gray, (1.0, 1.0), None)
    theirs = skimage.measure.regionprops_table(labels.astype(int), gray, properties=[*SAME, "label", "centroid"])
    assert table["label"].tolist() == theirs["label"].tolist() == [1, 2]
    for name in SAME[-4:]:
        assert table[name] == pytest.approx(theirs[name], rel=1e-9)
    for name in ("area", "area_filled", "area_convex", "axis_major_length", "axis_minor_length", "solidity"):
        assert table[name] == pytest.approx(theirs[name], rel=0.06)
    for axis in range(2):
        assert table[f"centroid-{axis}"] == pytest.approx(theirs[f"centroid-{axis}"], abs=0.25)


def test_holes_of_chosen_objects_are_kept_out_of_their_labels():
    image = cpm.example("ring")
    chosen = cpm.partition(image).select([(32, 14)], [(32, 32)])
    found = cpm.objects_result([chosen], image, ["ring"])
    assert found.labels[32, 14] == 1
    assert found.labels[32, 32] == 0
    table = found.table(in_units=True)
    assert table["name"].tolist() == ["ring"]
    assert table["area"][0] == pytest.approx(np.pi * (24.0**2 - 10.0**2) * 0.25, rel=0.03)
    assert table.units["area"] == "µm²"


def test_a_volume_has_a_label_volume_and_its_table():
    found = cpm.segment(cpm.example("ball"), cpm.sphere((15, 15, 15), 4, 60), cpm.PRESETS["volume"])
    assert found.labels.shape == (31, 31, 31)
    table = found.table(in_units=True)
    assert table["volume"][0] == pytest.approx(4.0 / 3.0 * np.pi * 9.0**3, rel=0.02)
    assert table["volume"][0] == pytest.approx(found.surface.volume, rel=0.02)
    assert [float(table[f"centroid-{k}"][0]) for k in range(3)] == pytest.approx([15.0] * 3, abs=0.05)
    assert table.units["volume"] == "mm³"


def test_objects_in_a_volume_are_measured_in_units_along_each_axis():
    labels = np.zeros((10, 12, 14), int)
    labels[2:5, 3:8, 1:5], labels[6:8, 9:11, 10:12] = 1, 3  # an object in between has been taken away
    gray = np.arange(labels.size, dtype=float).reshape(labels.shape)
    table = measure_volume_objects(labels, gray, (2.0, 1.0, 0.5), "mm")
    theirs = skimage.measure.regionprops_table(
        labels, gray, ["area", "centroid", "intensity_mean"], spacing=(2.0, 1.0, 0.5)
    )
    assert table["label"].tolist() == [1, 3]
    assert table["volume"] == pytest.approx(theirs["area"])
    assert table["intensity_mean"] == pytest.approx(theirs["intensity_mean"])
    for axis in range(3):
        assert table[f"centroid-{axis}"] == pytest.approx(theirs[f"centroid-{axis}"])
    assert [float(table[f"bbox-{k}"][0]) for k in range(6)] == [4.0, 3.0, 0.5, 8.0, 7.0, 2.0]
