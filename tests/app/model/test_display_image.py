"""Shades keep the order of what they show and use all of their range."""

from __future__ import annotations

import numpy as np
import pytest
from cpm_app.model.display.display_image import IntensityWindow, apply_window, shade_edge_map
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays


def whole_range(values):
    return apply_window(values, IntensityWindow(values.min(), values.max()))


MAPS = arrays(np.float64, (3, 5), elements=st.floats(0.0, 1e6, allow_subnormal=False))


@given(MAPS)
@pytest.mark.parametrize("made", [whole_range, shade_edge_map])
def test_what_is_brighter_is_shown_no_darker(made, values):
    shown = made(values).ravel()[np.argsort(values, axis=None)]
    assert shown.dtype == np.uint8
    assert (np.diff(shown.astype(int)) >= 0).all()


def test_the_darkest_pixel_is_black_and_the_brightest_is_white():
    assert whole_range(np.array([[-3.0, 1.0], [2.0, 7.0]])).tolist() == [[0, 102], [128, 255]]


def test_of_weak_edges_more_is_seen_than_their_share():
    assert shade_edge_map(np.array([[0.0, 1.0], [4.0, 16.0]])).tolist() == [[0, 64], [128, 255]]


@pytest.mark.parametrize("made", [whole_range, shade_edge_map])
def test_an_image_without_contrast_is_black(made):
    assert not made(np.zeros((4, 4))).any()
