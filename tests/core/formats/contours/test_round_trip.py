"""What is exported is read back: vertices to a hundredth of a pixel, with the names, colors and objects that fit in."""

import json
import string
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import Contour, Image
from cpm_core.contours.rasterize import rasterize_labels
from cpm_core.formats import CONTOURS_WRITABLE, export, to_bytes
from cpm_core.formats.contour_file import decode_contours, describe_plane, load_contours, read_contours
from cpm_core.formats.writers import FIGURE_SUFFIXES

from ..drawn import RESULT

NEAR = 0.01
WHOLE = (".json", ".csv", ".geojson", ".zip", ".labelme.json", ".svg", ".dxf")
"""Formats that hold open and closed contours with all their vertices."""
WITHOUT_COLORS = (".labelme.json",)

places = st.integers(0, 8000).map(lambda number: number / 16)
points = st.lists(st.tuples(places, places), min_size=3, max_size=12, unique=True).map(np.array)
names = st.text(string.ascii_letters + "äß日 -_.", max_size=12).map(str.strip)
colors = st.sampled_from(["", "#e69f00", "#0072b2", "#000000", "#ffffff", "#102030"])
contours = st.builds(Contour, points, st.booleans(), name=names, color=colors)


def result_of(*drawn, unit=None, spacing=(1.0, 1.0)):
    return replace(RESULT, contours=drawn, bridges=(), shape=(501, 501), unit=unit, spacing=spacing)


def off(found, original):
    """How far the vertices of a closed contour are off, wherever it begins and however it turns."""
    distance = np.linalg.norm(found.points[:, None] - original.points, axis=2)
    return max(distance.min(axis=1).max(), distance.min(axis=0).max())


@settings(max_examples=12, deadline=None)
@given(drawn=st.lists(contours, min_size=1, max_size=4), spacing=st.sampled_from([0.02, 1.0, 3.7]))
@pytest.mark.parametrize("suffix", WHOLE)
def test_any_contours_come_back(suffix, drawn, spacing):
    result = result_of(*drawn, unit="mm", spacing=(spacing, 0.5 * spacing))
    found = decode_contours(to_bytes(result, suffix), f"a{suffix}").contours
    assert [one.closed for one in found] == [one.closed for one in drawn]
    assert max(off(one, original) for one, original in zip(found, drawn, strict=True)) < NEAR
    assert [one.name for one in found] == [one.name for one in drawn]
    if suffix not in WITHOUT_COLORS:
        assert [one.color for one in found] == [one.color for one in drawn]


RING = [np.array([(20.0, 20.0), (20.0, 60.25), (60.5, 60.0), (60.0, 20.125)]) + 0.1 * k for k in range(2)]
INNER = np.array([(30.0, 30.0), (30.0, 50.0), (50.3, 50.0), (50.0, 30.0)])
OBJECT = (
    Contour(RING[0], True, name="cell", color="#e69f00", group=3),
    Contour(INNER, True, group=3, hole=True),
    Contour(RING[1] + (0.0, 90.0), True, name="cell", color="#e69f00", group=4),
)


@pytest.mark.parametrize("suffix", [".json", ".geojson", ".labelme.json", ".coco.json"])
def test_holes_stay_holes_of_their_object(suffix):
    result = result_of(*OBJECT)
    found = decode_contours(to_bytes(result, suffix), f"a{suffix}").contours
    outer, hole = found[:2]
    assert [one.hole for one in found] == [False, True, False]
    assert outer.group == hole.group != 0
    assert max(off(one, original) for one, original in zip(found, OBJECT, strict=True)) < NEAR
    np.testing.assert_array_equal(rasterize_labels(found, (501, 501)) > 0, rasterize_labels(OBJECT, (501, 501)) > 0)


@pytest.mark.parametrize("suffix", [".json", ".geojson", ".labelme.json", ".coco.json"])
def test_classes_come_back_next_to_the_names(suffix):
    classed = [replace(one, category="nucleus", name="" if one.hole else f"nucleus {one.group}") for one in OBJECT]
    found = decode_contours(to_bytes(result_of(*classed), suffix), f"a{suffix}").contours
    assert [(one.category, one.name) for one in found if not one.hole] == [
        ("nucleus", "nucleus 3"),
        ("nucleus", "nucleus 4"),
    ]


@pytest.mark.parametrize("suffix", [".json", ".geojson"])
def test_strengths_and_junctions_come_back(suffix):
    found = decode_contours(to_bytes(RESULT, suffix), f"a{suffix}").contours
    assert (found[0].strength, found[1].junctions) == (12.5, (True, False))


def test_instances_with_something_in_them_come_back_to_a_fraction_of_a_pixel():
    closed = [contour for contour in RESULT.contours if contour.closed]
    found = decode_contours(to_bytes(RESULT, ".coco.json"), "a.coco.json")
    assert found.shape == RESULT.shape
    assert max(off(one, original) for one, original in zip(found.contours, closed, strict=True)) < NEAR
    assert [(one.name, one.color.lower()) for one in found.contours] == [
        (one.name, one.color.lower()) for one in closed
    ]


@pytest.mark.parametrize("suffix", [".png", ".tif", ".nii", ".nii.gz", ".nrrd"])
def test_outlines_of_a_label_mask_paint_the_same_mask(tmp_path, suffix):
    file = tmp_path / f"labels{suffix}"
    export(RESULT, file, warn=lambda sentence: None)
    painted = rasterize_labels(RESULT.contours, RESULT.shape)
    found = load_contours(file)
    assert all(contour.closed for contour in found)
    again = rasterize_labels(found, RESULT.shape)
    np.testing.assert_array_equal(again, painted)


def test_single_points_are_kept_beside_the_contours(tmp_path):
    for suffix in WHOLE:
        export(RESULT, tmp_path / f"a{suffix}")
        np.testing.assert_allclose(read_contours(tmp_path / f"a{suffix}").points, [(55.0, 80.5)], atol=NEAR)


def test_every_format_of_contours_in_a_plane_is_read_back():
    others = {".png", ".tif", ".tiff", ".nii", ".nii.gz", ".nrrd", ".roi", ".coco.json", ".measures.csv", ".table.csv"}
    assert set(CONTOURS_WRITABLE) - FIGURE_SUFFIXES == {*WHOLE, *others}


def test_drawings_for_cad_are_placed_by_the_image_they_belong_to(tmp_path):
    """Without what CPM tells in comments, unit and height come from the image."""
    export(RESULT, tmp_path / "a.dxf")
    lines = (tmp_path / "a.dxf").read_text("utf-8").splitlines()
    (tmp_path / "b.dxf").write_text("\n".join(lines[lines.index("  0") :]) + "\n", "utf-8")
    millimeters = Image(np.zeros((60, 90)), (0.5e-3, 0.25e-3), "mm")
    found = load_contours(tmp_path / "b.dxf", millimeters)
    assert max(off(one, original) for one, original in zip(found, RESULT.contours[:4], strict=True)) < NEAR
    assert read_contours(tmp_path / "b.dxf", describe_plane(millimeters)).notes == ()


def test_vertices_of_three_numbers_are_not_read_as_pairs():
    content = json.loads(to_bytes(result_of(Contour(np.array([(1.0, 2.0), (3.0, 4.0), (5.0, 2.0)]), True)), ".json"))
    content["contours"][0]["points"] = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]
    with pytest.raises(ValueError, match=r"a\.json is damaged"):
        decode_contours(json.dumps(content).encode(), "a.json")
