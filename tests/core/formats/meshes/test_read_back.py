"""Surfaces, center lines and particles that are written come back to a hundredth of a voxel, wherever volumes lie."""

import logging
from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import (
    Geometry,
    Image,
    Surface,
    centerlines,
    export,
    load_centerlines,
    load_points,
    load_surface,
    load_volume_truth,
    to_bytes,
)
from cpm_core.contours.surface_agreement import compare_surface
from cpm_core.formats.surface_file import SURFACES_READABLE, decode_surface

from .test_meshes import RESULT, SHAPE, SPACING, SURFACE, VALUES

NEAR = 0.01
PRECISE = (".ply", ".obj", ".vtk")


def turned(angle, axis):
    """Directions of the axes of a volume that is turned."""
    one, other = (k for k in range(3) if k != axis)
    matrix = np.eye(3)[::-1].copy()
    matrix[:, [one, other]] = matrix[:, [one, other]] @ [
        [np.cos(angle), -np.sin(angle)],
        [np.sin(angle), np.cos(angle)],
    ]
    return tuple(map(tuple, matrix))


def placed(geometry, spacing=SPACING, unit="mm", surface=SURFACE):
    image = Image(VALUES, spacing, unit, geometry=geometry)
    return replace(
        RESULT, image=image, spacing=spacing, unit=unit, surface=replace(surface, spacing=spacing, unit=unit)
    )


def corners_of(surface):
    """The three corners of each triangle in order, the triangles in any."""
    rows = surface.vertices[surface.faces].round(2)
    first = np.lexsort(rows.transpose(2, 0, 1)[::-1].reshape(3, -1)).argsort().reshape(-1, 3).argmin(axis=1)
    return np.stack([np.roll(row, -k, axis=0) for row, k in zip(rows, first, strict=True)])


directions = st.builds(turned, st.floats(0.0, 6.2), st.integers(0, 2))
mirrored = directions.map(lambda axes: (axes[0], axes[1], tuple(-number for number in axes[2])))
geometries = st.builds(
    Geometry,
    st.tuples(*[st.floats(-3e5, 3e5)] * 3),
    directions | mirrored,
    st.sampled_from(["LPS", "RAS"]),
)


@settings(max_examples=6, deadline=None)
@given(geometry=st.none() | geometries, space=st.sampled_from(["LPS", "RAS"]))
@pytest.mark.parametrize("suffix", PRECISE)
def test_a_surface_comes_back_wherever_the_volume_lies(suffix, geometry, space):
    result = placed(geometry)
    found, notes = decode_surface(to_bytes(result, suffix, space=space), f"a{suffix}", result.image)
    assert not notes
    assert np.abs(found.vertices - SURFACE.vertices).max() < NEAR
    np.testing.assert_array_equal(found.faces, SURFACE.faces)
    assert (found.spacing, found.unit) == (SPACING, "mm")


def test_triangles_for_printing_come_back_in_single_precision():
    result = placed(Geometry((-110.0, 35.0, 840.0), turned(0.7, 1)))
    found, _ = decode_surface(to_bytes(result, ".stl"), "a.stl", result.image)
    assert len(found.vertices) == len(SURFACE.vertices)
    distances = np.linalg.norm(found.vertices[:, None] - SURFACE.vertices, axis=2)
    assert distances.min(axis=1).max() < NEAR
    nearest = distances.argmin(axis=1)
    np.testing.assert_array_equal(np.sort(nearest[found.faces], axis=1), np.sort(SURFACE.faces, axis=1))
    assert found.volume == pytest.approx(SURFACE.volume, rel=1e-3)


@pytest.mark.parametrize("suffix", SURFACES_READABLE)
def test_a_file_in_another_unit_is_converted(suffix):
    result = placed(None, (4e-3, 2e-3, 2e-3))
    micrometers = Image(VALUES, (4.0, 2.0, 2.0), "µm")
    found, _ = decode_surface(to_bytes(result, suffix), f"a{suffix}", micrometers)
    assert np.abs(np.sort(found.vertices, axis=0) - np.sort(SURFACE.vertices, axis=0)).max() < NEAR
    assert found.unit == "µm"


