"""How sure an object is: a probability that grows with what speaks for it, from numbers whose origin is stated."""

import json
from importlib.resources import files

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cpm_core.objects.confidence import ConfidenceFeatures, estimate_confidence

SHARE = st.floats(0.0, 1.0)
SIGNS = st.builds(ConfidenceFeatures, SHARE, SHARE, SHARE, SHARE, st.integers(0, 20), st.booleans())


@pytest.mark.parametrize("sign", ["overlap", "clarity", "steadiness", "agreement"])
@given(signs=SIGNS, more=SHARE)
def test_an_object_is_the_surer_the_more_speaks_for_it(sign, signs, more):
    larger = signs._replace(**{sign: max(more, getattr(signs, sign))})
    assert 0.0 < estimate_confidence(signs) <= estimate_confidence(larger) < 1.0


def test_the_origin_of_the_numbers_is_stated():
    stored = json.loads(files("cpm_core.objects").joinpath("confidence.json").read_text("utf-8"))
    assert {"numbers", "answers", "seed", "script", "data"} <= stored.keys()
