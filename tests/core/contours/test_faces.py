"""What contours enclose, alone or several that meet: areas known exactly, drawn and given."""

import itertools

import numpy as np
import pytest
import scipy
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

import cpm_core as cpm
from cpm_core.contours.faces import find_faces
from tests.core.scenes import circle_points


def square(row, col, side):
    return cpm.Contour(np.array([(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)]) * side + (row, col), True)


def line(*corners):
    return cpm.Contour(np.array(corners, float), False)


def areas(contours):
    return [pytest.approx(face.area, abs=1e-3) for face in find_faces(contours)]


def bounded_cells(voronoi):
    """Cells of a Voronoi diagram that do not reach to infinity, as polygons."""
    cells = [one for one in voronoi.regions if one and min(one) >= 0]
    return [shapely.MultiPoint(voronoi.vertices[one]).convex_hull for one in cells]


def faces_drawn(size, gray, parameters=None):
    """Faces that a run finds in a square image of gray levels, each pixel the mean over a grid of places in it."""
    fine = (np.arange(8 * size) + 0.5) / 8.0 - 0.5
    values = gray(*np.meshgrid(fine, fine, indexing="ij")).reshape(size, 8, size, 8).mean(axis=(1, 3))
    return cpm.segment(cpm.Image(values), cpm.uniform_grid(values.shape), parameters).faces


@pytest.mark.parametrize(
    "angles", [(0.0, 120.0, 240.0), (0.0, 90.0, 180.0), (20.0, 90.0, 200.0)], ids=["Y", "T", "any"]
)
def test_the_sectors_of_a_disk_are_faces(angles):
    def gray(row, col):
        angle = np.degrees(np.arctan2(row - 47.3, col - 48.2)) % 360.0
        sector = np.array([220.0, 80.0, 150.0, 220.0])[np.searchsorted(angles, angle, side="right")]
        return np.where(np.hypot(row - 47.3, col - 48.2) < 40.0, sector, 20.0)

    truth = sorted((np.diff([*angles, angles[0] + 360.0]) / 360.0 * np.pi * 1600.0).tolist(), reverse=True)
    assert [face.area for face in faces_drawn(96, gray)] == pytest.approx(truth, rel=0.015)


@pytest.mark.parametrize("smoothing", [1.0, 2.5])
@pytest.mark.parametrize("levels", [(60, 180, 120, 240), (80, 150, 115, 220), (80, 220, 220, 80)], ids=str)
def test_four_quarters_that_meet_in_an_x_are_faces(levels, smoothing):
    def gray(row, col):
        inside = (abs(row - 47.5) < 30.0) & (abs(col - 48.1) < 30.0)
        return np.where(inside, np.array(levels)[2 * (row > 47.5) + (col > 48.1)], 0.0)

    faces = faces_drawn(96, gray, cpm.Parameters(smoothing=smoothing))
    assert [face.area for face in faces] == pytest.approx([900.0] * 4, rel=0.015 * smoothing)


