"""``cpm run VOLUME --sphere``: what it prints, and what it refuses."""

import csv
import json

import nibabel
import numpy as np
import pytest
import tifffile

from cpm_core.formats.sessions.session_file import ImageFile, SessionFile, save_session
from cpm_core.parameters import PRESETS
from cpm_core.shapes import BoxRegion, Circle, Everywhere, Sphere

SPHERE = ("--sphere", "9.5,9.5,9.5,3")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("volumes")
    grid = np.indices((20, 20, 20)) - 9.5
    values = (200.0 * np.clip(6.5 - np.sqrt((grid**2).sum(axis=0)), 0.0, 1.0)).astype(np.float32)
    np.save(folder / "ball.npy", values)
    np.save(folder / "plane.npy", values[10])
    np.save(folder / "labels.npy", (values > 100.0).astype(np.uint8))
    return folder


def test_an_object_that_a_place_lies_in_is_written_alone_and_compared_with_labels(folder, told, command, tmp_path):
    run = ("run", folder / "ball.npy", *SPHERE, "--object")
    facts = told(
        *run, "9.5,9.5,9.5", "--space", "RAS", "--export", tmp_path / "a.ply", "--truth", folder / "labels.npy"
    )
    assert facts["volume"] == pytest.approx(4.0 / 3.0 * np.pi * 6.0**3, rel=0.05)
    assert facts["area"] == pytest.approx(4.0 * np.pi * 6.0**2, rel=0.05)
    assert b"SPACE=RAS" in (tmp_path / "a.ply").read_bytes()
    status, _, err = command("export", tmp_path / "a.ply", "--to", tmp_path / "b.stl", "--surface-smoothing", "5")
    assert status == 0 and "on average and by" in err
    status, _, err = command("export", tmp_path / "a.ply", "--to", tmp_path / "b.stl", "--surface-triangles", "2")
    assert (status, "must be above 0" in err) == (2, True)
    agreed = facts["truth"]
    assert (agreed["source"], agreed["unit"]) == ("labels.npy", None)
    assert agreed["dice"] > 0.97 and agreed["mean_distance"] < 0.4
    assert agreed["hausdorff95"] <= agreed["hausdorff"] < 1.5
    everywhere = told("run", folder / "ball.npy", "--volume", "--auto", "grid", "--object", "9.5,9.5,9.5")
    assert everywhere["volume"] == pytest.approx(facts["volume"], rel=0.02)
    status, _, err = command(*run, "1,1,1")
    assert status == 2 and "no object" in err
    status, _, err = command("run", folder / "ball.npy", *SPHERE, "--truth", folder / "plane.npy")
    assert (status, err.startswith("cpm: plane.npy ")) == (2, True)


def test_a_click_without_a_start_compiles_nothing_of_a_run(folder, told, monkeypatch):
    monkeypatch.setattr("cpm_core.cli.run.ensure_compiled", lambda **_: pytest.fail("nothing runs"))
    facts = told("run", folder / "ball.npy", "--volume", "--object", "9.5,9.5,9.5")
    assert facts["steps"] == 0 and facts["volume"] > 0.0


def test_the_plane_that_is_taken_of_a_volume_is_named_whatever_the_kind_of_file(folder, command):
    volume = np.load(folder / "ball.npy")
    axes = {"axes": "ZYX", "spacing": 2.0, "unit": "um"}
    tifffile.imwrite(folder / "ball.tif", volume, imagej=True, metadata=axes)
    nibabel.save(nibabel.Nifti1Image(volume.T, np.eye(4)), folder / "ball.nii")
    found = []
    for name in ("ball.npy", "ball.tif", "ball.nii"):
        status, out, err = command("run", folder / name, "--circle", "9.5,9.5,3", "--json")
        lines = err.splitlines()
        assert status == 0
        assert any("of which" in line and "11 of 20 was taken" in line for line in lines)
        assert f"cpm: {name}: --volume runs all of its planes." in lines
        found.append(json.loads(out)["particles"])
    assert found[0] == found[1] == found[2] > 0
    assert "--volume" not in command("run", folder / "ball.npy", "--page", 3, "--auto", "grid")[2]


