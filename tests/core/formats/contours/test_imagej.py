"""ImageJ ROIs: read as ImageJ's decoder does, field by field at the offsets that it publishes."""

import io
import struct
import zipfile
from dataclasses import replace

import numpy as np
import pytest

from cpm_core import Contour
from cpm_core.formats import encoded, export

from ..drawn import CELL, FIBRE, RESULT

POLYGON, POLYLINE, POINT = 0, 5, 10


def short(data, offset):
    return struct.unpack_from(">h", data, offset)[0]


def integer(data, offset):
    return struct.unpack_from(">i", data, offset)[0]


def decoded(data):
    """Kind, box (top, left, bottom, right), points (x, y), colour and name."""
    assert data[:4] == b"Iout"
    assert short(data, 4) >= 222  # from which on coordinates may be fractions
    assert short(data, 50) & 128
    count = struct.unpack_from(">H", data, 16)[0] or integer(data, 18)
    whole = np.frombuffer(data, ">i2", 2 * count, 64).reshape(2, count)
    exact = np.frombuffer(data, ">f4", 2 * count, 64 + 4 * count).reshape(2, count)
    box = struct.unpack_from(">4h", data, 8)
    if max(box) < 32767:
        assert np.abs(whole + np.array([[box[1]], [box[0]]]) - exact).max() <= 0.5 + 1e-4
    second = integer(data, 60)
    start, length = integer(data, second + 16), integer(data, second + 20)
    name = data[start : start + 2 * length].decode("utf-16-be")
    assert len(data) == start + 2 * length
    return data[6], box, exact.T, struct.unpack_from(">I", data, 40)[0], name


def roi_of(contour):
    return decoded(encoded(replace(RESULT, contours=(contour,)), ".roi"))


def test_a_closed_contour_is_a_polygon_that_counts_from_the_corners_of_pixels():
    kind, (top, left, bottom, right), points, colour, name = roi_of(CELL)
    assert (kind, colour, name) == (POLYGON, 0xFFE69F00, "cell")
    np.testing.assert_allclose(points, CELL.points[:, ::-1] + 0.5, atol=1e-5)
    assert left <= points[:, 0].min() < left + 1
    assert top <= points[:, 1].min() < top + 1
    assert right - 1 < points[:, 0].max() <= right
    assert bottom - 1 < points[:, 1].max() <= bottom


def test_an_open_contour_is_a_line_that_counts_from_the_centres_of_pixels():
    kind, _, points, _, name = roi_of(FIBRE)
    assert (kind, name) == (POLYLINE, "fibre")
    np.testing.assert_allclose(points, FIBRE.points[:, ::-1], atol=1e-5)


def test_a_vertex_by_itself_is_a_point():
    kind, _, points, _, name = roi_of(Contour(np.array([[3.5, 7.25]]), False))
    assert (kind, points.tolist(), name) == (POINT, [[7.25, 3.5]], "contour 1")


def test_more_vertices_than_two_bytes_count_are_counted_in_four():
    angle = 2 * np.pi * np.arange(70000) / 70000
    points = 100 + 50 * np.stack([np.sin(angle), np.cos(angle)], axis=1)
    _, _, found, _, _ = roi_of(Contour(points, True))
    np.testing.assert_allclose(found, points[:, ::-1] + 0.5, atol=1e-4)


def test_the_set_holds_all_contours_in_their_order_under_their_names():
    twice = (*RESULT.contours, replace(CELL, colour=""), replace(FIBRE, name="a/b: c"))
    data = encoded(replace(RESULT, contours=twice), ".zip")
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        assert archive.testzip() is None
        names = archive.namelist()
        rois = [decoded(archive.read(name)) for name in names]
    assert names == [
        *("cell.roi", "fibre.roi", "contour 3.roi", "Kern β.roi", "contour 5.roi", "cell-6.roi", "a_b_ c.roi"),
    ]
    assert [roi[4] for roi in rois] == ["cell", "fibre", "contour 3", "Kern β", "contour 5", "cell", "a/b: c"]
    for roi, contour in zip(rois, twice, strict=True):
        np.testing.assert_allclose(roi[2], contour.points[:, ::-1] + 0.5 * contour.closed, atol=1e-5)


def test_a_file_of_one_selection_refuses_none_and_several(tmp_path):
    with pytest.raises(ValueError, match=r"has 5 contours, but a \.roi file holds exactly one: export to \.zip"):
        export(RESULT, tmp_path / "a.roi")
    with pytest.raises(ValueError, match="has no contours"):
        export(replace(RESULT, contours=()), tmp_path / "a.roi")
    with pytest.raises(ValueError, match="ImageJ opens no empty set"):
        export(replace(RESULT, contours=()), tmp_path / "a.zip")
    assert list(tmp_path.iterdir()) == []
