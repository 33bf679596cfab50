"""Values that callers give: finite numbers on a grid, or one sentence that names the value."""

import numpy as np
import pytest

from cpm_core import (
    Geometry,
    Parameters,
    circle,
    edge_map,
    electric_field,
    gradient_threshold,
    measure,
    stroke,
    uniform_grid,
)
from cpm_core.numerics.real_numbers import check_finite_number
from cpm_core.parameters.formatting import quote_value


@pytest.mark.parametrize("value", [None, "2", [1.0], np.nan, np.inf, -1, 10**400, 1j, object(), np.float32(-1.0)])
def test_what_is_no_number_that_fits_is_named(value):
    with pytest.raises(ValueError, match=r"^size is .* but must be above 0\.$"):
        check_finite_number("size", value, lambda size: size > 0.0, "above 0")


@pytest.mark.parametrize("value", ["x" * 10**6, "\x1b\n\x7f\u2028", list(range(99)), np.zeros((9, 9)), 10**90, 1e-300])
def test_a_value_is_shown_on_one_printable_line(value):
    assert quote_value(value).isprintable()
    assert len(quote_value(value)) <= 40


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: edge_map([1.0, 2.0]), "shape"),
        (lambda: edge_map([[1.0, 2.0]]), "shape"),
        (lambda: edge_map([[1.0, 2.0], [3.0]]), "differ in length"),
        (lambda: edge_map(np.full((9, 9), np.nan)), "NaN, infinite or far too large"),
        (lambda: edge_map(np.where(np.eye(9) > 0.0, 1e308, -1e308)), "NaN, infinite or far too large"),
        (lambda: edge_map(np.eye(9), None), "smoothing is None"),
        (lambda: electric_field(np.full((9, 9), np.inf)), "NaN, infinite or far too large"),
        (lambda: electric_field(np.eye(9), exponent=[1.0]), r"exponent is \[1.0\]"),
        (lambda: electric_field(np.eye(9), "pppm", np.ones((3, 2))), "exponent is array.* must be 2"),
        (lambda: Parameters(gamma=np.ones((3, 2))), "gamma is array"),
        (lambda: Parameters(smoothing=np.ones(2)), "smoothing is array"),
        (lambda: Geometry().affine((1.0, 1.0), "LPI"), 'convention is "LPI" but must be'),
        (lambda: Geometry().affine((1.0, 1.0), np.ones((3, 2))), "convention is array"),
        (lambda: gradient_threshold(np.zeros((0, 0))), "shape"),
        (lambda: uniform_grid((10**6, 10**6), 1e-6), "choose a larger spacing"),
        (lambda: uniform_grid((16.5, 3)), "whole numbers"),
        (lambda: circle((8.0, 8.0), 1e4, 1e-6), "choose a larger spacing"),
        (lambda: stroke([(0.0, 0.0), (0.0, 1e5)], 1e-6), "choose a larger spacing"),
        (lambda: measure((), (0.0, 1.0)), "spacing is"),
    ],
)
def test_bad_input_of_the_library_is_refused_in_one_sentence(call, said):
    with pytest.raises(ValueError, match=said) as caught:
        call()
    assert str(caught.value).endswith(".")
    assert str(caught.value).isprintable()
