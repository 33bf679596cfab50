import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.ndimage import label

from cpm_core.numerics.grids import parts_of


@settings(max_examples=24, deadline=None)
@given(arrays(bool, st.tuples(*[st.integers(1, 7)] * 3)), st.booleans())
def test_parts_of_a_mask_are_its_labels(mask, corners):
    labels, count = label(mask, np.ones((3, 3, 3)) if corners else None)
    parts = parts_of(mask, corners=corners)
    assert parts.count == count
    found = parts.part_at(np.argwhere(np.ones_like(mask)))
    assert len(set(zip(found.tolist(), labels.ravel().tolist(), strict=True))) == len(np.unique(labels))
    assert (found.reshape(mask.shape) >= 0).tolist() == mask.tolist()
    assert sorted(parts.sizes.tolist()) == sorted(np.bincount(labels.ravel())[1:].tolist())