def test_of_several_true_objects_it_is_told_that_all_are_compared_with(folder, command, tmp_path):
    labels = np.load(folder / "labels.npy")
    labels[:10] *= 2
    np.save(tmp_path / "two.npy", labels)
    for file, told in ((tmp_path / "two.npy", True), (folder / "labels.npy", False)):
        status, out, _ = command("run", folder / "ball.npy", *SPHERE, "--truth", file)
        assert (status, "with all of its 2 objects together" in out) == (0, told)


@pytest.mark.parametrize(
    "start",
    [
        ("--volume", "--auto", "grid"),
        ("--volume", "--stroke", "9,9,8,10,10,11"),
        (*SPHERE, "--points", "seeds.csv"),
    ],
)
def test_every_start_leads_to_the_surface(folder, told, start):
    (folder / "seeds.csv").write_text("col,row,plane\n9.5,9,9\n9,9.5,10\n")
    words = [folder / word if word == "seeds.csv" else word for word in start]
    facts = told("run", folder / "ball.npy", *words)
    assert facts["converged"]
    assert facts["vertices"] - facts["faces"] / 2 == 2


def test_the_objects_of_a_run_in_a_volume_are_its_bodies_by_a_batch_as_well(folder, told, command, tmp_path):
    facts = told("run", folder / "ball.npy", "--volume", "--auto", "grid", "--objects", "--export", tmp_path / "a.tif")
    assert facts["volume"] == pytest.approx(4.0 / 3.0 * np.pi * 6.0**3, rel=0.05)
    image = ImageFile(str(folder / "ball.npy"), shape=(20, 20, 20))
    save_session(SessionFile(image, (Everywhere("grid"),), PRESETS["volume"]), tmp_path / "a.cpm")
    batch = ("batch", folder / "ball.npy", "--session", tmp_path / "a.cpm", "--output", tmp_path / "o", "--workers", 1)
    assert command(*batch)[0] == 0
    assert {path.name for path in (tmp_path / "o").iterdir()} == {
        *("ball_objects.tif", "ball_objects.csv", "summary.csv", "objects.csv")
    }
    labels = tifffile.imread(tmp_path / "a.tif")
    np.testing.assert_array_equal(tifffile.imread(tmp_path / "o" / "ball_objects.tif"), labels)
    assert np.unique(labels).tolist() == [0, 1]
    with (tmp_path / "o" / "ball_objects.csv").open(newline="") as stream:
        (row,) = csv.DictReader(stream)
    assert (row["name"], row["class"]) == ("object 1", "object")
    assert float(row["volume_px3"]) == np.count_nonzero(labels)


def test_a_region_and_a_barrier_limit_the_surface(folder, told):
    half = folder / "half.obj"
    for limit in (("--region", "0,0,0,19,19,12"), ("--barrier", "0,0,12.5,0,0,1")):
        assert told("run", folder / "ball.npy", *SPHERE, *limit, "--export", half)["converged"]
        places = [line.split()[1:4] for line in half.read_text().splitlines() if line.startswith("v ")]
        sides = np.ptp(np.array(places, dtype=float), axis=0)
        assert sides.min() < 10.5 < sides.max()


def test_a_session_of_a_volume_runs_as_the_same_words_do(folder, told, command):
    shapes = (Sphere((9.5, 9.5, 9.5), 3.0), BoxRegion((0.0, 0.0, 0.0), (19.0, 19.0, 12.0)))
    image = ImageFile("ball.npy", shape=(20, 20, 20))
    save_session(SessionFile(image, shapes, PRESETS["volume"]), folder / "half.cpm")
    words = ("run", folder / "ball.npy", *SPHERE, "--region", "0,0,0,19,19,12")
    one, other = ({**told(*line), "seconds": 0.0} for line in (words, ("run", "--session", folder / "half.cpm")))
    assert one == other
    save_session(SessionFile(shapes=(Circle((9.0, 9.0), 3.0),)), folder / "flat.cpm")
    status, _, err = command("run", folder / "ball.npy", "--volume", "--session", folder / "flat.cpm")
    assert status == 2
    assert "shape 1 (circle) is for images, but ball.npy is taken as a volume" in err


