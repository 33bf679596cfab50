"""Geometry: where voxels lie in space, and that what is written lies there as well."""

import io
from dataclasses import replace

import nibabel
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from cpm_core import Image, Result, Surface
from cpm_core.contours.contour import Contour
from cpm_core.formats import to_bytes
from cpm_core.image.geometry import freeze_matrix, geometry_from_affine
from cpm_core.medial_axis.skeleton import Skeleton
from cpm_core.numerics.grids import zero_surface

SHAPE = (12, 14, 16)
VALUES = (4.0 - np.linalg.norm(np.indices(SHAPE).T - (5, 6, 7), axis=-1).T).astype(np.float32)
TURNS = st.tuples(*[st.floats(-180.0, 180.0)] * 3)
SIDES = st.tuples(*[st.floats(0.1, 9.0)] * 3)


def affine_of(angles, sides, mirrored=False, origin=(-31.5, 17.25, 4.0)):
    """Matrix of a NIfTI file, from (col, row, plane) to RAS."""
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_euler("xyz", angles, degrees=True).as_matrix() * sides
    matrix[:3, 2] *= -1.0 if mirrored else 1.0
    matrix[:3, 3] = origin
    return matrix


def result_in(geometry, spacing, unit="mm"):
    surface = Surface(*zero_surface(VALUES), spacing, unit)
    image = Image(VALUES, spacing, unit, "a.nii", geometry=geometry)
    return Result(np.zeros((0, 3)), (), surface, 1, True, "at rest", SHAPE, spacing, unit, "a.nii", image=image)


@given(TURNS, SIDES, st.booleans())
def test_a_matrix_comes_back_as_it_was(angles, sides, mirrored):
    matrix = affine_of(angles, sides, mirrored)
    geometry, spacing = geometry_from_affine(matrix, "RAS")
    assert spacing == pytest.approx(sides[::-1])
    np.testing.assert_allclose(geometry.affine(spacing)[:, [2, 1, 0, 3]], matrix, atol=1e-12)
    np.testing.assert_allclose(geometry.affine(spacing, "LPS"), np.diag([-1, -1, 1, 1]) @ geometry.affine(spacing))
    assert np.linalg.norm(geometry.directions, axis=1) == pytest.approx(1.0)
    assert geometry.slant < 1e-5


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("unit", ["mm", "µm", "cm", None])
def test_a_label_volume_has_the_matrix_of_its_input(mirrored, unit):
    matrix = affine_of((20.0, -35.0, 110.0), (0.5, 0.75, 2.0), mirrored).astype(np.float32).astype(float)
    found = nibabel.Nifti1Image.from_bytes(to_bytes(result_in(*geometry_from_affine(matrix, "RAS"), unit), ".nii"))
    factor = 10.0 if unit == "cm" else 1.0
    wanted = np.vstack([factor * matrix[:3], matrix[3:]])
    assert np.array_equal(found.affine, wanted.astype(np.float32))
    for form in (found.get_qform(coded=True), found.get_sform(coded=True)):
        np.testing.assert_allclose(form[0], wanted, atol=1e-4)
        assert form[1] == 1
    assert found.header.get_zooms() == pytest.approx([0.5 * factor, 0.75 * factor, 2.0 * factor])
    assert np.array_equal(np.asarray(found.dataobj).T > 0, VALUES > 0)


def test_axes_that_are_not_at_right_angles_have_the_nearest_rotation_as_qform():
    matrix = affine_of((0, 0, 0), (1.0, 1.0, 2.0))
    matrix[0, 2] = 0.7
    geometry, spacing = geometry_from_affine(matrix, "RAS")
    assert geometry.slant == pytest.approx(np.degrees(np.arctan(0.35)))
    found = nibabel.Nifti1Image.from_bytes(to_bytes(result_in(geometry, spacing), ".nii"))
    np.testing.assert_allclose(found.affine, matrix, atol=1e-6)
    qform, code = found.get_qform(coded=True)
    assert code == 1
    left, _, right = np.linalg.svd(matrix[:3, :3] / np.linalg.norm(matrix[:3, :3], axis=0))
    np.testing.assert_allclose(qform[:3, :3] / np.linalg.norm(qform[:3, :3], axis=0), left @ right, atol=1e-6)
    header = nibabel.Nifti1Header.from_fileobj(io.BytesIO(to_bytes(result_in(geometry, spacing), ".nii")), check=False)
    assert header.diagnose_binaryblock(header.binaryblock) == ""


