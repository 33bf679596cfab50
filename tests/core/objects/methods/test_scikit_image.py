"""The methods of scikit-image give, step by step, what its own functions give at once."""

import itertools

import numpy as np
import pytest
import scipy
import skimage

from cpm_core.image.image import Image
from cpm_core.objects.methods import CONTOUR_METHODS, Start, run_method
from cpm_core.objects.methods.gray import sobel_edges, unit_gray
from cpm_core.objects.methods.regions import (
    ChanVeseSettings,
    MorphologicalChanVeseSettings,
    MorphologicalGacSettings,
    RandomWalkerSettings,
    first_level_set,
    seeds,
)
from cpm_core.objects.methods.snakes import Elasticity, edge_force, moved

from .published import ring

ROW, COL = np.indices((48, 56))
IMAGE = Image(
    np.where(np.hypot(ROW - 24, COL - 27) < 13, 180.0, 60.0) + np.random.default_rng(5).normal(0.0, 12.0, ROW.shape)
)
START = Start((ring((24.0, 27.0), 7.0),))
MASK = START.mask(IMAGE.shape).astype(np.int8)


def evolved(name, settings):
    return CONTOUR_METHODS[name].evolve(IMAGE, START, settings)


def state_after(name, settings, steps):
    return next(state for state in evolved(name, settings) if state.step == steps)


def first_turn():
    """Bring the smoothing of scikit-image to the operator that is first in a new process."""
    probe = np.array([[1, 0, 1], [1, 0, 0], [0, 1, 1]], dtype=np.int8)  # which of the two leaves something
    if skimage.segmentation.morphological_chan_vese(np.zeros((3, 3)), 1, probe).any():
        skimage.segmentation.morphological_chan_vese(np.zeros((3, 3)), 1, probe)


@pytest.mark.parametrize("smoothing", [1, 2])
def test_morphological_gac_gives_the_same_to_the_bit(smoothing):
    own = state_after("morph_gac", MorphologicalGacSettings(smoothing=smoothing), 11)
    factor = skimage.segmentation.inverse_gaussian_gradient(unit_gray(IMAGE), 100.0, 3.0)
    first_turn()
    theirs = skimage.segmentation.morphological_geodesic_active_contour(factor, 11, MASK, smoothing, 0.6, 1.0)
    assert np.array_equal(own.values, theirs)


@pytest.mark.parametrize("smoothing", [1, 3])
def test_morphological_chan_vese_gives_the_same_to_the_bit(smoothing):
    own = state_after("morph_chan_vese", MorphologicalChanVeseSettings(smoothing=smoothing), 9)
    first_turn()
    theirs = skimage.segmentation.morphological_chan_vese(unit_gray(IMAGE), 9, MASK, smoothing, 0.7, 1.0)
    assert np.array_equal(own.values, theirs)


def test_morphological_runs_that_take_turns_do_not_disturb_each_other():
    settings = MorphologicalGacSettings(smoothing=1), MorphologicalChanVeseSettings(smoothing=1)
    alone = [
        [state.values for state in itertools.islice(evolved(name, chosen), 30)]
        for name, chosen in zip(("morph_gac", "morph_chan_vese"), settings, strict=True)
    ]
    one, other = evolved("morph_gac", settings[0]), evolved("morph_chan_vese", settings[1])
    in_turn = list(zip(itertools.islice(one, 30), itertools.islice(other, 30), strict=True))
    for before, (first, second) in zip(zip(*alone, strict=True), in_turn, strict=True):
        assert np.array_equal(before[0], first.values)
        assert np.array_equal(before[1], second.values)


def test_chan_vese_gives_the_same_to_the_bit_and_ends_with_it():
    settings = ChanVeseSettings(mu=0.25, lambda1=1.0, time_step=0.5, tolerance=0.02)
    own = run_method(CONTOUR_METHODS["chan_vese"], IMAGE, START, settings).state
    first = first_level_set(START.mask(IMAGE.shape))
    _, phi, energies = skimage.segmentation.chan_vese(
        unit_gray(IMAGE), 0.25, 1.0, 1.0, 0.02, 500, 0.5, first, extended_output=True
    )
    assert own.converged
    assert own.step == len(energies)
    assert np.array_equal(own.values, phi)


def test_the_random_walker_gives_the_same_to_the_bit():
    settings = RandomWalkerSettings(beta=90.0)
    own = run_method(CONTOUR_METHODS["random_walker"], IMAGE, START, settings).state
    labels = seeds(START, IMAGE.shape, settings)
    assert np.array_equal(own.values, skimage.segmentation.random_walker(unit_gray(IMAGE), labels, 90.0, "bf") == 1)


@pytest.mark.parametrize(("alpha", "beta", "count"), [(0.015, 0.1, 90), (0.05, 10.0, 61)])
def test_the_classical_snake_moves_as_active_contour_does(alpha, beta, count):
    curve = ring((23.0, 28.0), 17.0, count)
    smooth = scipy.ndimage.gaussian_filter(unit_gray(IMAGE), 2.0, mode="nearest")
    theirs = skimage.segmentation.active_contour(
        smooth, curve, alpha=alpha, beta=beta, gamma=0.01, max_num_iter=60, convergence=0.0
    )
    force, elasticity = edge_force(sobel_edges(IMAGE, 2.0), 1.0), Elasticity(alpha, beta, 0.01, 0.0)
    own = curve
    for _ in range(60):
        own = moved(own, force, elasticity, IMAGE.shape)
    assert np.allclose(own, theirs, rtol=0.0, atol=1e-7)
