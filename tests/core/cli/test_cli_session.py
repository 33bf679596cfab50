"""`cpm run --session` and `cpm batch`: a session file is applied without a window, to one image or to many."""

from __future__ import annotations

import csv
import errno
import multiprocessing
import shutil
import sys
import types
from concurrent.futures import Future
from pathlib import Path

import numpy as np
import PIL.Image
import pytest

import cpm_core
from cpm_core import Parameters, load_image
from cpm_core.cli import workers
from cpm_core.cli.workers import BatchJob, BatchRow, run_job
from cpm_core.formats.common.content import compute_fingerprint
from cpm_core.formats.sessions.session_file import ImageFile, SessionFile, save_session
from cpm_core.shapes import Circle, PolygonRegion

ROOT = Path(__file__).parents[3]
CENTERS, RADIUS = ((40.0, 30.0), (40.0, 75.0)), 14.0


@pytest.fixture
def disks(tmp_path):
    """Path of an image of two bright disks."""
    row, col = np.mgrid[:80, :105]
    values = sum(220 * np.clip(RADIUS + 0.5 - np.hypot(row - r, col - c), 0, 1) for r, c in CENTERS)
    PIL.Image.fromarray(values.astype(np.uint8)).save(tmp_path / "disks.png")
    return tmp_path / "disks.png"


@pytest.fixture
def session(disks, tmp_path):
    """Path of a session that starts in the left disk."""
    path = tmp_path / "left.cpm"
    shapes = (Circle(CENTERS[0], 6.0),)
    save_session(
        SessionFile(ImageFile(str(disks), compute_fingerprint(disks), (80, 105)), shapes, Parameters(scales=2)), path
    )
    return path


def test_a_session_does_what_its_parts_do_as_flags(told, session, disks, tmp_path):
    told("run", disks, "--circle", "40,30,6", "--scales", 2, "--max-steps", 60, "--export", tmp_path / "flags.csv")
    told("run", "--session", session, "--max-steps", 60, "--export", tmp_path / "session.csv")
    assert (tmp_path / "flags.csv").read_text() == (tmp_path / "session.csv").read_text()
    assert told("run", "--session", session, "--circle", "40,75,6", "--max-steps", 300)["contours"] == 2
    assert told("run", "--session", session, "--max-steps", 60, "--min-length", 1000)["contours"] == 0


def test_the_regions_of_a_session_act(told, disks, tmp_path):
    right = PolygonRegion(((0.0, 52.0), (0.0, 104.0), (79.0, 104.0), (79.0, 52.0)))
    path, mask = tmp_path / "a.cpm", tmp_path / "mask.png"
    save_session(SessionFile(shapes=(Circle(CENTERS[1], 6.0), right), parameters=Parameters(scales=2)), path)
    told("run", disks, "--session", path, "--export", mask)
    found = load_image(mask).values
    assert found[40, 75] > 0 and not found[:, :50].any()


