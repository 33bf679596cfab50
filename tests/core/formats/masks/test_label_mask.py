"""Label mask: the inside of each closed contour carries its own label."""

import numpy as np
import PIL.Image
import pytest

from cpm_core.contours.contour import Contour
from cpm_core.formats import MASK_SUFFIXES, count_left_out, export, to_bytes
from cpm_core.formats.ground_truth_file import load_truth
from cpm_core.formats.masks.labels import label_palette, paint_labels
from cpm_core.results.result import Result


def polygon_of(row, col, radius, count=40, rough=0.0, seed=0):
    """A round contour about (row, col), its radius made rough by the share `rough`."""
    angle = 2 * np.pi * np.arange(count) / count
    radii = radius * (1 + rough * np.random.default_rng(seed).uniform(-1, 1, count))
    return np.stack([row + radii * np.sin(angle), col + radii * np.cos(angle)], axis=1)


def result_of(points, shape=(60, 90), closed=True):
    contours = tuple(Contour(p, closed=closed, strength=1.0) for p in points)
    return Result(np.zeros((0, 2)), contours, None, 1, True, "at rest", shape, (1.0, 1.0), None, "a.png")


def mask_of(tmp_path, result):
    export(result, tmp_path / "m.png")
    return indices(tmp_path / "m.png")


def indices(path):
    with PIL.Image.open(path) as picture:
        return np.asarray(picture)


def inside(points, shape):
    """Whether each pixel centre lies inside, by the turns of the polygon around it: another way than the writer's."""
    row, col = np.mgrid[: shape[0], : shape[1]]
    around = np.arctan2(points[:, 0, None, None] - row, points[:, 1, None, None] - col)
    turns = np.diff(np.concatenate([around, around[:1]]), axis=0)
    turns -= 2 * np.pi * np.round(turns / (2 * np.pi))
    return np.abs(turns.sum(axis=0)) > np.pi


@pytest.mark.parametrize("seed", range(2))
def test_pixels_whose_centre_is_inside_carry_the_label_and_no_others(tmp_path, seed):
    points = polygon_of(27.3, 41.7, 20.2, rough=0.5, seed=seed)
    mask = mask_of(tmp_path, result_of([points]))
    assert mask.dtype == np.uint8
    assert mask.shape == (60, 90)
    assert np.array_equal(mask == 1, inside(points, mask.shape))
    assert set(np.unique(mask)) == {0, 1}


@pytest.mark.parametrize("order", [(0, 1, 2), (1, 2, 0)])
def test_a_contour_inside_another_is_on_top_in_any_order(tmp_path, order):
    nested = [polygon_of(30.2, 45.1, radius) for radius in (28.3, 18.3, 8.3)]
    points = [nested[index] for index in order]
    mask = mask_of(tmp_path, result_of(points))
    label = {index: order.index(index) + 1 for index in order}
    innermost, middle, outermost = (inside(nested[index], mask.shape) for index in (2, 1, 0))
    assert np.all(mask[innermost] == label[2])
    assert np.all(mask[middle & ~innermost] == label[1])
    assert np.all(mask[outermost & ~middle] == label[0])
    assert np.all(mask[~outermost] == 0)


def test_what_reaches_over_the_border_is_cut_off(tmp_path):
    points = polygon_of(2.2, 88.4, 15.3)
    mask = mask_of(tmp_path, result_of([points]))
    assert np.array_equal(mask == 1, inside(points, mask.shape))


@pytest.mark.parametrize(("count", "kind"), [(255, np.uint8), (256, np.uint16)])
def test_more_labels_than_eight_bits_hold_make_sixteen(tmp_path, count, kind):
    centers = [(4 + 6 * (k // 20), 4 + 6 * (k % 20)) for k in range(count)]
    mask = mask_of(tmp_path, result_of([polygon_of(r, c, 2.2, 12) for r, c in centers], shape=(110, 130)))
    assert mask.dtype == kind
    assert [int(mask[center]) for center in centers] == list(range(1, count + 1))


@pytest.mark.parametrize("points", [[], [polygon_of(30, 30, 10)]])
def test_without_a_closed_contour_nothing_is_written(tmp_path, points):
    with pytest.raises(ValueError, match=r"No contour of a\.png is closed"):
        export(result_of(points, closed=False), tmp_path / "m.png")
    assert list(tmp_path.iterdir()) == []


def test_labels_are_shown_in_bright_colors_far_apart_and_no_two_with_the_same_luminance():
    colors = label_palette(255).astype(float)
    assert colors[0].tolist() == [0, 0, 0]
    luminance = colors @ (0.299, 0.587, 0.114)
    assert luminance[1:].min() > 40.0
    assert len(np.unique(np.round(luminance, 3))) == 256
    apart = np.linalg.norm(colors[:30, None] - colors[None, :30], axis=-1)[~np.eye(30, dtype=bool)]
    assert apart.min() > 15.0


def test_a_mask_in_colors_is_read_as_truth_with_all_its_objects(tmp_path):
    centers = [(8 + 16 * (k // 9), 8 + 16 * (k % 9)) for k in range(72)]
    result = result_of([polygon_of(r, c, 6.2) for r, c in centers], shape=(140, 150))
    export(result, tmp_path / "m.png")
    truth = load_truth(tmp_path / "m.png", (140, 150))
    mask = indices(tmp_path / "m.png")
    assert np.array_equal(truth.labels > 0, mask > 0)
    assert len(np.unique(truth.labels)) == 73
    assert len(np.unique(truth.labels * 100 + mask)) == 73


@pytest.mark.parametrize("suffix", sorted(MASK_SUFFIXES))
def test_outlines_hold_open_contours_too_as_lines_with_their_numbers(tmp_path, suffix):
    ring, arc = polygon_of(30, 30, 14.0), polygon_of(30, 62, 14.0)[:20]
    contours = (Contour(ring, True, number=4), Contour(arc, False, number=9))
    result = Result(np.zeros((0, 2)), contours, None, 1, True, "", (60, 90), (1.0, 1.0), None, "a.png")
    assert count_left_out(result, suffix) == 1
    assert count_left_out(result, suffix, outlines=True) == 0
    mask = paint_labels(result, outlines=True)
    assert np.unique(mask).tolist() == [0, 4, 9]
    assert mask[30, 30] == 0
    rows, cols = np.nonzero(mask == 4)
    assert np.abs(np.hypot(rows - 30, cols - 30) - 14.0).max() <= 1.0
    for points, number in ((ring, 4), (arc, 9)):
        near = np.floor(points + 0.5).astype(int)
        assert (mask[near[:, 0], near[:, 1]] == number).all()
    assert to_bytes(result, suffix, outlines=True) != to_bytes(result, suffix)
