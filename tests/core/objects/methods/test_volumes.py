"""Methods in volumes: the same interface, spheres as starts, surfaces as outcomes."""

import numpy as np
import pytest
import skimage
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core.contours.surface.ground_truth import VolumeTruth
from cpm_core.image.image import Image
from cpm_core.objects.methods import CONTOUR_METHODS, Start, facts_of, moments, result_of, run_method, runnable
from cpm_core.objects.methods.gray import unit_gray
from cpm_core.objects.methods.regions import MorphologicalChanVeseSettings, MorphologicalGacSettings
from cpm_core.objects.methods.states import level_surface
from cpm_core.parameters import PRESETS

from .published import ring
from .test_scikit_image import first_turn

AT = np.indices((23, 25, 27))
BALL = np.linalg.norm(AT - np.array([11, 12, 13])[:, None, None, None], axis=0) < 7.5
NOISE = np.random.default_rng(2).normal(0.0, 5.0, BALL.shape)
VOLUME = Image(np.where(BALL, 180.0, 40.0) + NOISE, spacing=(0.5, 0.5, 0.5), unit="mm", source="ball")
START = Start((), spheres=((11.0, 12.0, 13.0, 4.0),))
TRUTH = VolumeTruth(BALL, VOLUME.spacing, VOLUME.unit)


SETTINGS = {"cpm": PRESETS["volume"], "morph_gac": MorphologicalGacSettings(sigma=1.0)}


@pytest.mark.parametrize("name", runnable(3))
def test_a_ball_is_found_with_one_closed_surface(name):
    method = CONTOUR_METHODS[name]
    chosen = SETTINGS.get(name, method.settings())
    end = run_method(method, VOLUME, START, chosen)
    facts = facts_of(end, TRUTH)
    assert (facts.contours, facts.closed) == (1, 1)
    assert facts.dice > 0.95
    assert facts.f > 0.99
    assert facts.hausdorff < 1.0  # [mm]: two voxels
    result = result_of(facts, end.state.contours, VOLUME, START, chosen, end.state.surface)
    assert result.surface.spacing == VOLUME.spacing
    assert abs(result.surface.volume / (BALL.sum() * 0.125) - 1.0) < 0.15


def test_steps_of_morphological_methods_give_what_scikit_image_gives_to_the_bit():
    mask = START.mask(BALL.shape).astype(np.int8)
    methods = {
        "morph_gac": (MorphologicalGacSettings(smoothing=1, sigma=1.0), lambda count: (
            skimage.segmentation.morphological_geodesic_active_contour(
                skimage.segmentation.inverse_gaussian_gradient(unit_gray(VOLUME), 100.0, 1.0), count, mask, 1, 0.6, 1.0
            )
        )),
        "morph_chan_vese": (MorphologicalChanVeseSettings(), lambda count: (
            skimage.segmentation.morphological_chan_vese(unit_gray(VOLUME), count, mask, 1, 0.7, 1.0)
        )),
    }  # fmt: skip
    for name, (chosen, theirs) in methods.items():
        own = run_method(CONTOUR_METHODS[name], VOLUME, START, chosen, max_steps=7).state
        first_turn()
        assert np.array_equal(own.values, theirs(7)), name


@given(seed=st.integers(0, 2**16), share=st.floats(0.01, 0.99), side=st.integers(2, 9))
@settings(max_examples=30, deadline=None)
def test_the_surface_of_any_voxels_is_closed_and_looks_outwards(seed, share, side):
    inside = np.random.default_rng(seed).random((side, side + 1, side)) < share
    surface = level_surface(inside, 0.5)
    assert surface.closed == inside.any()
    assert (surface.volume > 0.0) == inside.any()


def test_the_start_holds_the_voxels_in_its_spheres_whatever_their_sides():
    start = Start((), spheres=((11.0, 12.0, 13.0, 4.0), (3.0, 3.0, 3.0, 2.0)), sides=(2.0, 1.0, 1.0))
    inside = start.mask(BALL.shape)
    assert inside[11, 16, 13] and not inside[11, 17, 13] and inside[13, 12, 13] and not inside[14, 12, 13]
    assert inside[3, 3, 5] and start.ndim == 3
    away = (start.points[:625] - [11.0, 12.0, 13.0]) * [2.0, 1.0, 1.0]
    np.testing.assert_allclose(np.linalg.norm(away, axis=1), 4.0, rtol=1e-9)


def test_the_spheres_of_a_start_may_be_rows_of_an_array():
    spheres = ((11.0, 12.0, 13.0, 4.0), (3.0, 3.0, 3.0, 2.0))
    assert np.array_equal(Start((), spheres=np.array(spheres)).points, Start((), spheres=spheres).points)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: Start((ring((9, 9), 4.0),), spheres=((1, 2, 3, 4),)), "not both"),
        (lambda: Start((), spheres=((1, 2, 3),)), "plane, row, column and a radius"),
        (lambda: Start((), spheres=1e300), r"A sphere is 1e\+300 but must be plane, row, column and a radius"),
        (lambda: Start((), spheres=((1, 2, 3, 0),)), "a radius above 0"),
        (lambda: Start((ring((9, 9), 4.0),)).mask((20,)), r"shape of image is \(20,\) but must be rows and columns"),
        (lambda: next(moments(CONTOUR_METHODS["gvf"], VOLUME, START)), "ball is a volume, but GVF snake is for images"),
        (lambda: next(moments(CONTOUR_METHODS["morph_gac"], VOLUME, Start((ring((9, 9), 4.0),)))), "has 3 axes: give"),
        (lambda: next(moments(CONTOUR_METHODS["morph_gac"], Image(np.eye(9)), START)), "has 2 axes: give"),
    ],
)
def test_what_does_not_fit_is_refused_in_a_sentence(make, sentence):
    with pytest.raises(ValueError, match=sentence):
        make()
