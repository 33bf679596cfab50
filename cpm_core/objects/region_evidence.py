"""What the image and the network say for and against a region being an object."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import scipy

from cpm_core.image.region import Region
from cpm_core.numerics.grids import Window, bounding_window, expand_window, first_pixel, measure_depth
from cpm_core.numerics.types import Extent, Mask, record
from cpm_core.objects.candidate_regions import has_neck, measure_solidity
from cpm_core.objects.confidence import ConfidenceFeatures, RegionFeatures
from cpm_core.objects.image_parts import ImageParts
from cpm_core.objects.partition import Partition
from cpm_core.objects.selection import Candidate

_MARGIN = 5
"""Margin around the box of a region in which it is measured [px]."""

_INNER_DEPTH = 3.5
"""Depth from which edges are those of the inside, not of the boundary [px]."""

_TINY = 1e-6
"""Least strength, or difference of gray levels, that others are divided by."""

_WEAK_PERCENTILE = 10.0
"""Percentile of the strength along the boundary that counts as its weakest."""

_STRONG_PERCENTILE = 95.0
"""Percentile of the strength inside that counts as its strongest."""


@record
class RegionEvidence:
    """Evidence for regions of an image.

    Attributes
    ----------
    parts : ImageParts
        The image with its contours.
    """

    parts: ImageParts

    @property
    def partition(self) -> Partition:
        """The image."""
        return self.parts.partition

    def predict_candidates(self, candidate: Candidate) -> Iterator[Candidate]:
        """Predict by the network how likely a region is that contours bound, and what a point in its middle means.

        What an unambiguous contour encloses needs no such point.
        """
        region, interest = candidate.region, self.partition.interest
        if candidate.bounded:
            found = self.partition.evaluate_mask(region.paste(self.partition.shape))
            features = ConfidenceFeatures(*found[2:], point_count=0)
            yield candidate._replace(features=features)
        if candidate.unambiguous:
            return
        depth, is_pierced = measure_depth(region.mask), region.filled != region
        pixel = np.argwhere(depth == depth.max())[0] + region.origin
        for found in self.partition.predict_near(pixel, region.window):
            mask = found.mask & interest
            mask[region.window] &= ~(region.filled.mask & ~region.mask)
            if mask[tuple(pixel)]:
                box = bounding_window(mask)
                parts, _ = scipy.ndimage.label(mask[box])
                part = Region.from_mask(parts == parts[tuple(pixel - first_pixel(box))], first_pixel(box))
                features = ConfidenceFeatures(*found[2:], point_count=0)
                likelihood = found.predicted_iou * found.mean_certainty
                yield Candidate(part if is_pierced else part.filled, features, likelihood=likelihood)

    def measure_candidate(self, candidate: Candidate) -> RegionFeatures:
        """Measure what the confidence of a candidate is estimated from."""
        region, partition = candidate.region, self.partition
        window = expand_window(region.window, _MARGIN, partition.shape)
        mask, values, strength = region.cut_out(window), partition.values[window], self.parts.edge_strength[window]
        inside = scipy.ndimage.distance_transform_edt(np.pad(mask, 1, mode="edge"))[1:-1, 1:-1]
        rim, deep = (inside > 0.0) & (inside <= 1.0), strength[inside > _INNER_DEPTH]
        border = _count_border_pixels(mask, window, partition.shape)
        along = scipy.ndimage.maximum_filter(strength, 3)[rim]
        usual, weak = np.percentile(along, [50.0, _WEAK_PERCENTILE]) if along.size else (0.0, 0.0)
        likely = candidate.features or ConfidenceFeatures(point_count=0)
        solidity = measure_solidity(region)
        return RegionFeatures(
            likely.predicted_iou,
            likely.mean_certainty,
            likely.iou_to_previous,
            region.size,
            solidity,
            border / (border + along.size),
            float(along.mean()) / partition.gray_span if along.size else 0.0,
            weak / max(usual, _TINY),
            float(np.percentile(deep, _STRONG_PERCENTILE)) / max(usual, _TINY) if deep.size else 1.0,
            float(values[mask].std()) / partition.gray_span,
            candidate.bounded,
            candidate.unambiguous,
            has_neck(region, solidity),
        )


def _count_border_pixels(mask: Mask, window: Window, shape: Extent) -> int:
    """Count the pixels of a mask in a window that lie on the border of an image of this shape."""
    on = np.zeros_like(mask)
    for axis, (side, n) in enumerate(zip(window, shape, strict=True)):
        lines = np.moveaxis(on, axis, 0)
        lines[0] |= side.start == 0
        lines[-1] |= side.stop == n
    return int(np.count_nonzero(on & mask))
