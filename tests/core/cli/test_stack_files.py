"""Files of all pages of a stack, read by the programs that they are for."""

import csv
import io
import json

import numpy as np
import pytest
import roifile
import shapely
import tifffile

import cpm_core as cpm
from cpm_core.contours.contour import Contour
from cpm_core.formats.stack_files import export_stack
from cpm_core.pages.page import Page, StackResult
from cpm_core.pages.tracks import Tracker
from cpm_core.results.result import Result

from ..pages.drawn import MOVING, SHAPE, SPLITTING


@pytest.fixture(scope="module")
def found():
    """A disk that splits, on the last three of seven pages, with a page in between that could not be used."""
    pages = list(cpm.follow_pages(SPLITTING[1:], cpm.circle((32, 44), 5.0), numbers=[2, 3, 4]))
    pages = [Page(number, page.result, page.events) for number, page in zip((4, 5, 7), pages, strict=True)]
    return StackResult("cells.tif", 7, (*pages, Page(6, None, error="It is constant.")), "t", drawn=({"shape": "x"},))


def test_a_label_stack_has_a_page_for_each_page_and_tracks_as_labels(found, tmp_path):
    export_stack(found, tmp_path / "a.tif")
    with tifffile.TiffFile(tmp_path / "a.tif") as file:
        assert file.imagej_metadata["frames"] == 7
        labels = file.asarray()
    assert labels.shape == (7, *SHAPE)
    assert labels.dtype == np.uint16
    assert [np.unique(page).tolist() for page in labels] == [[0], [0], [0], [0, 1], [0, 1, 2], [0], [0, 1, 2]]
    for page, result in found.results:
        for contour in result.contours:
            assert (labels[page - 1] == contour.number).sum() == pytest.approx(contour.area, abs=25)


def test_the_measures_of_all_pages_are_one_table(found, tmp_path):
    export_stack(found, tmp_path / "a.measures.csv")
    rows = list(csv.DictReader(io.StringIO((tmp_path / "a.measures.csv").read_text(encoding="utf-8"))))
    assert [(row["page"], row["track"], row["label"]) for row in rows] == [
        (str(page), str(one.number), str(one.number)) for page, result in found.results for one in result.contours
    ]
    for row, contour in zip(rows, [one for _, result in found.results for one in result.contours], strict=True):
        center = shapely.Polygon(contour.points).centroid
        assert (float(row["centroid_row"]), float(row["centroid_col"])) == pytest.approx((center.x, center.y), abs=0.1)
        assert float(row["gross_area_px2"]) == pytest.approx(contour.area, abs=1e-4)
        assert float(row["contrast"]) > 0.5


def test_geojson_tells_page_track_and_the_plane_of_qupath(found, tmp_path):
    export_stack(found, tmp_path / "a.geojson")
    features = json.loads((tmp_path / "a.geojson").read_text(encoding="utf-8"))["features"]
    told = [(one["properties"]["page"], one["properties"]["track"], one["geometry"]["plane"]["t"]) for one in features]
    assert told == [(page, one.number, page - 1) for page, result in found.results for one in result.contours]
    assert features[-1]["properties"]["name"] == f"track {told[-1][1]}"


def test_a_set_of_selections_tells_the_page_of_each(found, tmp_path):
    export_stack(found, tmp_path / "a.zip")
    selections = roifile.roiread(tmp_path / "a.zip")
    assert [(one.position, one.name) for one in selections] == [
        (page, f"track {one.number}") for page, result in found.results for one in result.contours
    ]
    whole = StackResult("cells.tif", 7, found.pages, "z", alone=False)
    export_stack(whole, tmp_path / "b.zip")
    assert next((one.position, one.z_position) for one in roifile.roiread(tmp_path / "b.zip")) == (0, 4)


def test_a_stack_without_contours_refuses_what_would_be_empty_and_writes_the_rest(tmp_path):
    (bare,) = cpm.follow_pages(MOVING[:1], cpm.circle((32, 22), 5.0), cpm.Parameters(min_length=1e4))
    nothing, refused = StackResult("cells.tif", 1, (bare,)), {}
    files = [tmp_path / f"a{suffix}" for suffix in (".zip", ".tif", ".json", ".measures.csv")]
    export_stack(nothing, *files, refused=refused.__setitem__)
    assert sorted(path.suffix for path in refused) == [".tif", ".zip"]
    assert [path.exists() for path in files] == [False, False, True, True]
    with pytest.raises(ValueError, match=r"No contour of cells\.tif is closed"):
        export_stack(nothing, tmp_path / "b.tif")


@pytest.mark.parametrize("suffix", [".csv", ".measures.csv"])
def test_tables_say_once_how_each_track_begins_and_ends_and_where_it_comes_from(suffix, tmp_path):
    def box(number, top, left, height=20, width=20):
        corners = [[top, left], [top, left + width], [top + height, left + width], [top + height, left]]
        return Contour(np.array(corners, float), closed=True, number=number)

    drawn = [
        [box(0, 10, 10, 20, 40), box(0, 50, 50)],
        [box(0, 10, 10), box(0, 10, 33, 20, 18), box(0, 50, 71, 20, 18)],
        [box(0, 11, 10, 20, 42), box(0, 60, 20, 8, 8)],
        [box(0, 11, 10, 20, 42), box(0, 60, 20, 8, 8)],
        [box(0, 11, 10, 20, 42)],
    ]
    tracker, pages = Tracker(), []
    for number, contours in enumerate(drawn, start=1):
        numbered, events = tracker.assign_tracks(number, tuple(contours), (90, 90))
        result = Result(np.zeros((0, 2)), numbered, None, 1, True, "at rest", (90, 90), (1.0, 1.0), None, "cells.tif")
        pages.append(Page(number, result, events))
    export_stack(StackResult("cells.tif", len(pages), tuple(pages)), tmp_path / f"a{suffix}")
    rows = csv.DictReader((tmp_path / f"a{suffix}").read_text(encoding="utf-8").splitlines())
    told = {(int(row["track"]), int(row["page"])): (row["parent"], row["begin"], row["end"]) for row in rows}
    assert {place: said for place, said in told.items() if any(said)} == {
        (2, 1): ("", "", "ends"),
        (3, 2): ("1", "splits", "merges into 1"),
        (4, 2): ("", "enters", "leaves"),
        (5, 3): ("", "begins", ""),
        (5, 4): ("", "", "ends"),
    }
