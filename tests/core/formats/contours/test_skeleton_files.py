"""Skeletons in files: what is read back is the skeleton, radii and all."""

import csv
import json
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from scipy import ndimage

from cpm_core import Contour, Skeleton
from cpm_core.formats import CONTOURS_WRITABLE, export, find_format_suffix, load_image
from tests.core.formats.masks.test_label_mask import indices

SVG = "{http://www.w3.org/2000/svg}"
STEM = Contour(np.array([[5.0, 10.2], [20.0, 10.4], [33.4, 10.0]]), False, 12.0, junctions=(False, True))
ARM = Contour(np.array([[33.4, 10.0], [33.0, 29.8]]), False, 11.0, junctions=(True, False))
LOOP = Contour(np.array([[10.0, 40.0], [10.0, 52.0], [22.0, 52.0], [22.0, 40.0]]), True, 9.0)
DOT = Contour(np.array([[40.0, 70.0]]), False, 8.0)
RADII = (np.array([2.0, 4.5, 6.25]), np.array([6.25, 1.0]), np.full(4, 3.0), np.array([8.5]))
SKELETON = Skeleton((STEM, ARM, LOOP, DOT), RADII, (50, 80), (0.5, 0.25), "µm", "U & <me>.png")
NOTHING = Skeleton((), (), (50, 80), (1.0, 1.0), None, "a.png")


def test_the_table_has_a_radius_for_each_vertex(tmp_path):
    export(SKELETON, tmp_path / "a.csv")
    with (tmp_path / "a.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    named = ["contour", "closed", "label", "strength", "vertex", "row", "col", "x_um", "y_um", "radius"]
    assert list(rows[0]) == [*named, "program", "image"]
    assert [int(row["contour"]) for row in rows] == [1, 1, 1, 2, 2, 3, 3, 3, 3, 4]
    assert [row["label"] for row in rows] == [row["contour"] for row in rows]
    points = [[float(row["row"]), float(row["col"])] for row in rows]
    np.testing.assert_allclose(points, np.concatenate([c.points for c in SKELETON.contours]), atol=1e-4)
    np.testing.assert_allclose([float(row["radius"]) for row in rows], np.concatenate(RADII), atol=1e-4)


def test_the_table_of_branches_has_their_thickness(tmp_path):
    export(SKELETON, tmp_path / "a.measures.csv")
    with (tmp_path / "a.measures.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    found = [[float(row[f"thickness_{name}_px"]) for name in ("min", "median", "max")] for row in rows]
    np.testing.assert_allclose(found, [[4.0, 9.0, 12.5], [2.0, 7.25, 12.5], [6.0] * 3, [17.0] * 3])


def test_the_shape_can_be_rebuilt_from_the_drawing(tmp_path):
    export(SKELETON, tmp_path / "a.svg")
    root = ET.parse(tmp_path / "a.svg").getroot()
    assert root.find(f"{SVG}title").text == "Skeleton of U & <me>.png"
    contours, radii = [], []
    for number, path in enumerate(root.findall(f".//{SVG}path"), start=1):
        closed = path.get("d").endswith("Z")
        points = np.array(re.findall(r"[ML]([-\d.]+) ([-\d.]+)", path.get("d")), float)[:, ::-1]
        radii.append(np.array(path.get("data-radii").split(), float))
        contours.append(Contour(points[: len(radii[-1])], closed))
        assert path.get("data-label") == str(number)
    again = Skeleton(tuple(contours), tuple(radii), (50, 80), (0.5, 0.25), "µm", "a.svg")
    assert [contour.closed for contour in contours] == [False, False, True, False]
    assert (again.rebuild_shape() == SKELETON.rebuild_shape()).all()


def test_each_branch_is_a_line_of_its_label_one_pixel_wide(tmp_path):
    export(SKELETON, tmp_path / "a.png")
    mask = indices(tmp_path / "a.png")
    assert mask.shape == (50, 80)
    assert np.unique(mask).tolist() == [0, 1, 2, 3, 4]
    row, col = np.nonzero(mask == 1)
    assert row.tolist() == list(range(5, 34))  # one pixel in each row
    assert (col == 10).all()
    row, col = np.nonzero(mask == 2)
    assert col.tolist() == list(range(11, 31))  # where they meet the longer one shows
    assert (row == 33).all()
    assert (mask == 3).sum() == 4 * 12
    assert np.argwhere(mask == 4).tolist() == [[40, 70]]
    assert ndimage.label(mask, np.ones((3, 3)))[1] == 3


def test_a_picture_without_a_skeleton_is_refused_and_the_others_are_empty(tmp_path):
    pictures = {".png", ".tif", ".tiff", ".nii", ".nii.gz", ".nrrd"}
    for suffix in pictures:
        with pytest.raises(ValueError, match=r"a\.png has no skeleton"):
            export(NOTHING, tmp_path / f"a{suffix}")
    with pytest.raises(ValueError, match=r"a\.png has no contours, but a \.roi file"):
        export(NOTHING, tmp_path / "a.roi")
    with pytest.raises(ValueError, match=r"a\.png has no contours, and ImageJ"):
        export(NOTHING, tmp_path / "a.zip")
    with pytest.raises(ValueError, match=r"a\.png .* closed"):
        export(NOTHING, tmp_path / "a.coco.json")
    empty = set(CONTOURS_WRITABLE) - pictures - {".roi", ".zip", ".coco.json"}
    export(NOTHING, *(tmp_path / f"a{suffix}" for suffix in empty))
    assert (tmp_path / "a.csv").read_text(encoding="utf-8").count("\n") == 1
    assert {find_format_suffix(path) for path in tmp_path.iterdir()} == empty


def test_every_format_of_contours_takes_branches_as_well(tmp_path):
    export(SKELETON, *(tmp_path / f"a{suffix}" for suffix in CONTOURS_WRITABLE if suffix != ".roi"))
    masks = [indices(tmp_path / "a.png"), load_image(tmp_path / "a.tif").values]
    assert np.array_equal(masks[0], masks[1])
    content = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
    assert "run" not in content
    for entry, contour, radii in zip(content["contours"], SKELETON.contours, RADII, strict=True):
        assert entry["radii"] == radii.tolist()
        np.testing.assert_allclose(entry["points"], contour.points)
    kinds = [feature["geometry"]["type"] for feature in json.loads((tmp_path / "a.geojson").read_bytes())["features"]]
    assert kinds == ["LineString", "LineString", "Polygon", "Point"]
