import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.ndimage import label

from cpm_core.numerics.grids import find_connected_parts


@settings(max_examples=24, deadline=None)
@given(arrays(bool, st.tuples(*[st.integers(1, 7)] * 3)), st.booleans())
def test_parts_of_a_mask_are_its_labels(mask, corners):
    labels, count = label(mask, np.ones((3, 3, 3)) if corners else None)
    parts = find_connected_parts(mask, corners=corners)
    assert parts.count == count
    found = parts.part_at(np.argwhere(np.ones_like(mask)))
    assert (found.reshape(mask.shape) >= 0).tolist() == mask.tolist()
    assert parts.labels.tolist() == labels.tolist()
    assert parts.sizes.tolist() == np.bincount(labels.ravel(), minlength=count + 1)[1:].tolist()
    inner = labels.copy()
    inner[1:-1, 1:-1, 1:-1] = 0
    assert np.flatnonzero(parts.at_border).tolist() == (np.unique(inner[inner > 0]) - 1).tolist()
