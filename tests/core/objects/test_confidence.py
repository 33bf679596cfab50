"""How sure an object is: a probability that grows with what speaks for it, from numbers whose origin is stated."""

import json
from importlib.resources import files

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cpm_core.objects.confidence import (
    ConfidenceFeatures,
    RegionFeatures,
    estimate_confidence,
    estimate_region_confidence,
)

SHARE = st.floats(0.0, 1.0)
FEATURES = st.builds(ConfidenceFeatures, SHARE, SHARE, SHARE, SHARE, st.integers(0, 20), st.booleans())
REGION_FEATURES = st.builds(
    RegionFeatures, SHARE, SHARE, SHARE, st.floats(30.0, 1e6), *[SHARE] * 6, *[st.booleans()] * 3
)


@pytest.mark.parametrize("feature", ["predicted_iou", "mean_certainty", "iou_to_previous", "iou_to_other_crop"])
@given(features=FEATURES, more=SHARE)
def test_an_object_is_the_surer_the_more_speaks_for_it(feature, features, more):
    larger = features._replace(**{feature: max(more, getattr(features, feature))})
    assert 0.0 < estimate_confidence(features) <= estimate_confidence(larger) < 1.0


@given(features=FEATURES)
def test_the_places_of_a_stroke_do_not_count_as_so_many_clicks(features):
    few, stroke = (estimate_confidence(features._replace(point_count=count)) for count in (4, 40))
    assert stroke == few


@given(features=REGION_FEATURES, more=SHARE)
def test_a_region_is_the_surer_the_larger_the_predicted_overlap(features, more):
    better = features._replace(predicted_iou=max(more, features.predicted_iou))
    assert 0.0 < estimate_region_confidence(features) <= estimate_region_confidence(better) < 1.0


@pytest.mark.parametrize("name", ["confidence.json", "confidence_everywhere.json", "merged_basins.json"])
def test_the_origin_of_the_numbers_is_stated(name):
    stored = json.loads(files("cpm_core.objects").joinpath(name).read_text("utf-8"))
    assert {"numbers", "features", "right", "seed", "script", "data"} <= stored.keys()
