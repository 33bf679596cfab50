"""Grab cut gives, step by step, what OpenCV's own function gives at once."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from cpm_core.image.colors import Colors
from cpm_core.image.image import Image
from cpm_core.objects.methods import CONTOUR_METHODS, Start, run_method
from cpm_core.objects.methods.regions import (
    BACKGROUND,
    MAYBE_BACKGROUND,
    MAYBE_OBJECT,
    OBJECT,
    GrabCutSettings,
    first_labels,
    samples_of,
)

from .published import ring

ROW, COL = np.indices((48, 56))
DISK = np.hypot(ROW - 24, COL - 27) < 13
NOISE = np.random.default_rng(5).normal(0.0, 12.0, ROW.shape)
IMAGE = Image(np.where(DISK, 180.0, 60.0) + NOISE)
INSIDE, AROUND = Start((ring((24.0, 27.0), 7.0),)), Start((ring((24.0, 27.0), 20.0),), around=True)


@pytest.mark.parametrize("start", [INSIDE, AROUND])
def test_grab_cut_gives_the_same_to_the_bit(start):
    cv2 = pytest.importorskip("cv2", exc_type=ImportError)
    settings = GrabCutSettings()
    states = CONTOUR_METHODS["grab_cut"].evolve(IMAGE, start, settings)
    *_, own = (state for state, _ in zip(states, range(4), strict=False))
    labels = first_labels(start, IMAGE.shape, settings)
    cv2.setRNGSeed(0)
    models = np.zeros((1, 65)), np.zeros((1, 65))
    cv2.grabCut(samples_of(IMAGE, 0.0), labels, None, *models, own.step, cv2.GC_INIT_WITH_MASK)
    assert_array_equal(own.inside, labels % 2 == 1)


def test_a_start_says_what_is_certain():
    inside = INSIDE.mask(IMAGE.shape)
    labels = first_labels(INSIDE, IMAGE.shape, GrabCutSettings())
    assert set(np.unique(labels[inside])) == {OBJECT}
    assert set(np.unique(labels[~inside])) == {BACKGROUND, MAYBE_BACKGROUND}
    assert (labels[0] == BACKGROUND).all() and labels[1, 1] == MAYBE_BACKGROUND
    assert first_labels(INSIDE, IMAGE.shape, GrabCutSettings(margin=9.0))[1, 1] == BACKGROUND
    around = AROUND.mask(IMAGE.shape)
    labels = first_labels(AROUND, IMAGE.shape, GrabCutSettings())
    assert set(np.unique(labels[around])) == {MAYBE_OBJECT}
    assert set(np.unique(labels[~around])) == {BACKGROUND}
    assert first_labels(AROUND, IMAGE.shape, GrabCutSettings(depth=0.5))[24, 27] == OBJECT


def test_colors_are_told_apart_where_gray_levels_are_not():
    pytest.importorskip("cv2", exc_type=ImportError)
    samples = np.where(DISK[..., None], (200, 60, 60), (60, 129, 60)).astype(np.uint8)
    flat = np.full(ROW.shape, 100.0) + 1e-3 * NOISE
    image = Image(flat, colors=Colors(samples, 255.0))
    found = run_method(CONTOUR_METHODS["grab_cut"], image, INSIDE).state
    assert found.converged
    assert (found.inside == DISK).mean() > 0.99