@pytest.mark.parametrize("seed", [0, 1])
def test_the_inner_grains_of_a_honeycomb_are_faces(seed):
    """All but one or two: on a short edge between two junctions there may be no particle at the end of a run."""
    row, col = np.mgrid[:9, :9].reshape(2, -1)
    moved = np.random.default_rng(seed).uniform(-2.5, 2.5, (2, 81))
    centers = np.stack([20.0 * row - 5.0, 23.0 * (col + 0.5 * (row % 2)) - 12.0], axis=1) + moved.T
    levels = np.array([40.0, 120.0, 220.0])[(col - row // 2 - row) % 3]  # no two neighbors are alike
    tree = scipy.spatial.cKDTree(centers)

    def gray(rows, cols):
        return levels[tree.query(np.stack([rows, cols], axis=-1))[1]]

    grains = bounded_cells(scipy.spatial.Voronoi(centers))
    inner = [grain for grain in grains if shapely.box(2.0, 2.0, 157.0, 157.0).covers(grain)]
    faces = [shapely.Polygon(face.outer, face.holes) for face in faces_drawn(160, gray)]
    assert len(inner) >= 20
    found = [max(faces, key=lambda face, grain=grain: face.intersection(grain).area) for grain in inner]
    missing = [grain for grain, face in zip(inner, found, strict=True) if abs(face.area / grain.area - 1.0) > 0.02]
    assert len(missing) <= 0.1 * len(inner)


def test_a_closed_contour_is_a_face():
    (face,) = find_faces([square(2.0, 3.0, 10.0)], (0.5, 2.0))
    assert sorted(face.outer.tolist()) == sorted(square(2.0, 3.0, 10.0).points.tolist())
    assert (face.holes, face.area, face.area_in_units) == ((), 100.0, 100.0)
    assert repr(face) == "<Face 100.0 px²>"


def test_separate_contours_are_faces_and_none_have_none():
    assert areas([square(0.0, 0.0, 10.0), square(20.0, 0.0, 12.0)]) == [144.0, 100.0]
    assert find_faces([]) == ()
    assert find_faces([line((0.0, 0.0), (5.0, 5.0)), line((3.0, 3.0))]) == ()


def test_what_lies_between_rings_is_a_face_with_a_hole():
    rings = [cpm.Contour(circle_points((50.0, 50.0), radius, 90), True) for radius in (10.0, 20.0, 30.0)]
    outer, middle, inner = find_faces(rings)
    truth = [ring.area for ring in rings]
    assert [outer.area, middle.area, inner.area] == pytest.approx([*np.diff(truth)[::-1], truth[0]], rel=1e-6)
    assert [len(hole) for face in (outer, middle, inner) for hole in face.holes] == [90, 90]


def test_grains_that_touch_are_one_hole_of_the_face_around_them():
    contours = [square(0.0, 0.0, 40.0), square(10.0, 10.0, 10.0), line((10.0, 14.0), (20.0, 14.0))]
    around, *grains = find_faces(contours)
    assert (around.area, len(around.holes)) == (1500.0, 1)
    assert [face.area for face in grains] == [60.0, 40.0]


@pytest.mark.parametrize(("short", "count"), [(0.0, 2), (0.05, 2), (0.5, 1)])
def test_a_contour_divides_a_face_if_both_ends_meet_its_boundary(short, count):
    contours = [square(0.0, 0.0, 10.0), line((0.0, 1.0 / 3.0 + 3.0), (10.0 - short, 5.0))]
    faces = find_faces(contours)
    assert len(faces) == count
    assert sum(face.area for face in faces) == pytest.approx(100.0)


def test_loose_ends_leave_a_face_whole_and_an_open_contour_that_all_but_closes_is_one():
    assert areas([square(0.0, 0.0, 10.0), line((5.0, 0.0), (5.0, 6.0)), line((0.0, 5.0), (-6.0, 5.0))]) == [100.0]
    assert areas([line((0.0, 0.05), (0.0, 10.0), (10.0, 10.0), (10.0, 0.0), (0.0, 0.0))]) == [100.0]


def test_what_the_border_of_the_image_cuts_is_no_face():
    assert faces_drawn(48, lambda row, col: np.where(np.hypot(row, col - 24.0) < 15.0, 200.0, 40.0)) == ()


def test_a_volume_has_no_faces():
    plane, row, col = np.ogrid[:16, :24, :24]
    ball = cpm.Image(200.0 * ((plane - 8) ** 2 + (row - 12) ** 2 + (col - 12) ** 2 < 36.0))
    assert cpm.segment(ball, cpm.sphere((8, 12, 12), 4, 40), cpm.PRESETS["volume"]).faces == ()


@settings(max_examples=30, deadline=None)
@given(st.integers(5, 60), st.integers(0, 10**6))
def test_the_bounded_cells_of_a_voronoi_diagram_are_the_faces_of_its_edges(count, seed):
    """Each edge is a contour of its own, in any order and direction; those to the outside have a loose end."""
    rng = np.random.default_rng(seed)
    voronoi = scipy.spatial.Voronoi(rng.uniform(0.0, 200.0, (count, 2)))
    contours = []
    for edge in rng.permutation(np.array(voronoi.ridge_vertices)):
        if edge.min() >= 0:
            a, b = voronoi.vertices[rng.permutation(edge)]
            contours.append(cpm.Contour(a + (b - a) * np.linspace(0.0, 1.0, rng.integers(2, 6))[:, None], False))
    faces = find_faces(contours)
    shapes = [shapely.Polygon(face.outer, face.holes) for face in faces]
    wide = sorted(cell.area for cell in bounded_cells(voronoi) if cell.area > 1.0)
    assert sorted(face.area for face in faces if face.area > 1.0) == pytest.approx(wide, rel=1e-4)
    assert sum(face.area for face in faces) == pytest.approx(shapely.union_all(shapes).area, rel=1e-9, abs=1e-9)
    assert all(one.intersection(other).area < 1e-6 for one, other in itertools.combinations(shapes, 2))
