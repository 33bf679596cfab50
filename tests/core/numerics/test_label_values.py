"""Different values of label volumes, however large they are."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from cpm_core.numerics.grids import find_label_boxes, rank_values

LABELS = st.lists(st.sampled_from([-1, 0, 0, 1, 2, 7, 614_454_277, 2**32 - 1]), min_size=8, max_size=60)


@given(LABELS, st.sampled_from([np.int64, np.float64]))
def test_values_and_their_ranks_are_those_of_numpy(values, kind):
    given = np.array(values[: len(values) // 4 * 4], kind).reshape(2, 2, -1)
    levels, ranks = rank_values(given)
    assert levels.dtype == kind
    assert np.array_equal(levels, np.unique(given))
    assert np.array_equal(levels[ranks], given)


@given(LABELS)
def test_each_label_above_0_has_the_window_around_its_pixels(values):
    labels = np.array(values[: len(values) // 4 * 4]).reshape(2, 2, -1)
    found = dict(find_label_boxes(labels))
    assert sorted(found) == np.unique(labels[labels > 0]).tolist()
    for number, box in found.items():
        inside = np.argwhere(labels == number)
        assert [(side.start, side.stop - 1) for side in box] == list(
            zip(inside.min(axis=0), inside.max(axis=0), strict=True)
        )
