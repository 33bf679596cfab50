"""``cpm run STACK --pages``: all pages from the command line."""

import csv
import json

import numpy as np
import pytest
import tifffile

import cpm_core as cpm
from cpm_core.formats.sessions.session_file import SessionFile, save_session
from cpm_core.pages import follow as following
from cpm_core.shapes import Circle

from ..pages.drawn import MOVING, SHAPE, SPLITTING


@pytest.fixture(scope="module")
def stack(tmp_path_factory):
    """Five pages, the third of which is constant."""
    path = tmp_path_factory.mktemp("stack") / "cells.tif"
    pages = np.array([*MOVING[:2], np.full(SHAPE, 7.0), *MOVING[2:4]]).astype(np.uint8)
    tifffile.imwrite(path, pages, imagej=True, metadata={"axes": "TYX", "unit": "um"}, resolution=(2.0, 2.0))
    return path


FOLLOWED = ("--pages", "all", "--follow", "--circle", "32,22,5")


def test_all_pages_are_followed_and_a_bad_one_is_told(stack, command, tmp_path):
    status, out, err = command("run", stack, *FOLLOWED, "--export", tmp_path / "a.tif", tmp_path / "a.json")
    assert status == 1
    assert err.splitlines() == ["cpm: page 3: cells.tif is constant (7 everywhere) and has no edges: "
                                "open an image with objects."]  # fmt: skip
    assert "cells.tif: 5 pages, 1 track" in out
    assert "1 failed" in out
    labels = tifffile.imread(tmp_path / "a.tif")
    assert [page.max() for page in labels] == [1, 1, 0, 1, 1]


def test_the_command_finds_what_the_library_finds_to_the_bit(stack, command, tmp_path):
    command("run", stack, *FOLLOWED, "--export", tmp_path / "a.json")
    pages = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))["pages"]
    found = list(cpm.follow_pages(cpm.load_pages(stack), cpm.circle((32, 22), 5.0)))
    told = [[one["points"] for one in page.get("contours", [])] for page in pages]
    assert told == [[one.points.tolist() for one in page.contours] for page in found]
    assert found[0].result.unit == "µm"


def test_an_interrupt_keeps_what_is_done(stack, command, tmp_path, monkeypatch):
    def interrupted(*arguments, real=following.segment, **named):
        runs.append(arguments)
        if len(runs) == 4:
            raise KeyboardInterrupt
        return real(*arguments, **named)

    runs = []
    monkeypatch.setattr(following, "segment", interrupted)
    status, _, err = command("run", stack, *FOLLOWED, "--export", tmp_path / "a.json")
    assert status == 130
    assert "interrupted; 3 of 5 pages were done, and the files hold them" in err
    assert len(json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))["pages"]) == 3


def test_a_session_gives_start_and_parameters(stack, command, tmp_path):
    save_session(SessionFile(shapes=(Circle((32.0, 22.0), 5.0),)), tmp_path / "a.cpm")
    given = ("run", stack, "--pages", "all", "--follow", "--session", tmp_path / "a.cpm")
    command(*given, "--export", tmp_path / "a.csv")
    command("run", stack, *FOLLOWED, "--export", tmp_path / "b.csv")
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()


def test_an_object_is_followed_by_a_place_on_the_first_page(command, tmp_path):
    path = tmp_path / "cells.tif"
    tifffile.imwrite(path, np.array(SPLITTING).astype(np.uint8), imagej=True, metadata={"axes": "TYX"})
    place = ("--pages", "all", "--object", "32,44")
    status, _, err = command("run", path, *place)
    assert status == 2
    assert "--follow" in err
    status, out, _ = command(
        "run", path, *place, "--follow", "--export", tmp_path / "a.tif", tmp_path / "a.measures.csv"
    )
    assert status == 0
    assert "track 2 splits" in out
    labels = tifffile.imread(tmp_path / "a.tif")
    assert [np.unique(page).tolist() for page in labels] == [[0, 1], [0, 1], [0, 1], [0, 1, 2], [0, 1, 2]]
    rows = (tmp_path / "a.measures.csv").read_text(encoding="utf-8").splitlines()
    assert len(rows) == 8
    assert {"page", "track", "centroid_row", "net_area_px2", "mean_gray"} <= set(rows[0].split(","))


def test_the_objects_of_each_page_are_followed_over_the_time_that_the_file_states(command, tmp_path):
    about = {"axes": "TYX", "finterval": 60.0}
    tifffile.imwrite(tmp_path / "cells.tif", np.array(MOVING[:3]).astype(np.uint8), imagej=True, metadata=about)
    table = tmp_path / "a.measures.csv"
    status, out, _ = command("run", tmp_path / "cells.tif", "--pages", "all", "--objects", "--export", table)
    assert status == 0
    assert out.count("1 object\n") == 3
    rows = list(csv.DictReader(table.read_text(encoding="utf-8").splitlines()))
    assert [(row["page"], row["time_s"], row["track"]) for row in rows] == [("1", "0.0", "1"), ("2", "60.0", "1"),
                                                                           ("3", "120.0", "1")]  # fmt: skip