def write_oblique(path, values):
    nibabel = pytest.importorskip("nibabel")
    turn = np.array([[0.8, 0.0, -0.6], [0.0, 1.0, 0.0], [0.6, 0.0, 0.8]])
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = 0.5 * turn, (-5.0, 7.0, 9.0)
    nibabel.save(nibabel.Nifti1Image(values.T, matrix), path)
    return nibabel.load(path).affine


def test_labels_are_written_with_the_matrix_of_the_volume(folder, command):
    nibabel = pytest.importorskip("nibabel")
    affine = write_oblique(folder / "oblique.nii.gz", np.load(folder / "ball.npy"))
    labels = folder / "labels.nii.gz"
    assert command("run", folder / "oblique.nii.gz", *SPHERE, "--export", labels)[0] == 0
    found = nibabel.load(labels)
    assert np.array_equal(found.affine, affine)
    inside = np.load(folder / "ball.npy") > 100.0
    assert (np.asarray(found.dataobj).T.astype(bool) == inside).mean() > 0.99


def test_info_tells_where_a_volume_lies(folder, command):
    write_oblique(folder / "info.nii", np.load(folder / "ball.npy"))
    _, out, _ = command("info", folder / "info.nii")
    *lines, note = out.splitlines()
    assert lines == [
        "info.nii: 20 planes x 20 rows x 20 columns, gray levels 0 to 200",
        "Size of a voxel: 0.5 x 0.5 x 0.5 mm (plane x row x column)",
        "Orientation: planes to the head, rows to the front, columns to the right, up to 36.9° oblique",
        "First voxel: at (-5, 7, 9) mm, RAS",
    ]
    assert note.startswith("Note: ") and "millimeters" in note
    facts = json.loads(command("info", folder / "info.nii", "--json", "--page", "3")[1])
    assert facts["shape"] == [20, 20]
    assert (facts["geometry"]["letters"], facts["geometry"]["convention"]) == ("SAR", "RAS")
    assert facts["geometry"]["affine"][0][3] == pytest.approx(-5.0 - 0.6)


@pytest.fixture(scope="module")
def hyperstack(folder):
    values = np.load(folder / "ball.npy").astype(np.uint8)
    stack = np.stack([[np.zeros_like(values), values], [values // 2, values]]).transpose(0, 2, 1, 3, 4)
    tifffile.imwrite(folder / "hyper.tif", stack, imagej=True, metadata={"axes": "TZCYX"})
    return folder / "hyper.tif"


def test_parts_of_a_file_are_chosen_by_number(hyperstack, told, command):
    assert told("run", hyperstack, *SPHERE, "--channel", "2", "--time", "1", "--max-steps", 9)["vertices"] > 100
    _, _, err = command("run", hyperstack, *SPHERE, "--time", "2", "--max-steps", 9)
    assert err.startswith("cpm: hyper.tif: ") and "2 channels" in err and err.count("\n") == 1
    part = ("--page", "10", "--channel", "2", "--time", "2", "--scales", 2)
    assert told("run", hyperstack, "--circle", "9.5,9.5,3", *part)["closed"] == 1


def test_a_volume_is_run_as_one_unless_something_in_a_plane_is_named(folder, command, tmp_path):
    found = []
    for more in ((), ("--volume",)):
        table = tmp_path / f"{len(found)}.csv"
        status, out, err = command("run", folder / "ball.npy", "--objects", *more, "--export", table, "--json")
        assert (status, json.loads(out)["left_out"] if "left_out" in out else {}) == (0, {}), err
        found.append(table.read_text().splitlines())
    assert found[0] == found[1]
    assert "volume" in found[0][0] and len(found[0]) == 2
    for name, options in (("ball.npy", ("--page", 11)), ("disk.npy", ())):
        np.save(folder / "disk.npy", np.load(folder / "ball.npy")[10])
        status, out, _ = command("run", folder / name, "--auto", "grid", *options, "--export", tmp_path / "a.svg")
        assert (status, "px" in out) == (0, True)
    status, _, err = command("run", folder / "ball.npy", "--auto", "grid", "--export", tmp_path / "b.svg")
    assert (status, "--page" in err) == (2, True)
