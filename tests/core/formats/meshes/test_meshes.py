"""Surfaces written to files, read back by hand from the documents of the formats; label volumes by their readers."""

import gzip
import struct
from dataclasses import replace

import nibabel
import numpy as np
import pytest
import tifffile

from cpm_core import Geometry, Image, Result, Surface
from cpm_core.contours.surface import label_voxels
from cpm_core.formats import VOLUMES_WRITABLE, export, to_bytes
from cpm_core.formats.meshes.triangles import triangulate_polygons
from cpm_core.numerics.grids import zero_surface

SHAPE, SPACING = (16, 20, 24), (2.0, 0.5, 1.0)
PLACES = np.stack(np.meshgrid(*[np.arange(float(n)) for n in SHAPE], indexing="ij"), -1)


def ball(center, radius):
    return radius - np.linalg.norm(PLACES - center, axis=-1)


VALUES = np.maximum(np.minimum(ball((8, 8, 8), 6.3), -ball((8, 8, 8), 2.4)), ball((8, 14, 18), 3.1))
SURFACE = Surface(*zero_surface(VALUES.astype(np.float32)), SPACING, "mm")


def result_with(surface, shape=SHAPE):
    spacing = SPACING[-len(shape) :]
    return Result(np.zeros((0, len(shape))), (), surface, 1, True, "at rest", shape, spacing, "mm", "a ball.nii")


RESULT = result_with(SURFACE)
POINTS = (SURFACE.vertices * SPACING)[:, ::-1]


def read_ply(content):
    head, body = content.split(b"end_header\n", 1)
    lines = head.decode("ascii").splitlines()
    assert lines[:2] == ["ply", "format binary_little_endian 1.0"]
    vertices, faces = (int(line.split()[2]) for line in lines if line.startswith("element"))
    numbers = np.frombuffer(body, "<f4", 6 * vertices).reshape(-1, 6)
    triangles = np.frombuffer(body[24 * vertices :], np.dtype([("n", "u1"), ("at", "<i4", 3)]))
    assert len(triangles) == faces and (triangles["n"] == 3).all()
    return numbers[:, :3], triangles["at"], numbers[:, 3:], head.decode()


def volume_of(points, faces):
    a, b, c = points[faces].astype(float).transpose(1, 0, 2)
    return float((a * np.cross(b, c)).sum() / 6.0)


def test_surfaces_are_read_back_as_they_were():
    points, faces, normals, notes = read_ply(to_bytes(RESULT, ".ply"))
    assert points == pytest.approx(POINTS, abs=1e-4)
    assert np.sort(faces, axis=1).tolist() == np.sort(SURFACE.faces, axis=1).tolist()
    assert normals == pytest.approx(SURFACE.normals[:, ::-1], abs=1e-4)
    assert volume_of(points, faces) == pytest.approx(SURFACE.volume, rel=1e-4)
    assert "SPACE=LPS" in notes and "UNIT=mm" in notes and "CPM" in notes


def test_normals_have_the_length_of_one_in_a_sheared_volume_too():
    place = Geometry(directions=((0.0, 0.6, 0.8), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)))
    sheared = replace(RESULT, image=Image(VALUES, spacing=SPACING, unit="mm", geometry=place))
    normals = read_ply(to_bytes(sheared, ".ply"))[2]
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1.0, abs=1e-4)


def test_triangles_for_printing_are_read_back():
    content = to_bytes(RESULT, ".stl")
    assert not content.startswith(b"solid") and b"SPACE=LPS UNIT=mm" in content[:80]
    assert struct.unpack("<I", content[80:84]) == (len(SURFACE.faces),)
    found = np.frombuffer(content[84:], np.dtype([("normal", "<f4", 3), ("at", "<f4", (3, 3)), ("more", "<u2")]))
    assert found["at"] == pytest.approx(POINTS[SURFACE.faces[:, ::-1]], abs=1e-4)
    assert np.linalg.norm(found["normal"], axis=1) == pytest.approx(1.0, abs=1e-3)
    outward = (found["normal"] * SURFACE.normals[SURFACE.faces[:, 0]][:, ::-1]).sum(1)
    assert (outward > 0.0).all()


def test_label_volumes_are_aligned_with_the_input(tmp_path):
    export(RESULT, tmp_path / "a.nii", tmp_path / "a.nii.gz", tmp_path / "a.tif")
    image = nibabel.Nifti1Image.from_bytes((tmp_path / "a.nii").read_bytes())
    wanted = label_voxels(SURFACE, SHAPE)
    assert np.asarray(image.dataobj).transpose().tolist() == wanted.tolist()
    assert image.header.get_zooms() == SPACING[::-1]
    corner = image.affine @ (23, 19, 15, 1)
    assert corner[:3] == pytest.approx((-23 * 1.0, -19 * 0.5, 15 * 2.0))  # RAS; meshes of the same result are LPS
    assert gzip.decompress((tmp_path / "a.nii.gz").read_bytes()) == (tmp_path / "a.nii").read_bytes()
    with tifffile.TiffFile(tmp_path / "a.tif") as file:
        assert file.asarray().tolist() == wanted.tolist()
        assert file.imagej_metadata["spacing"] == 2.0 and file.series[0].axes == "ZYX"


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".vtk", ".stl"])
def test_surfaces_are_written_in_either_convention_which_the_file_tells(suffix, tmp_path):
    place = Geometry((3.0, -7.0, 11.0), ((1.0, 0.0, 0.0), (0.0, 0.6, 0.8), (0.0, -0.8, 0.6)))
    placed = replace(RESULT, image=Image(VALUES, spacing=SPACING, unit="mm", geometry=place))
    lps, ras = (to_bytes(placed, suffix, space=space) for space in ("LPS", "RAS"))
    assert b"SPACE=LPS" in lps and b"SPACE=RAS" in ras
    if suffix == ".ply":
        (one, faces, normals, _), (other, turned, facing, _) = read_ply(lps), read_ply(ras)
        np.testing.assert_allclose(other, one * (-1.0, -1.0, 1.0), atol=1e-4)
        np.testing.assert_allclose(facing, normals * (-1.0, -1.0, 1.0), atol=1e-4)
        np.testing.assert_array_equal(turned, faces)
    export(placed, tmp_path / f"a{suffix}", space="RAS")
    assert (tmp_path / f"a{suffix}").read_bytes() == ras
    with pytest.raises(ValueError, match=r"XYZ"):
        to_bytes(placed, suffix, space="XYZ")


@pytest.mark.parametrize("suffix", [".svg", ".png", ".json", ".roi"])
def test_what_lies_in_a_plane_is_refused_for_volumes(suffix):
    assert suffix not in VOLUMES_WRITABLE
    with pytest.raises(ValueError, match="is a volume"):
        to_bytes(RESULT, suffix)


def test_an_open_surface_has_no_inside():
    opened = Surface(SURFACE.vertices, SURFACE.faces[1:], SPACING, "mm")
    with pytest.raises(ValueError, match="no closed surface"):
        to_bytes(result_with(opened), ".nii")


@pytest.mark.parametrize("counts", [[3, 2**40], [3, -1, 1], [4]])
def test_polygons_of_another_number_of_corners_are_refused_and_take_no_memory(counts):
    with pytest.raises(ValueError, match="another number of corners"):
        triangulate_polygons(counts, [0, 1, 2])