@pytest.mark.parametrize("suffix", PRECISE)
def test_the_numbers_of_objects_come_back(suffix):
    numbers = np.where(SURFACE.component_of_vertex[SURFACE.faces[:, 0]] == 0, 7, 3)
    result = placed(None, surface=replace(SURFACE, numbers=numbers))
    found, _ = decode_surface(to_bytes(result, suffix), f"a{suffix}", result.image)
    order = np.argsort(numbers, kind="stable") if suffix == ".obj" else slice(None)
    np.testing.assert_array_equal(found.numbers, numbers[order])
    np.testing.assert_array_equal(found.faces, SURFACE.faces[order])


def test_without_a_volume_a_voxel_is_a_unit_of_the_file():
    found, _ = decode_surface(to_bytes(RESULT, ".ply"), "a.ply")
    assert np.abs(found.vertices - SURFACE.vertices * SPACING).max() < NEAR
    assert (found.spacing, found.unit) == ((1.0, 1.0, 1.0), "mm")
    assert found.volume == pytest.approx(SURFACE.volume, rel=1e-3)


def test_a_file_that_tells_no_coordinates_is_taken_as_lps_and_says_so():
    result = placed(Geometry((5.0, 6.0, 7.0)))
    content = to_bytes(result, ".obj", space="RAS").replace(b"SPACE=RAS", b"").replace(b"UNIT=mm", b"")
    with pytest.raises(ValueError, match=r"a\.obj lies outside the volume .* LPS or RAS"):
        decode_surface(content, "a.obj", result.image)
    found, notes = decode_surface(content, "a.obj", result.image, "RAS")
    assert np.abs(found.vertices - SURFACE.vertices).max() < NEAR
    assert notes == ("It does not state its unit of length: mm, that of the volume, is taken.",)
    _, notes = decode_surface(content, "a.obj")
    assert notes == ("It does not state where x, y and z point: LPS is taken; the other choice is RAS.",)


@pytest.mark.parametrize("suffix", [".nii", ".tif"])
def test_the_surface_of_a_label_volume_has_the_same_labels(suffix, tmp_path):
    result = placed(None)
    export(result, tmp_path / f"labels{suffix}")
    found = load_surface(tmp_path / f"labels{suffix}", result.image)
    assert found.closed and found.spacing == SPACING
    np.testing.assert_array_equal(replace(result, surface=found).labels, result.labels)


def test_a_surface_is_the_truth_of_its_volume(tmp_path):
    result = placed(Geometry((5.0, 6.0, 7.0)))
    export(result, tmp_path / "truth.ply")
    truth = load_volume_truth(tmp_path / "truth.ply", result.image)
    np.testing.assert_array_equal(truth.labels > 0, VALUES > 0.0)
    assert np.abs(truth.surface.vertices - SURFACE.vertices).max() < NEAR
    assert compare_surface(SURFACE, truth).hausdorff < NEAR
    opened = replace(result, surface=replace(SURFACE, faces=SURFACE.faces[1:]))
    export(opened, tmp_path / "open.ply")
    with pytest.raises(ValueError, match=r"surface of open\.ply is not closed"):
        load_volume_truth(tmp_path / "open.ply", result.image)


def test_particles_come_back(tmp_path):
    particles = np.random.default_rng(0).uniform(0, 4000, (50, 3))
    export(replace(RESULT, particles=particles), tmp_path / "a.points.csv")
    assert np.abs(load_points(tmp_path / "a.points.csv", 3) - particles).max() < NEAR


def ring_with_a_tail():
    """A ring, a rod that leaves it, and a ball far from both."""
    inside = np.zeros((12, 60, 60), bool)
    rows, cols = np.mgrid[:60, :60]
    from_center = np.hypot(rows - 24, cols - 24)
    inside[4:9] = (from_center > 13) & (from_center < 19)
    inside[4:9, 22:27, 40:58] = True
    inside[5:8, 50:53, 5:40] = True
    return inside