@given(TURNS, SIDES, TURNS, st.floats(0.1, 10.0), st.tuples(*[st.integers(-5, 20)] * 3))
def test_the_matrix_of_a_qform_follows_parts_and_units_as_that_of_the_sform_does(angles, sides, others, factor, first):
    sform, qform = affine_of(angles, sides), affine_of(others, sides, origin=(3.0, -12.0, 20.0))
    geometry, spacing = geometry_from_affine(sform, "RAS")
    assert np.array_equal(geometry.qform_affine(spacing), geometry.affine(spacing))
    geometry = replace(geometry, to_qform=freeze_matrix(qform @ np.linalg.inv(sform)))
    part = geometry.starting_at(first, spacing).scaled(factor)
    size = np.diag([factor, factor, factor, 1.0])
    sides = tuple(factor * side for side in spacing)
    for seen, matrix in ((part.affine, sform), (part.qform_affine, qform)):
        wanted = size @ matrix
        wanted[:3, 3] += wanted[:3, :3] @ first[::-1]
        np.testing.assert_allclose(seen(sides)[:, [2, 1, 0, 3]], wanted, atol=1e-8)
        np.testing.assert_allclose(seen(sides, "LPS"), np.diag([-1, -1, 1, 1]) @ seen(sides))


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_surface_lies_where_the_label_volume_lies_and_points_outward(mirrored):
    matrix = affine_of((20.0, -35.0, 110.0), (0.5, 0.75, 2.0), mirrored)
    result = result_in(*geometry_from_affine(matrix, "RAS"))
    rows = [line.split() for line in to_bytes(result, ".obj").decode().splitlines()]
    points, normals = (np.array([row[1:] for row in rows if row[0] == kind], float) for kind in ("v", "vn"))
    faces = np.array([[part.split("//")[0] for part in row[1:]] for row in rows if row[0] == "f"], int) - 1
    ras = points * (-1, -1, 1)
    at = (np.c_[ras, np.ones(len(ras))] @ np.linalg.inv(matrix).T)[:, 2::-1]
    assert at == pytest.approx(result.surface.vertices, abs=1e-3)
    a, b, c = points[faces].transpose(1, 0, 2)
    middle = points.mean(0)
    assert np.einsum("ij,ij", a - middle, np.cross(b - a, c - a)) / 6 == pytest.approx(result.surface.volume, rel=1e-3)
    assert (np.einsum("ij,ij->i", normals, points - middle) > 0).all()
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1.0, abs=1e-4)


def test_a_plane_of_a_volume_lies_where_it_was():
    geometry, spacing = geometry_from_affine(affine_of((20.0, -35.0, 110.0), (0.5, 0.75, 2.0)), "RAS")
    plane = replace(geometry.starting_at((7, 0, 0), spacing), depth=spacing[0])
    whole = geometry.affine(spacing) @ np.array([7.0, 3.0, 4.0, 1.0])
    np.testing.assert_allclose(plane.affine(spacing[1:]) @ np.array([0.0, 3.0, 4.0, 1.0]), whole)
    line = Contour(np.array([[2.0, 2.0], [2.0, 9.0]]), closed=False)
    skeleton = Skeleton((line,), (np.ones(2),), (14, 16), spacing[1:], "mm", "a.nii", geometry=plane)
    found = nibabel.Nifti1Image.from_bytes(to_bytes(skeleton, ".nii"))
    np.testing.assert_allclose(found.affine, plane.affine(spacing[1:])[:, [2, 1, 0, 3]], atol=1e-5)


@given(st.integers(0, 2**32 - 1))
def test_letters_are_those_of_nibabel(seed):
    orientations = pytest.importorskip("nibabel").orientations
    random = np.random.default_rng(seed)
    affine = np.eye(4)
    affine[:3, :3] = Rotation.random(random_state=seed).as_matrix() * random.uniform(0.3, 4.0, 3)
    affine[:3, :3] += 0.1 * random.standard_normal((3, 3))
    geometry, _ = geometry_from_affine(affine, "RAS")
    left, _, right = np.linalg.svd(affine[:3, :3] / np.linalg.norm(affine[:3, :3], axis=0))
    order = np.argsort(-np.max((left @ right) ** 2, axis=0))  # older releases take the axes as they come
    codes = orientations.aff2axcodes(affine[:, [*order, 3]])
    assert [geometry.letters[2 - axis] for axis in order] == list(codes)
    assert {letter for ends in geometry.ends for letter in ends} == set("RLAPSI")
