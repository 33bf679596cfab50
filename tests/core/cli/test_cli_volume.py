"""``cpm run VOLUME --sphere``: what it prints, and what it refuses."""

import json

import numpy as np
import pytest
import tifffile

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
    tifffile.imwrite(folder / "ball.tif", values, photometric="minisblack")
    (folder / "bad.tif").write_bytes(b"II*\0 no image")
    return folder


@pytest.mark.parametrize("name", ["ball.npy", "ball.npz", "ball.tif"])
def test_every_kind_of_file_gives_the_same_surface(folder, command, name):
    _, out, _ = command("run", folder / name, *SPHERE, "--json")
    facts = json.loads(out)
    assert facts["converged"]
    assert facts["vertices"] - facts["faces"] / 2 == 2
    assert (facts["contours"], facts["stop_reason"]) == (0, "at rest: no particle finds anything new")


def test_a_surface_is_written_with_as_many_triangles_as_wanted(folder, command, tmp_path):
    _, out, err = command(
        "run", folder / "ball.npy", *SPHERE, "--faces", "200", "--json", "--export", tmp_path / "a.ply"
    )
    facts = json.loads(out)
    assert (facts["faces"], facts["vertices"], err) == (200, 102, "")
    assert b"element face 200\n" in (tmp_path / "a.ply").read_bytes()
    _, out, err = command("run", folder / "ball.npy", *SPHERE, "--faces", "4", "--json")
    left = json.loads(out)["faces"]
    assert left > 4
    assert err == f"cpm: {left} triangles are left, not 4: with fewer the surface would lose its shape.\n"


def test_a_nifti_volume_is_read_with_the_sides_of_its_voxels(folder, command):
    nibabel = pytest.importorskip("nibabel")
    volume = nibabel.Nifti1Image(np.load(folder / "ball.npy"), np.diag([0.5, 0.5, 0.5, 1.0]))
    nibabel.save(volume, folder / "ball.nii.gz")
    _, out, _ = command("run", folder / "ball.nii.gz", *SPHERE)
    assert out.startswith("ball.nii.gz: a surface of ")


@pytest.mark.parametrize(
    ("words", "answer"),
    [
        (("ball.npy", "--sphere", "1,2,3"), "must be four numbers, PLANE,ROW,COL,RADIUS"),
        (("ball.npy", "--sphere", "1,2,3,0"), "radius is 0"),
        (("ball.npy", *SPHERE, "--faces", "3"), "--faces is 3 but must be a whole number of at least 4"),
        (("ball.npy", "--circle", "1,2,3", "--faces", "100"), "--faces is for the surface in a volume"),
        (("ball.npy", "--sphere", "90,90,90,2"), "none of the 625 starting particles lies inside"),
        (("ball.npy", *SPHERE, "--circle", "1,2,3"), "--circle is for images"),
        (("ball.npy", *SPHERE, "--export", "a.svg"), "a.svg is for contours"),
        (("ball.npy", *SPHERE, "--max-gap", "5"), "max_gap is 5 but has no meaning in a volume"),
        (("plane.npy", *SPHERE), "has the shape (20, 20)"),
        (("two.npz", *SPHERE), "holds 2 volumes"),
        (("bad.tif", *SPHERE), "is damaged"),
        (("none.npy", *SPHERE), "does not exist"),
        (("ball.png", *SPHERE), "is of no kind of volume"),
    ],
)
def test_what_cannot_be_done_is_said_in_one_line(folder, command, words, answer):
    name, *rest = words
    status, out, err = command("run", folder / name, *rest)
    assert (status, out) == (2, "")
    assert answer in err
    assert err.count("\n") == 1