def test_what_the_user_should_know_of_a_session_is_reported(command, session, disks):
    values = np.array(PIL.Image.open(disks))
    PIL.Image.fromarray(values // 2).save(disks)
    session.write_text(session.read_text().replace('"beta"', '"viscosity": 1, "beta"'))
    status, _, err = command("run", "--session", session, "--max-steps", 5)
    assert status == 0
    assert "viscosity" in err
    assert "has changed since" in err


def table(folder):
    with (folder / "summary.csv").open(newline="") as stream:
        return list(csv.DictReader(stream))


def test_a_batch_does_to_each_image_what_a_run_does_and_reports_a_bad_one(command, session, disks, tmp_path):
    (tmp_path / "bad.png").write_text("no picture")
    out = tmp_path / "deep" / "out"
    status, reported, err = command(
        "batch", disks, tmp_path / "bad.png", disks, "--session", session, "--output", out,
        "--workers", 1, "--max-steps", 40, "--contours", "--export", ".csv", ".svg",
    )  # fmt: skip
    assert status == 1
    assert "bad.png is" in err
    assert "3 images" in reported
    names = {path.name for path in out.iterdir()}
    endings = ("vertices.csv", "svg")
    assert names == {"summary.csv", *(f"disks{n}_contours.{s}" for n in ("", "_2") for s in endings)}
    command("run", "--session", session, "--max-steps", 40, "--export", tmp_path / "one.csv")
    assert (out / "disks_contours.vertices.csv").read_bytes() == (tmp_path / "one.csv").read_bytes()
    rows = table(out)
    assert [Path(row["image"]).name for row in rows] == ["disks.png", "bad.png", "disks.png"]
    assert [bool(row["trouble"]) for row in rows] == [False, True, False]
    assert rows[0]["contours"] == rows[2]["contours"] == "1"


@pytest.mark.long
def test_an_image_whose_process_dies_is_tried_once_more_and_the_others_go_on(disks, monkeypatch):
    whole, killed = workers.wait, []

    def killing(working, *given):
        if not killed:
            killed.extend(multiprocessing.active_children())
            for process in killed:
                process.kill()
        return whole(working, *given)

    monkeypatch.setattr(workers, "wait", killing)
    made = SessionFile(shapes=(Circle(CENTERS[0], 6.0),))
    jobs = [BatchJob(number, BatchRow("disks"), str(disks), made, Parameters(scales=2), 3, ()) for number in range(3)]
    found = sorted((job.number, row.trouble) for job, row in workers.run_locally(jobs, 2))
    assert killed
    assert found == [(0, ""), (1, ""), (2, "")]


def test_where_no_process_can_be_started_one_worker_is_advised(tmp_path, command, disks, monkeypatch):
    def refuse(*_):
        raise PermissionError(errno.EACCES, "Permission denied")  # as without shared memory

    monkeypatch.setattr(workers, "ProcessPoolExecutor", refuse)
    monkeypatch.setattr(workers, "is_compiled", lambda: True)
    save_session(SessionFile(shapes=(Circle(CENTERS[0], 6.0),)), tmp_path / "a.cpm")
    other = shutil.copy(disks, tmp_path / "other.png")
    line = ("batch", disks, other, "--session", tmp_path / "a.cpm", "--output", tmp_path / "o", "--workers", 2)
    status, _, err = command(*line)
    assert status == 2
    assert err.endswith("cannot be started (Permission denied), which need shared memory: use one worker.\n")


class Cluster:
    """Replaces dask where it is not installed: does everything at once in this process."""

    def __init__(self, address, timeout):
        if "nowhere" in address:
            raise TimeoutError("timed out")

    def close(self, timeout):
        assert timeout

    def map(self, work, jobs, pure):
        assert not pure
        futures = []
        for job in jobs:
            future = Future()
            future.release = lambda: None
            if "die" in job.path:
                future.set_exception(RuntimeError("the worker is gone"))
            else:
                future.set_result(work(job))
            futures.append(future)
        return futures

    def cancel(self, futures):
        assert not futures


def test_a_batch_is_given_to_a_scheduler(command, session, disks, monkeypatch, tmp_path):
    module = types.ModuleType("distributed")
    module.Client, module.LocalCluster, module.as_completed = Cluster, None, reversed
    monkeypatch.setitem(sys.modules, "distributed", module)
    batch = ("batch", disks, tmp_path / "die.png", "--session", session, "--output", tmp_path / "o", "--scheduler")
    status, _, err = command(*batch, "tcp://there:8786", "--max-steps", 5)
    assert status == 1
    assert "the worker is gone" in err
    assert [row["contours"] for row in table(tmp_path / "o")] == ["1", ""]
    for words in ("no scheduler answers", "pip install distributed"):
        status, _, err = command(*batch, "tcp://nowhere")
        assert (status, err.count("\n")) == (2, 1)
        assert words in err
        monkeypatch.setitem(sys.modules, "distributed", None)


@pytest.fixture
def counted_jobs(monkeypatch):
    """Names of the images that are worked on."""
    names = []

    def counting(job):
        names.append(Path(job.path).name)
        return run_job(job)

    monkeypatch.setattr(workers, "run_job", counting)
    return names


def test_a_second_batch_does_only_what_is_not_done_in_the_same_way(command, session, disks, tmp_path, counted_jobs):
    bad, other, out = tmp_path / "bad.png", tmp_path / "other.png", tmp_path / "o"
    bad.write_text("no picture")
    shutil.copy(disks, other)
    rest = ("--session", session, "--output", out, "--workers", 1, "--contours", "--export", "svg")
    short = ("--max-steps", 2)

    def done(*given):
        counted_jobs.clear()
        status, _, err = command("batch", *given, *rest)
        return status, list(counted_jobs), "done before" in err

    assert done(disks, bad, *short) == (1, ["disks.png", "bad.png"], False)
    (first, _) = table(out)
    assert first["image_sha256"] == compute_fingerprint(disks) and first["session_sha256"] == compute_fingerprint(
        session
    )
    assert (first["version"], first["files"]) == (cpm_core.__version__, "disks_contours.svg")
    assert first["settings"] == "max_steps=2 contours=.svg" and first["finished"].endswith("Z")
    shutil.copy(disks, bad)  # it has been repaired
    assert done(disks, bad, *short) == (0, ["bad.png"], True)
    for change in (("--max-steps", 3), (*short, "--beta", 0.3), (*short, "--again")):
        assert done(disks, bad, *change) == (0, ["disks.png", "bad.png"], False)
    (out / "disks_contours.svg").unlink()
    assert done(disks, bad, *short) == (0, ["disks.png"], True)
    rows = table(out)
    assert done(other, *short)[0] == 0  # rows of other images stay
    assert table(out)[:2] == rows and len(table(out)) == 3
    whole = (out / "summary.csv").read_bytes()
    (out / "summary.csv").write_bytes(whole[:-40])  # as a kill may cut it short
    assert done(disks, bad, other, *short) == (0, ["other.png"], True)


def test_a_batch_of_images_of_the_same_name_overwrites_nothing_of_an_earlier_one(command, session, disks, tmp_path):
    out, again = tmp_path / "o", tmp_path / "again" / "disks.png"
    again.parent.mkdir()
    PIL.Image.open(disks).transpose(PIL.Image.Transpose.FLIP_TOP_BOTTOM).save(again)
    for image in (disks, again):
        command(
            "batch", image, "--session", session, "--output", out, "--max-steps", 5, "--contours", "--export", ".csv"
        )
    assert [row["files"] for row in table(out)] == ["disks_contours.vertices.csv", "disks_2_contours.vertices.csv"]


def test_an_image_with_open_contours_only_keeps_all_files_that_can_hold_them(command, tmp_path):
    row, col = np.mgrid[:60, :100]
    PIL.Image.fromarray((220 * (np.hypot(row - 12, col - 50) < 20)).astype(np.uint8)).save(tmp_path / "cut.png")
    save_session(SessionFile(shapes=(Circle((14.0, 50.0), 10.0),)), tmp_path / "a.cpm")
    line = ("batch", tmp_path / "cut.png", "--session", tmp_path / "a.cpm", "--output", tmp_path / "o", "--contours")
    status, out, err = command(*line)
    assert status == 1
    assert "cut.png: .png was not written: " in err
    assert ", 1 without some files; wrote " in out
    assert command(*line)[0] == 1  # done before
    (row,) = table(tmp_path / "o")
    assert (row["closed"], row["trouble"], row["files"]) == ("0", "", "cut_contours.svg; cut_contours.csv")
    assert "cut.png" in row["notes"]
    assert command(*line, "--export", "png", "--again")[0] == 1  # nothing at all can be written


def test_one_table_joins_the_measures_of_all_images_of_a_folder(command, session, disks, tmp_path):
    out, tables = tmp_path / "o", []
    for shift in range(3):
        image, alone = tmp_path / f"{shift}.png", tmp_path / f"{shift}.measures.csv"
        PIL.Image.fromarray(np.roll(PIL.Image.open(disks), shift, axis=1)).save(image)
        run = ("--session", session, "--max-steps", 60)
        command("run", image, *run, "--export", alone)
        tables += csv.DictReader(alone.read_text().splitlines())
        command("batch", image, *run, "--output", out, "--workers", 1, "--contours")
    with (out / "measures.csv").open(newline="") as stream:
        joined = csv.DictReader(stream)
        assert (joined.fieldnames[0], list(joined)) == ("image", tables)
    assert [row["image"] for row in tables] == ["0.png", "1.png", "2.png"]
