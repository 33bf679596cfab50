"""``cpm run VOLUME --sphere``: what it prints, and what it refuses."""

import json

import numpy as np
import PIL.Image
import pytest
import tifffile

from cpm_core.formats.sessions.session_file import ImageFile, SessionFile, save_session
from cpm_core.parameters import PRESETS
from cpm_core.shapes import BoxRegion, Circle, Sphere

SPHERE = ("--sphere", "9.5,9.5,9.5,3")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("volumes")
    grid = np.indices((20, 20, 20)) - 9.5
    values = (200.0 * np.clip(6.5 - np.sqrt((grid**2).sum(axis=0)), 0.0, 1.0)).astype(np.float32)
    np.save(folder / "ball.npy", values)
    np.savez(folder / "ball.npz", volume=values, origin=np.zeros(3))
    np.savez(folder / "two.npz", one=values, other=values)
    np.save(folder / "plane.npy", values[10])
    np.save(folder / "flat.npy", np.full((20, 20, 20), 7.0))
    np.save(folder / "nan.npy", np.where(np.arange(8000).reshape(20, 20, 20) == 5, np.nan, values))
    np.save(folder / "thin.npy", values[10:11])
    tifffile.imwrite(folder / "ball.tif", values, photometric="minisblack")
    PIL.Image.fromarray(values[10].astype(np.uint8)).save(folder / "flat.png")
    (folder / "bad.tif").write_bytes(b"II*\0 no image")
    return folder


def test_a_surface_is_written_with_as_many_triangles_as_wanted(folder, command, tmp_path):
    _, out, err = command(
        "run", folder / "ball.npy", *SPHERE, "--faces", "200", "--json", "--export", tmp_path / "a.ply"
    )
    facts = json.loads(out)
    assert (facts["faces"], facts["vertices"], err) == (200, 102, "")
    assert b"element face 200\n" in (tmp_path / "a.ply").read_bytes()
    values = np.load(folder / "ball.npy")
    np.save(tmp_path / "two.npy", np.concatenate([values, values]))  # two surfaces have no fewer than 8 triangles
    other = ("--sphere", "29.5,9.5,9.5,3")
    _, out, err = command("run", tmp_path / "two.npy", *SPHERE, *other, "--faces", "4", "--json")
    left = json.loads(out)["faces"]
    assert left >= 8
    assert err == f"cpm: {left} triangles are left, not 4: with fewer the surface would lose its shape.\n"


def test_an_object_that_a_place_lies_in_is_written_alone(folder, command, tmp_path):
    place = ("--object", "9.5,9.5,9.5", "--json", "--export", tmp_path / "a.ply", tmp_path / "a.nii")
    status, out, _ = command("run", folder / "ball.npy", *SPHERE, "--space", "RAS", *place)
    facts = json.loads(out)
    assert status == 0
    assert facts["volume"] == pytest.approx(4.0 / 3.0 * np.pi * 6.0**3, rel=0.05)
    assert facts["area"] == pytest.approx(4.0 * np.pi * 6.0**2, rel=0.05)
    assert b"SPACE=RAS" in (tmp_path / "a.ply").read_bytes()
    status, _, err = command("run", folder / "ball.npy", *SPHERE, "--object", "1,1,1")
    assert status == 2 and "no object" in err


def test_a_surface_is_compared_with_a_label_volume(folder, command):
    values = np.load(folder / "ball.npy")
    np.save(folder / "labels.npy", (values > 100.0).astype(np.uint8))
    _, out, _ = command("run", folder / "ball.npy", *SPHERE, "--truth", folder / "labels.npy", "--json")
    facts = json.loads(out)["truth"]
    assert facts["source"] == "labels.npy"
    assert facts["dice"] > 0.97
    assert facts["mean_distance"] < 0.4
    assert facts["hausdorff95"] <= facts["hausdorff"] < 1.5
    _, out, _ = command("run", folder / "ball.npy", *SPHERE, "--truth", folder / "labels.npy")
    assert "Beside labels.npy: Dice " in out
    assert "voxels apart on average, " in out
    status, _, err = command("run", folder / "ball.npy", *SPHERE, "--truth", folder / "plane.npy")
    assert (status, err.startswith("cpm: plane.npy ")) == (2, True)


