"""The command that compares methods: what it prints, what it writes, and what it refuses."""

import csv
import dataclasses
import io
import json

import numpy as np
import PIL.Image
import pytest
import tifffile

from cpm_core.formats.sessions.session_file import SessionFile, save_session
from cpm_core.methods import CONTOUR_METHODS
from cpm_core.parameters import Parameters
from cpm_core.shapes import Ellipse

ROW, COL = np.indices((56, 60))
DISK = np.hypot(ROW - 27, COL - 30) < 14
QUICK = ("cpm", "gvf", "geodesic")
CIRCLE = ("--circle", "27,30,9")


@pytest.fixture
def image(tmp_path):
    PIL.Image.fromarray(np.where(DISK, 200, 40).astype(np.uint8)).save(tmp_path / "disk.png")
    return tmp_path / "disk.png"


@pytest.fixture
def mask(tmp_path):
    PIL.Image.fromarray(np.where(DISK, 255, 0).astype(np.uint8)).save(tmp_path / "mask.png")
    return tmp_path / "mask.png"


def test_methods_are_told_in_the_order_in_which_they_are_named_with_a_table(image, mask, told, tmp_path):
    path = tmp_path / "a.csv"
    facts = told("compare", image, *CIRCLE, "--methods", *QUICK, "--truth", mask, "--export", path)
    assert [row["method"] for row in facts["methods"]] == list(QUICK)
    for row in facts["methods"]:
        assert row["converged"] and row["contours"] == row["closed"] == 1 and row["steps"] > 1 and row["seconds"] > 0.0
        assert row["dice"] > 0.95 and row["f"] > 0.99 and row["hausdorff"] < 2.0 and row["mean_distance"] < 1.0
    rows = list(csv.DictReader(io.StringIO(path.read_text(encoding="utf-8"))))
    assert [row["method"] for row in rows] == list(QUICK)


def test_all_methods_are_compared_unless_some_are_named(image, told):
    rows = told("compare", image, *CIRCLE, "--max-steps", 1)["methods"]
    assert [row["method"] for row in rows] == list(CONTOUR_METHODS)
    assert {row["steps"] for row in rows} == {1}
    reasons = {row["method"]: row["stop_reason"] for row in rows}
    assert reasons["cpm"] == "stopped after 1 step, as requested"


def test_the_contours_of_each_method_are_written_in_the_formats_of_runs(image, command, tmp_path):
    paths = tmp_path / "a.json", tmp_path / "a.tif", tmp_path / "a.measures.csv"
    status, out, err = command("compare", image, *CIRCLE, "--methods", "gvf", "geodesic", "--export", *paths)
    written = [
        tmp_path / f"a.{name}{suffix}" for suffix in (".json", ".tif", ".measures.csv") for name in ("gvf", "geodesic")
    ]
    assert (status, err) == (0, "")
    assert out.splitlines()[-6:] == [f"Wrote {path}" for path in written]
    assert set(tmp_path.glob("a.*")) == set(written)
    for name in ("gvf", "geodesic"):
        facts = json.loads((tmp_path / f"a.{name}.json").read_text(encoding="utf-8"))
        assert facts["provenance"]["method"] == name
        assert facts["provenance"]["parameters"] == dataclasses.asdict(CONTOUR_METHODS[name].settings())
        assert facts["provenance"]["shapes"][0]["shape"] == "polygon"
        assert len(facts["contours"]) == 1
        labels = tifffile.imread(tmp_path / f"a.{name}.tif")
        assert 2 * (labels.astype(bool) & DISK).sum() / (labels.astype(bool).sum() + DISK.sum()) > 0.95


def test_a_start_around_the_object_is_one_when_it_is_said_so(image, mask, told):
    run = ("compare", image, "--circle", "27,30,22", "--methods", "geodesic", "morph_gac", "--truth", mask)
    outwards, inwards = ([row["f"] for row in told(*run, *more)["methods"]] for more in ((), ("--around",)))
    assert max(outwards) < 0.1 and min(inwards) > 0.9


def test_a_session_gives_the_start_and_the_parameters_of_the_particles(image, told, tmp_path):
    shapes, parameters = (Ellipse((27.0, 30.0), (9.0, 9.0)),), Parameters(beta=0.4)
    session, file = tmp_path / "a.cpm", tmp_path / "a.json"
    save_session(SessionFile(image=None, shapes=shapes, parameters=parameters), session)
    run = ("compare", image, "--session", session, "--max-steps", 2, "--export", file, "--methods", "cpm", "geodesic")
    facts = told(*run, "--set", "geodesic.balloon=0.4")
    assert not facts["around"] and [row["contours"] for row in facts["methods"]] == [1, 1]
    for name, setting in (("cpm", "beta"), ("geodesic", "balloon")):
        found = json.loads((tmp_path / f"a.{name}.json").read_text(encoding="utf-8"))
        assert found["provenance"]["parameters"][setting] == 0.4
