"""Contours are read from what CPM, QuPath and labelme write; anything else is refused in one sentence."""

import json
import struct
import warnings
import zlib

import pytest
from PIL import Image
from roifile import ROI_TYPE, ImagejRoi

from cpm_core import load_truth
from cpm_core.formats.contour_file import load_contours
from cpm_core.formats.contours.mask import read_color_indices


def written(tmp_path, content, name="a.json"):
    text = content if isinstance(content, str) else json.dumps(content)
    (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path / name


RING = [[1, 1], [9, 1], [9, 9], [1, 9], [1, 1]]
INNER = [[3, 3], [3, 6], [6, 6], [6, 3], [3, 3]]


@pytest.mark.parametrize(
    "content",
    [
        {"type": "Polygon", "coordinates": [RING, INNER]},
        {"type": "MultiPolygon", "coordinates": [[RING, INNER]]},
        {"type": "Feature", "geometry": {"type": "Polygon", "coordinates": [RING, INNER]}, "properties": None},
        [{"type": "Feature", "geometry": {"type": "Polygon", "coordinates": [RING, INNER]}, "properties": {}}],
        {"type": "GeometryCollection", "geometries": [{"type": "Polygon", "coordinates": [RING, INNER]}]},
    ],
)
def test_holes_of_foreign_polygons_are_contours(tmp_path, content):
    outer, hole = load_contours(written(tmp_path, content, "a.geojson"))
    assert outer.closed
    assert hole.closed
    assert outer.points.tolist() == [[0.5, 0.5], [0.5, 8.5], [8.5, 8.5], [8.5, 0.5]]
    assert (outer.area, hole.area) == (64.0, 9.0)


def test_lines_of_geojson_are_open_contours(tmp_path):
    lines = {"type": "MultiLineString", "coordinates": [[[1, 2], [3, 4]], [[5, 6, 0], [7, 8, 0]]]}
    one, other = load_contours(written(tmp_path, lines, "a.geojson"))
    assert (one.closed, other.closed) == (False, False)
    assert other.points.tolist() == [[5.5, 4.5], [7.5, 6.5]]


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("a.json", "{", "is damaged or contains no contours"),
        ("a.json", "3", "is damaged or contains no contours"),
        ("a.json", {"type": "Sphere"}, "is damaged or contains no contours"),
        ("a.json", {"shapes": [{"shape_type": "polygon", "points": [1], "label": ""}]}, "is damaged"),
        ("a.json", {"images": [], "annotations": []}, "contains no contours"),
        ("a.geojson", {"type": "FeatureCollection", "features": []}, "contains no contours"),
        ("a.geojson", {"type": "LineString", "coordinates": [[1, "x"], [2, 3]]}, "is damaged"),
        ("a.geojson", '{"type": "LineString", "coordinates": [[1, NaN], [2, 3]]}', "not finite numbers"),
        ("a.csv", "row,col\n1,2\n", "has no column closed or contour"),
        ("a.csv", "", "has no column"),
        ("a.csv", "contour,closed,row,col\n1,TRUE,x,2\n", "is damaged"),
        ("a.csv", "contour,closed,row,col\n1,TRUE,1,2\n", "contains no contours"),
    ],
)
def test_files_without_contours_are_refused_in_a_sentence_that_names_them(tmp_path, name, content, sentence):
    with pytest.raises(ValueError, match=sentence) as caught:
        load_contours(written(tmp_path, content, name))
    assert name in str(caught.value)


def chunk(kind, body):
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def test_a_selection_without_vertices_is_told_and_compared_with_nothing(tmp_path):
    content = bytearray(ImagejRoi(version=228, roitype=ROI_TYPE.POLYLINE, left=2, top=3, right=9, bottom=8).tobytes())
    (tmp_path / "a.roi").write_bytes(content)
    with pytest.raises(ValueError, match=r"^a.roi contains no contours"):
        load_contours(tmp_path / "a.roi")
    with pytest.raises(ValueError, match=r"^a.roi contains no contours"):
        load_truth(tmp_path / "a.roi", (20, 20))


def test_only_the_size_of_a_picture_decides_whether_its_color_indices_are_read(tmp_path, monkeypatch):
    picture = Image.new("P", (20, 12), 3)
    picture.putpalette(range(12))
    picture.save(tmp_path / "a.png")

    def open_while_another_thread_warns(*arguments, **named):
        warnings.warn("of another thread", RuntimeWarning, stacklevel=1)
        return opened(*arguments, **named)

    opened = Image.open
    monkeypatch.setattr(Image, "open", open_while_another_thread_warns)
    with pytest.warns(RuntimeWarning, match="of another thread"):
        assert (read_color_indices(tmp_path / "a.png") == 3).all()
    monkeypatch.setattr(Image, "open", opened)
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 200)
    assert read_color_indices(tmp_path / "a.png") is None
