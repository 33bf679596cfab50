"""Contours in and out of the command line: starts, truths, sessions that the window opens, and other formats."""

import json
from itertools import pairwise

import numpy as np
import pytest
from cpm_app.model.document.document import ImageReference
from cpm_app.session.timeline.runs_json import runs_from_json

from cpm_core import load_centerlines, load_contours, load_image, load_surface, load_volume
from cpm_core.formats.sessions.session_file import load_session
from cpm_core.shapes import Circle, Polygon


@pytest.fixture
def found(disk, command, tmp_path):
    """The session of a run, and the contours that it found."""
    files = (tmp_path / "a.json", tmp_path / "mask.png")
    status, _, err = command(
        "run", disk, "--circle", "40,50,9", "--save-session", tmp_path / "a.cpm", "--export", *files
    )
    assert (status, err) == (0, "")
    return tmp_path / "a.cpm", tmp_path / "a.json"


def test_a_saved_session_holds_the_run_at_its_end_as_the_window_reads_it(found, disk):
    session = load_session(found[0])
    assert session.shapes == (Circle((40.0, 50.0), 9.0),)
    assert session.image.path == disk.name
    reference = ImageReference.from_image(disk, load_image(disk))
    stored, fault = runs_from_json(session.runs, reference)
    assert fault == ""
    ((place, state),) = stored.states.items()
    assert place == stored.shown_step
    (branch,) = stored.runs[0].branches
    assert branch.last == state.step
    assert state.converged


def test_export_writes_what_a_session_shows_without_running_again(found, command, tmp_path, monkeypatch):
    monkeypatch.setattr(
        "cpm_core.formats.sessions.session_run.segment", lambda *_, **__: pytest.fail("it was run again")
    )
    session, contours = found
    status, out, err = command("export", session, "--to", tmp_path / "b.json", tmp_path / "b.zip", "--json")
    assert (status, err, json.loads(out)["contours"]) == (0, "", 1)
    (before,), (after,) = load_contours(contours), load_contours(tmp_path / "b.json")
    np.testing.assert_array_equal(after.points, before.points)
    made = json.loads((tmp_path / "b.json").read_text("utf-8"))["provenance"]
    assert made["shapes"] == [{"shape": "circle", "center": [40.0, 50.0], "radius": 9.0}]


def test_export_runs_a_session_without_a_recorded_run(found, command, tmp_path):
    session, contours = found
    plain = json.loads(session.read_text("utf-8"))
    del plain["runs"]
    session.write_text(json.dumps(plain), "utf-8")
    assert command("export", session, "--to", tmp_path / "b.json")[0] == 0
    np.testing.assert_array_equal(load_contours(tmp_path / "b.json")[0].points, load_contours(contours)[0].points)


def test_export_turns_one_format_into_another(found, disk, command, tmp_path):
    names = ("a.json", "b.svg", "c.dxf", "d.geojson", "e.coco.json")
    for source, target in pairwise(names):
        status, _, err = command("export", tmp_path / source, "--to", tmp_path / target, "--image", disk)
        assert (status, err) == (0, "")
    (first,), (last,) = load_contours(tmp_path / "a.json"), load_contours(tmp_path / "e.coco.json")
    apart = np.linalg.norm(first.points[:, None] - last.points, axis=2).min(axis=1)
    assert apart.max() < 0.01


def test_a_run_starts_from_contours_of_a_file_and_keeps_them_as_shapes(disk, told, tmp_path):
    ring = {"type": "Polygon", "coordinates": [[[44, 34], [57, 34], [57, 47], [44, 47], [44, 34]]]}
    (tmp_path / "start.geojson").write_text(json.dumps(ring), "utf-8")
    saved = tmp_path / "b.cpm"
    facts = told("run", disk, "--start", tmp_path / "start.geojson", "--save-session", saved)
    assert facts["closed"] == 1
    assert facts["provenance"]["shapes"] == [{"shape": "points", "file": "start.geojson"}]
    (shape,) = load_session(saved).shapes
    assert isinstance(shape, Polygon)
    assert set(shape.points) == {(33.5, 43.5), (33.5, 56.5), (46.5, 56.5), (46.5, 43.5)}


