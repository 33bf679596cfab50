"""Labels: the mask of a result or a skeleton, whatever kind of file it goes into."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cpm_core.contours.rasterize import paint
from cpm_core.contours.result import Result
from cpm_core.formats.masks import branch_mask, label_mask
from cpm_core.medial_axis.skeleton import Skeleton


def labels_of(result: Result | Skeleton) -> NDArray[np.unsignedinteger]:
    """Paint the closed contours of a result, or the branches of a skeleton.

    Returns
    -------
    ndarray of uint16 or uint32, shape `result.shape`
        Labels, 0 outside; 32 bits where there are more than 65535.

    Raises
    ------
    ValueError
        When there is nothing to paint.
    """
    if isinstance(result, Skeleton):
        branch_mask.check(result)
        return branch_mask.paint(result)
    label_mask.check(result)
    return paint(result.contours, result.shape)
