"""Parameters: every number defined once, and refused when it makes no sense."""

import dataclasses
import re

import numpy as np
import pytest

from cpm_core.parameters import DEFAULT_VALUES, PARAMETERS, PRESETS, Parameters
from cpm_core.parameters.choices import CHOICE_PARAMETERS

NAMES = [field.name for field in dataclasses.fields(Parameters) if field.name not in CHOICE_PARAMETERS]


def test_defaults_are_those_of_the_published_experiments():
    assert dataclasses.astuple(Parameters())[2:9] == (0.8, 1.6, 1.75, 0.99, 0.5, 2.0, 3.0)
    automatic = PRESETS["automatic"]
    assert (automatic.w1, automatic.w2, automatic.beta) == (0.6, 0.7, 0.4)


@pytest.mark.parametrize("name", NAMES)
def test_slider_stays_within_what_is_allowed_and_reaches_the_default(name):
    info = PARAMETERS[name]
    assert info.low <= info.slider_low < info.slider_high <= info.high
    assert DEFAULT_VALUES[name] == "auto" or info.slider_low <= DEFAULT_VALUES[name] <= info.slider_high
    assert 0 < info.step <= info.slider_high - info.slider_low


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("value", ["below", "above", float("nan"), float("inf"), "much", None, True])
def test_a_bad_value_is_refused_by_name_value_and_range(name, value):
    info = PARAMETERS[name]
    bad = {"below": info.low - 1, "above": info.high * 2 + 1}.get(value, value)
    with pytest.raises(ValueError, match=rf"^{name} is .* must be .* from {re.escape(f'{info.low:g}')} to ") as caught:
        Parameters(**{name: bad})
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("w1", [1.75, 2.0])
def test_repulsion_must_stay_weaker_than_attraction(w1):
    with pytest.raises(ValueError, match=r"w2 is 1\.75 but must be above w1"):
        Parameters(w1=w1, w2=1.75)


@pytest.mark.parametrize("name", CHOICE_PARAMETERS)
def test_a_choice_takes_its_names_alone_and_the_first_by_itself(name):
    info = CHOICE_PARAMETERS[name]
    assert getattr(Parameters(), name) == next(iter(info.choices))
    assert all(getattr(Parameters(**{name: value}), name) == value for value in info.choices)
    assert all(sentence[0].isupper() and sentence.endswith(".") for sentence in (info.meaning, *info.choices.values()))
    names = " or ".join(f'"{value}"' for value in info.choices)
    for bad in ("Vessels", "", 1.0, None, ["gradient"]):
        with pytest.raises(ValueError, match=rf"^{name} is .* but must be {names}(\.|: did you mean \w+\?)$"):
            Parameters(**{name: bad})


@pytest.mark.parametrize("kind", [np.int64, np.uint8, np.float32, np.float64, float])
def test_numbers_of_numpy_are_numbers(kind):
    given = Parameters(scales=kind(2), beta=kind(1))
    assert given == Parameters(scales=2, beta=1.0)
    assert (type(given.scales), type(given.beta) in (int, float)) == (int, True)
    with pytest.raises(ValueError, match="must be a number"):
        Parameters(beta=np.bool_(True))
