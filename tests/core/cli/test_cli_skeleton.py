"""The command that finds skeletons: what it prints, what it writes, and what it refuses."""

import numpy as np
import PIL.Image
import pytest
import tifffile

from cpm_core.formats import load_image

from .. import scenes


@pytest.fixture
def image(tmp_path):
    """Path of an image of a bar of 60 by 20 px."""
    values = scenes.polygon((60, 100), np.array([(20.3, 20.3), (20.3, 80.3), (40.3, 80.3), (40.3, 20.3)])).values
    PIL.Image.fromarray(values.astype(np.uint8)).save(tmp_path / "bar.png")
    return tmp_path / "bar.png"


def test_the_skeleton_is_told_as_json(image, told):
    facts = told("skeleton", image)
    assert (facts["of"], facts["max_width"]) == ("light", 0.0)
    assert facts["thickness"] == pytest.approx(20.0, abs=0.2)
    assert (facts["contours"], facts["closed"]) == (5, 0)
    assert facts["largest_radius"] == pytest.approx(10.0, abs=0.1)


def test_a_person_is_told_what_was_found_and_written(image, command, tmp_path):
    status, out, _ = command("skeleton", image, "--export", tmp_path / "a.svg")
    assert status == 0
    assert out.startswith("bar.png: skeleton of what is light: 5 lines (0 closed), thickness up to ")
    assert f"Wrote {tmp_path / 'a.svg'}\n" in out


def test_pruning_can_be_chosen(image, told):
    few, many, none = (
        told("skeleton", image, *options)["length"]
        for options in (("--pruning", 6), ("--pruning", 0.5), ("--min-length", 500))
    )
    assert few < many - 10.0
    assert few == pytest.approx(40.0, abs=6.0)  # from fork to fork
    assert none == 0.0


def test_a_mask_says_which_objects(image, told, tmp_path):
    values = load_image(image).values > 127.0
    values[:, 50:] = False
    PIL.Image.fromarray(values.astype(np.uint8) * 255).save(tmp_path / "mask.png")
    facts = told("skeleton", image, "--within", tmp_path / "mask.png", "--pruning", 6)
    assert facts["length"] == pytest.approx(10.0, abs=6.0)  # of half the bar, 30 by 20 px, from fork to fork
    assert facts["largest_radius"] == pytest.approx(10.0, abs=0.6)


@pytest.fixture
def volume(image):
    """Path of a torus in a volume, in the folder of the image."""
    plane, row, col = (axis - 15.5 for axis in np.ogrid[:32, :32, :32])
    inside = np.hypot(np.hypot(row, col) - 9.0, plane) < 3.0
    tifffile.imwrite(image.parent / "ring.tif", 200 * inside.astype(np.uint8))
    return image.parent / "ring.tif"


def test_the_center_lines_of_a_volume_are_told_and_written(volume, command, told, tmp_path):
    status, out, err = command("skeleton", volume, "--export", tmp_path / "a.swc")
    assert (status, err) == (0, "")
    assert out.startswith("ring.tif: 1 center line (1 closed) in ")
    assert f"Wrote {tmp_path / 'a.swc'}\n" in out
    assert np.loadtxt(tmp_path / "a.swc").shape[1] == 7
    facts = told("skeleton", volume, "--volume")
    assert facts["provenance"]["method"] == "skeleton"
    assert set(facts["provenance"]["parameters"]) == {"smoothing", "gamma", "edge_floor", "polarity", "pruning"}
    assert len(facts["provenance"]["image"]["sha256"]) == 64
    assert '"method":"skeleton"' in (tmp_path / "a.swc").read_text()
    command("skeleton", volume, "--volume", "--space", "RAS", "--export", tmp_path / "b.swc")
    assert "# SPACE=RAS\n" in (tmp_path / "b.swc").read_text()
    left, right = np.loadtxt(tmp_path / "a.swc"), np.loadtxt(tmp_path / "b.swc")
    np.testing.assert_allclose(right[:, 2:5], left[:, 2:5] * (-1.0, -1.0, 1.0), atol=1e-6)
    assert (facts["contours"], facts["closed"]) == (1, 1)
    assert facts["length"] == pytest.approx(2.0 * np.pi * 9.0, rel=0.08)
    assert facts["largest_radius"] == pytest.approx(3.0, abs=0.6)