def test_a_run_is_compared_with_a_truth(found, disk, command, told, tmp_path):
    run = ("run", disk, "--circle", "40,50,9", "--truth")
    agreed = told(*run, tmp_path / "mask.png")["truth"]
    assert agreed["source"] == "mask.png"
    assert agreed["dice"] > 0.98
    assert "Compared with a.json: Dice 1.000" in command(*run, tmp_path / "a.json")[1]


@pytest.fixture(scope="module")
def ball(tmp_path_factory):
    """Path of a volume with a ball of radius 6 that lies somewhere in space, and of its labels."""
    nibabel = pytest.importorskip("nibabel")
    folder = tmp_path_factory.mktemp("ball")
    distance = np.sqrt(((np.indices((20, 22, 24)) - [[[[9.5]]], [[[10.5]]], [[[11.5]]]]) ** 2).sum(axis=0))
    affine = np.array([(-0.5, 0, 0, 40), (0, -0.5, 0, 60), (0, 0, 0.5, -900), (0, 0, 0, 1.0)])
    rod = np.zeros(distance.shape)
    rod[8:13, 9:14, 3:21] = 1.0
    for name, values in (
        ("ball", 200.0 * np.clip(6.5 - distance, 0.0, 1.0)),
        ("labels", distance < 6.0),
        ("rod", rod),
    ):
        file = nibabel.Nifti1Image(values.astype(np.float32).transpose(), affine)
        file.header.set_xyzt_units("mm")
        nibabel.save(file, folder / f"{name}.nii")
    return folder / "ball.nii"


def test_a_surface_that_was_written_is_a_start_and_is_written_in_other_formats(ball, told, tmp_path):
    written = (tmp_path / "a.ply", tmp_path / "a.points.csv")
    first = told("run", ball, "--sphere", "9.5,10.5,11.5,3", "--export", *written)
    before = load_surface(written[0], load_volume(ball))
    for start in (("--start", written[0]), ("--start", ball.with_name("labels.nii")), ("--points", written[1])):
        again = told("run", ball, "--volume", *start)
        assert again["converged"]
        assert again["volume"] == pytest.approx(first["volume"], rel=0.02)
    files = (tmp_path / "c.obj", tmp_path / "c.nii.gz", tmp_path / "c.vtk")
    facts = told("export", written[0], "--image", ball, "--to", *files, "--space", "RAS")
    assert facts["faces"] == first["faces"]
    assert b"SPACE=RAS" in files[0].read_bytes()
    for file in (files[0], files[2]):
        after = load_surface(file, load_volume(ball))
        assert np.abs(after.vertices - before.vertices).max() < 0.01
    assert np.count_nonzero(load_volume(files[1]).values) * 0.5**3 == pytest.approx(first["volume"], rel=0.05)


def test_labels_become_a_surface_and_center_lines_change_their_space(ball, command, tmp_path):
    status, out, err = command("export", ball.with_name("labels.nii"), "--to", tmp_path / "a.stl")
    assert (status, err) == (0, "")
    assert out.startswith("labels.nii: a surface of ")
    ball.with_name("labels.txt").write_text('1 9 8 7 1 1 1 "ball"')
    status, out, err = command("export", ball.with_name("labels.nii"), "--to", tmp_path / "a.nii.gz")
    assert (status, err) == (0, "")
    before, after = (load_volume(path).values for path in (ball.with_name("labels.nii"), tmp_path / "a.nii.gz"))
    assert np.array_equal(before, after)
    assert '9    8    7        1  1  1    "ball"' in (tmp_path / "a.txt").read_text()
    status, _, err = command("skeleton", ball.with_name("rod.nii"), "--volume", "--export", tmp_path / "a.swc")
    assert status == 0
    status, out, err = command("export", tmp_path / "a.swc", "--to", tmp_path / "b.swc", "--space", "RAS", "--json")
    assert (status, err) == (0, "")
    one, other = (load_centerlines(tmp_path / name, load_volume(ball)) for name in ("a.swc", "b.swc"))
    assert len(one.branches) == len(other.branches) == json.loads(out)["contours"]