@pytest.mark.parametrize("space", ["LPS", "RAS"])
@pytest.mark.parametrize("geometry", [None, Geometry((-2e5, 3e5, 17.0), turned(2.0, 0), "RAS")])
def test_center_lines_come_back_with_their_loops(geometry, space, tmp_path):
    inside, spacing = ring_with_a_tail(), (1.0, 0.5, 0.5)
    lines = replace(centerlines(inside, spacing, "mm"), geometry=geometry)
    assert len(lines.branches) >= 3
    export(lines, tmp_path / "a.swc", space=space)
    image = Image(inside.astype(float), spacing, "mm", geometry=geometry)
    found = load_centerlines(tmp_path / "a.swc", image)
    assert len(found.branches) == len(lines.branches)
    assert sorted(one.closed for one in found.contours) == sorted(one.closed for one in lines.contours)
    for one, other in zip(found.branches, lines.branches, strict=True):
        forward = np.abs(one.points - other.points).max() < 1.0
        points, radii = (one.points, one.radii) if forward else (one.points[::-1], one.radii[::-1])
        assert np.abs(points - other.points).max() < NEAR
        assert np.abs(radii - other.radii).max() < NEAR * min(spacing)
    assert {c.junctions for c in found.contours} == {c.junctions for c in lines.contours}


def test_what_was_assumed_of_a_tree_is_told(tmp_path, caplog):
    (tmp_path / "cell.swc").write_text("# made by hand\n1 1 0 0 0 2 -1\n2 3 5 0 0 1 1\n3 3 5 4 0 1 2\n4 3 9 0 0 1 2\n")
    with caplog.at_level(logging.WARNING):
        found = load_centerlines(tmp_path / "cell.swc")
    assert "cell.swc: It does not state where x, y and z point" in caplog.text
    assert sorted(found.lengths.tolist()) == [4.0, 4.0, 5.0]
    assert found.branches[0].points.tolist() == [[0, 0, 0], [0, 0, 5]]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("1 0 0 0 0 1 -1\n2 0 x 0 0 1 1\n", r"line that is not seven numbers .*could not convert string 'x'"),
        ("1 0 0 0 0 1 -1\n2 0 1 0 0 1 9\n", r"point without its parent"),
        ("1 0 0 0 0 1 -1\n1 0 1 0 0 1 1\n", r"two points of the same number"),
        ("1 0 0 0 0 1 -1\n", r"contains single points and no lines"),
        ("# nothing\n", r"contains no center lines"),
    ],
)
def test_a_damaged_tree_is_refused_in_a_sentence(text, sentence, tmp_path):
    (tmp_path / "a.swc").write_text(text)
    with pytest.raises(ValueError, match=rf"^a\.swc .*{sentence}"):
        load_centerlines(tmp_path / "a.swc")


def test_an_image_has_no_surface():
    with pytest.raises(ValueError, match=r"is no volume, but surfaces and center lines lie in volumes"):
        decode_surface(to_bytes(RESULT, ".ply"), "a.ply", Image(np.zeros((8, 8))))


@pytest.mark.parametrize("suffix", SURFACES_READABLE)
@pytest.mark.parametrize("cut", [0.02, 0.97])
def test_a_file_that_is_cut_off_is_refused_in_a_sentence_or_read_in_part(suffix, cut, tmp_path):
    content = to_bytes(RESULT, suffix)
    content = content[: int(cut * len(content))]
    readable = suffix in (".obj", ".vtk") and cut > 0.5  # without its last triangles, or its normals alone
    with nullcontext() if readable else pytest.raises(ValueError, match=rf"^a\{suffix}\b"):
        assert isinstance(decode_surface(content, f"a{suffix}")[0], Surface)


def test_a_volume_of_another_size_or_without_labels_is_refused(tmp_path):
    np.save(tmp_path / "gray.npy", VALUES)
    with pytest.raises(ValueError, match=r"gray\.npy has .* so it is an image, not a mask"):
        load_surface(tmp_path / "gray.npy")
    np.save(tmp_path / "small.npy", np.ones((8, 9, 10), np.uint8))
    with pytest.raises(ValueError, match=r"small\.npy has 8 x 9 x 10 voxels, but this volume has 16 x 20 x 24"):
        load_surface(tmp_path / "small.npy", Image(np.zeros(SHAPE)))
    np.save(tmp_path / "none.npy", np.zeros((8, 9, 10), np.uint8))
    with pytest.raises(ValueError, match=r"one gray level everywhere"):
        load_surface(tmp_path / "none.npy")
    with pytest.raises(ValueError, match=r"a\.txt"):
        load_surface(tmp_path / "a.txt")
