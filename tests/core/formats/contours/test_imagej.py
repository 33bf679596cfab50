"""ImageJ ROIs: roifile, and the published layout of a file, find in them what ImageJ is to show."""

import io
import zipfile
from dataclasses import replace

import numpy as np
import pytest
import roifile
from roifile import ROI_OPTIONS, ROI_TYPE

from cpm_core import Contour
from cpm_core.formats import export, to_bytes

from ..drawn import CELL, FIBRE, RESULT


def roi_of(contour):
    return roifile.ImagejRoi.frombytes(to_bytes(replace(RESULT, contours=(contour,)), ".roi"))


def test_a_closed_contour_is_a_polygon_that_counts_from_the_corners_of_pixels():
    roi = roi_of(CELL)
    assert (roi.roitype, roi.name, roi.stroke_color) == (ROI_TYPE.POLYGON, "cell", bytes((255, 0xE6, 0x9F, 0)))
    assert roi.options & ROI_OPTIONS.SUB_PIXEL_RESOLUTION
    points = roi.coordinates()
    np.testing.assert_allclose(points, CELL.points[:, ::-1] + 0.5, atol=1e-5)
    np.testing.assert_array_equal((roi.left, roi.top), np.floor(points.min(axis=0)))
    np.testing.assert_array_equal((roi.right, roi.bottom), np.ceil(points.max(axis=0)))
    assert np.abs(roi.integer_coordinates - (points - (roi.left, roi.top))).max() <= 0.5 + 1e-4


def test_an_open_contour_is_a_line_that_counts_from_the_centers_of_pixels():
    roi = roi_of(FIBRE)
    assert (roi.roitype, roi.name) == (ROI_TYPE.POLYLINE, "fibre")
    np.testing.assert_allclose(roi.coordinates(), FIBRE.points[:, ::-1], atol=1e-5)


def test_a_vertex_by_itself_is_a_point():
    roi = roi_of(Contour(np.array([[3.5, 7.25]]), False))
    assert (roi.roitype, roi.name) == (ROI_TYPE.POINT, "contour 1")
    assert roi.coordinates().tolist() == [[7.25, 3.5]]


@pytest.mark.parametrize("name", ["Kern β", "細胞", "🔬 nucleus 🔬"])
def test_a_name_has_all_its_letters(name):
    assert roi_of(replace(CELL, name=name)).name == name


def test_the_set_holds_all_contours_in_their_order_under_their_names(tmp_path):
    twice = (*RESULT.contours, replace(CELL, color=""), replace(FIBRE, name="a/b: c"))
    result = replace(RESULT, contours=twice)
    export(result, tmp_path / "a.zip")
    with zipfile.ZipFile(io.BytesIO(to_bytes(result, ".zip"))) as archive:
        assert archive.testzip() is None
        assert archive.namelist() == [
            *("cell.roi", "fibre.roi", "contour 3.roi", "Kern β.roi", "contour 5.roi", "cell-6.roi", "a_b_ c.roi"),
        ]
    rois = roifile.roiread(tmp_path / "a.zip")
    assert [roi.name for roi in rois] == ["cell", "fibre", "contour 3", "Kern β", "contour 5", "cell", "a/b: c"]
    for roi, contour in zip(rois, twice, strict=True):
        np.testing.assert_allclose(roi.coordinates(), contour.points[:, ::-1] + 0.5 * contour.closed, atol=1e-5)


def test_a_file_of_one_selection_refuses_none_and_several(tmp_path):
    with pytest.raises(ValueError, match=r"has 5 contours, but a \.roi file holds exactly one: export to \.zip"):
        export(RESULT, tmp_path / "a.roi")
    with pytest.raises(ValueError, match="has no contours"):
        export(replace(RESULT, contours=()), tmp_path / "a.roi")
    with pytest.raises(ValueError, match="ImageJ opens no empty set"):
        export(replace(RESULT, contours=()), tmp_path / "a.zip")
    assert list(tmp_path.iterdir()) == []
