"""Learning from kept and rejected contours: the rest is sorted like them, and verdicts are never overruled."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import scipy
from hypothesis import given, settings
from hypothesis import strategies as st
from skimage.data import coins

from cpm_core import PRESETS, Contour, segment, teach, uniform_grid
from cpm_core.contours.features import FEATURES, contour_features, robustly_scaled
from cpm_core.contours.learning import _CONSTANT, _PRIOR, Examples, _covariance, left_out, most_doubtful, probabilities
from cpm_core.contours.result import Result
from cpm_core.contours.review import Mark, anchor, apply, described, examples_of, learned, reviewed

DISCS = [(30, 30), (30, 90), (30, 150), (30, 210), (90, 30), (90, 90)]


@cache
def discs_and_texture() -> Result:
    """Six discs of the same gray, and a patch of stripes and spots as strong as their edges."""
    row, col = np.indices((192, 240)).astype(float)
    values = np.full(row.shape, 60.0)
    for at_row, at_col in DISCS:
        values += 60.0 / (1.0 + np.exp(2.0 * (np.hypot(row - at_row, col - at_col) - 16.0)))
    spots = np.sin(0.55 * row + 0.2 * np.sin(0.3 * col)) * np.sin(0.6 * col)
    patch = (row > 120) & (col > 130)
    values = np.where(patch, 60.0 + 45.0 * spots, values)
    return segment(values, uniform_grid(values.shape, spacing=8.0), replace(PRESETS["automatic"], smoothing=1.0))


def is_disc(contour: Contour) -> bool:
    """Whether a contour lies on the outline of a disc."""
    away = [abs(np.hypot(*(contour.points - center).T) - 16.0).max() for center in DISCS]
    return min(away) < 3.0


def sorted_by_truth(result: Result) -> tuple[list[int], list[int]]:
    discs = [index for index, contour in enumerate(result.contours) if is_disc(contour)]
    return discs, [index for index in range(len(result.contours)) if index not in discs]


def examples_from(features: np.ndarray, judged: list[int], right: list[int]) -> Examples:
    return Examples.of([tuple(features[index]) for index in judged], [index in right for index in judged])


def test_two_kept_and_two_rejected_sort_the_rest():
    result = discs_and_texture()
    discs, texture = sorted_by_truth(result)
    assert len(discs) == 6
    assert len(texture) >= 10
    found = teach(result, kept=discs[:2], rejected=texture[:2])
    assert sum(is_disc(contour) for contour in found.contours) == 6
    assert len(found.contours) - 6 < 0.5 * len(texture)
    marks = marks_on(result, discs[:2], texture[:2])
    chances = learned(marks, result.contours)
    assert chances[discs].min() > chances[texture].max()


def test_a_few_verdicts_on_what_is_most_doubtful_sort_nearly_all():
    result = discs_and_texture()
    discs, texture = sorted_by_truth(result)
    features, judged = contour_features(result.contours), [discs[0], texture[0]]
    for _ in range(8):
        chances = probabilities(examples_from(features, judged, discs), features)
        judged.append(most_doubtful(result.contours, chances, judged))
    assert len(set(judged)) == 10
    out = left_out(probabilities(examples_from(features, judged, discs), features))
    assert not out[discs].any()
    length = np.array([contour.length for contour in result.contours])
    assert length[texture][out[texture]].sum() > 0.95 * length[texture].sum()


def test_what_is_judged_the_other_way_round_is_sorted_the_other_way_round():
    result = discs_and_texture()
    discs, texture = sorted_by_truth(result)
    found = teach(result, kept=texture[:2], rejected=discs[:2])
    assert not any(is_disc(contour) for contour in found.contours)
    assert len(found.contours) >= 0.9 * len(texture)


def test_without_examples_nothing_is_left_out():
    result = discs_and_texture()
    assert teach(result) is result
    assert apply(result, (), learning=True) is result
    assert not left_out(probabilities(Examples.of((), ()), contour_features(result.contours))).any()


@settings(max_examples=25, deadline=None)
@given(st.data())
def test_verdicts_are_never_overruled(data):
    result = discs_and_texture()
    count = len(result.contours)
    verdicts = data.draw(st.dictionaries(st.integers(0, count - 1), st.booleans(), max_size=8))
    kept, rejected = ([index for index, right in verdicts.items() if right is which] for which in (True, False))
    found = teach(result, kept, rejected)
    assert all(result.contours[index] in found.contours for index in kept)
    assert not any(result.contours[index] in found.contours for index in rejected)


@settings(max_examples=15, deadline=None)
@given(st.randoms(use_true_random=False))
def test_the_order_of_contours_and_of_verdicts_does_not_matter(random):
    result = discs_and_texture()
    discs, texture = sorted_by_truth(result)
    before = teach(result, discs[:2], texture[:3]).contours
    order = list(range(len(result.contours)))
    random.shuffle(order)
    mixed = replace(result, contours=tuple(result.contours[index] for index in order))
    kept, rejected = [order.index(i) for i in discs[:2]], [order.index(i) for i in texture[:3]]
    random.shuffle(rejected)
    assert set(teach(mixed, kept, rejected).contours) == set(before)


def test_the_answer_does_not_depend_on_the_exposure():
    dark = coins()[:150, :200].astype(float)
    seeds = uniform_grid(dark.shape, spacing=8.0)
    features = [contour_features(segment(v, seeds, PRESETS["automatic"]).contours) for v in (dark, 40.0 + 0.5 * dark)]
    assert features[0].shape == features[1].shape
    np.testing.assert_allclose(features[0], features[1], atol=0.02)


def test_contours_without_an_image_stay():
    result = discs_and_texture()
    discs, texture = sorted_by_truth(result)
    drawn = Contour(np.array([[150.0, 150.0], [150.0, 180.0], [170.0, 180.0]]), True)
    more = replace(result, contours=(*result.contours, drawn))
    assert np.isnan(contour_features(more.contours)[-1]).all()
    assert drawn in teach(more, discs[:2], texture[:2]).contours
    assert teach(replace(result, contours=(drawn,)), rejected=[0]).contours == ()


def test_probabilities_are_the_mode_of_the_posterior():
    random = np.random.default_rng(1)
    given, kept = random.normal(size=(6, len(FEATURES))), np.array([1, 1, 0, 0, 1, 0], dtype=bool)
    others = random.normal(size=(5, len(FEATURES)))
    covariance = _covariance(given, given, _CONSTANT)
    inverse = np.linalg.inv(covariance)

    def loss(latent):
        signed = np.where(kept, 1.0, -1.0) * (latent + _PRIOR)
        return np.logaddexp(0.0, -signed).sum() + 0.5 * latent @ inverse @ latent

    mode = scipy.optimize.minimize(loss, np.zeros(6), options={"gtol": 1e-9}).x
    expected = scipy.special.expit(_PRIOR + _covariance(others, given, _CONSTANT) @ inverse @ mode)
    np.testing.assert_allclose(probabilities(Examples(given, kept), others), expected, atol=1e-5)


def test_the_most_doubtful_contour_is_long_and_undecided():
    lines = [Contour(np.array([[0.0, 0.0], [0.0, length]]), False) for length in (40.0, 10.0, 90.0, 50.0)]
    chances = np.array([0.5, 0.5, 0.99, np.nan])
    assert most_doubtful(lines, chances, []) == 0
    assert most_doubtful(lines, chances, [0]) == 1
    assert most_doubtful(lines, chances, [0, 1, 2]) is None
    assert most_doubtful([], np.empty(0), []) is None


def test_robust_scale_of_constant_and_of_outlying_columns():
    rows = np.array([[5.0, 0.0], [5.0, 1.0], [5.0, 2.0], [5.0, 1e9]])
    scaled = robustly_scaled(rows)
    assert (scaled[:, 0] == 0.0).all()
    assert scaled[3, 1] == 3.0
    np.testing.assert_allclose(scaled[:3, 1], (rows[:3, 1] - 1.5) / 1.4826)


@pytest.mark.parametrize(
    ("kept", "rejected", "words"), [([0, 1], [1], "Contour 1 is both"), ([900], [], "no contour 900"), ([], [-1], "-1")]
)
def test_verdicts_that_cannot_be_are_refused_in_words(kept, rejected, words):
    with pytest.raises(ValueError, match=words):
        teach(discs_and_texture(), kept, rejected)


def marks_on(result: Result, kept: list[int], rejected: list[int]) -> list[Mark]:
    contours, features = result.contours, contour_features(result.contours)
    verdicts = [(index, "kept") for index in kept] + [(index, "rejected") for index in rejected]
    marks = [Mark(anchor(contours, index), verdict) for index, verdict in verdicts]
    return list(described(marks, contours, features))


def test_marks_teach_as_verdicts_do():
    result = discs_and_texture()
    discs, texture = sorted_by_truth(result)
    marks = marks_on(result, discs[:2], texture[:2])
    assert len(examples_of(marks)) == 4
    expected = teach(result, discs[:2], texture[:2]).contours
    assert apply(result, marks, learning=True).contours == expected
    assert len(apply(result, marks).contours) == len(result.contours) - 2


def test_named_contours_are_never_left_out():
    result = discs_and_texture()
    discs, texture = sorted_by_truth(result)
    marks = marks_on(result, discs[:2], texture[:2])
    named = Mark(anchor(result.contours, texture[5]), name="the one I want")
    left = {one.name for one in apply(result, [*marks, named], learning=True).contours}
    assert "the one I want" in left


def test_marks_of_one_image_teach_another():
    result = discs_and_texture()
    discs, texture = sorted_by_truth(result)
    marks = marks_on(result, discs[:2], texture[:2])
    elsewhere = [replace(mark, anchor=(1e5, 1e5)) for mark in marks]
    found = apply(result, elsewhere, learning=True)
    assert sum(is_disc(contour) for contour in found.contours) == 6
    assert len(found.contours) - 6 < 0.5 * len(texture)


def test_a_contour_tells_that_it_is_left_out_as_learned():
    result = discs_and_texture()
    discs, texture = sorted_by_truth(result)
    marks = marks_on(result, discs[:2], texture[:2])
    every = reviewed(result.contours, marks, learned(marks, result.contours))
    assert every[texture[0]].rejected
    assert not every[texture[0]].left_out  # it has a verdict of its own
    assert every[texture[2]].left_out
    assert every[texture[2]].rejected
    assert not every[discs[4]].rejected