@pytest.mark.parametrize(
    "start",
    [
        ("--volume", "--auto", "grid"),
        ("--volume", "--auto", "gradient"),
        ("--volume", "--stroke", "9,9,8,10,10,11"),
        ("--volume", "--points", "seeds.csv"),
        (*SPHERE, "--points", "seeds.csv", "--volume"),
    ],
)
def test_every_start_leads_to_the_surface(folder, command, start):
    (folder / "seeds.csv").write_text("col,row,plane\n9.5,9,9\n9,9.5,10\n")
    words = [folder / word if word == "seeds.csv" else word for word in start]
    _, out, _ = command("run", folder / "ball.npy", *words, "--json")
    facts = json.loads(out)
    assert facts["converged"]
    assert facts["vertices"] - facts["faces"] / 2 == 2


def test_a_region_and_a_barrier_limit_the_surface(folder, command):
    limits = {"--region": "0,0,0,19,19,12", "--barrier": "0,0,12.5,0,0,1"}
    for flag, text in limits.items():
        half = folder / "half.obj"
        _, out, _ = command("run", folder / "ball.npy", *SPHERE, flag, text, "--json", "--export", half)
        assert json.loads(out)["converged"]
        places = [line.split()[1:4] for line in half.read_text().splitlines() if line.startswith("v ")]
        places = np.array(places, dtype=float)
        assert np.ptp(places, axis=0).min() < 10.5 < np.ptp(places, axis=0).max()


def test_a_session_of_a_volume_runs_as_the_same_words_do(folder, command):
    shapes = (Sphere((9.5, 9.5, 9.5), 3.0), BoxRegion((0.0, 0.0, 0.0), (19.0, 19.0, 12.0)))
    image = ImageFile("ball.npy", shape=(20, 20, 20))
    save_session(SessionFile(image, shapes, PRESETS["volume"]), folder / "half.cpm")
    words = ("run", folder / "ball.npy", *SPHERE, "--region", "0,0,0,19,19,12", "--json")
    named = ("run", folder / "ball.npy", "--session", folder / "half.cpm", "--json")
    facts = []
    for line in (words, ("run", "--session", folder / "half.cpm", "--json"), named):
        status, out, err = command(*line)
        assert (status, err) == (0, "")
        facts.append({**json.loads(out), "seconds": 0.0})
    assert facts[0] == facts[1] == facts[2]
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
    assert out.splitlines() == [
        "info.nii: 20 planes x 20 rows x 20 columns, gray levels 0 to 200",
        "Size of a voxel: 0.5 x 0.5 x 0.5 mm (plane x row x column)",
        "Orientation: planes to the head, rows to the front, columns to the right, up to 36.9° oblique",
        "First voxel: at (-5, 7, 9) mm, RAS",
        "Note: It names no unit of length; millimeters were taken.",
    ]
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


def test_parts_of_a_file_are_chosen_by_number(hyperstack, command):
    _, out, err = command("run", hyperstack, *SPHERE, "--channel", "2", "--time", "1", "--json")
    assert json.loads(out)["vertices"] > 100
    assert err == ""
    _, out, err = command("run", hyperstack, *SPHERE, "--time", "2", "--json")
    assert json.loads(out)["vertices"] > 100
    assert err == "cpm: hyper.tif: Only the first of its 2 channels was taken.\n"
    places = ("--circle", "9.5,9.5,3")
    _, out, _ = command("run", hyperstack, *places, "--page", "10", "--channel", "2", "--time", "2", "--json")
    assert json.loads(out)["closed"] == 1
