"""What the image and the network say for and against a region being an object."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
import scipy
import skimage

from cpm_core.image.region import Region
from cpm_core.numerics.grids import Window, expand_window, find_largest_part
from cpm_core.numerics.types import Extent, Mask, record
from cpm_core.objects.candidate_regions import has_neck
from cpm_core.objects.confidence import ConfidenceFeatures, RegionFeatures
from cpm_core.objects.image_parts import ImageParts
from cpm_core.objects.partition import Partition
from cpm_core.objects.selection import Candidate

_MARGIN = 5
"""Margin around the box of a region in which it is measured [px]."""

_INNER_DEPTH = 3.5
"""Depth from which edges are those of the inside, not of the boundary [px]."""

_NECK_SOLIDITY = 0.97
"""Solidity from which a region has no neck."""

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

    def predict_candidates(self, bounded: Candidate) -> Iterator[Candidate]:
        """Predict by the network how likely a region is, and, unless that is exact, what it would change it to."""
        region = bounded.region
        found = self.partition.evaluate_mask(region.paste(self.partition.shape))
        features = ConfidenceFeatures(*found[2:], point_count=0)
        likelihood = found.predicted_iou * found.iou_to_previous
        yield bounded._replace(features=features, likelihood=likelihood)
        if bounded.unambiguous:
            return
        mask = found.mask & self.partition.interest
        mask[region.window] &= ~(region.filled.mask & ~region.mask)
        if mask.any():
            changed, has_holes = Region.from_mask(find_largest_part(mask)), region.filled != region
            yield Candidate(changed if has_holes else changed.filled, features, likelihood=found.predicted_iou)

    def measure_candidates(self, candidates: Sequence[Candidate]) -> list[RegionFeatures]:
        """Measure what the confidence of each candidate is estimated from, among all candidates of the image."""
        best = np.zeros(self.partition.shape)
        for one in candidates:
            there = best[one.region.window]
            np.maximum(there, np.where(one.region.mask, one.likelihood, 0.0), out=there)
        return [
            self._measure_region(one, float(best[one.region.window][one.region.mask].mean()) - one.likelihood)
            for one in candidates
        ]

    def _measure_region(self, candidate: Candidate, rivalry: float) -> RegionFeatures:
        """Measure a candidate whose pixels others hold with a likelihood that is larger by `rivalry`."""
        region, partition = candidate.region, self.partition
        window = expand_window(region.window, _MARGIN, partition.shape)
        mask, values, strength = region.cut_out(window), partition.values[window], self.parts.edge_strength[window]
        inside = scipy.ndimage.distance_transform_edt(np.pad(mask, 1, mode="edge"))[1:-1, 1:-1]
        rim, deep = (inside > 0.0) & (inside <= 1.0), strength[inside > _INNER_DEPTH]
        border = _count_border_pixels(mask, window, partition.shape)
        along = scipy.ndimage.maximum_filter(strength, 3)[rim]
        usual, weak = np.percentile(along, [50.0, _WEAK_PERCENTILE]) if along.size else (0.0, 0.0)
        likely = candidate.features or ConfidenceFeatures(point_count=0)
        find_hull: Callable[[Mask], Mask] = skimage.morphology.convex_hull_image
        solidity = region.filled.size / np.count_nonzero(find_hull(region.mask))
        return RegionFeatures(
            likely.predicted_iou,
            likely.mean_certainty,
            likely.iou_to_previous,
            rivalry,
            region.size,
            solidity,
            border / (border + along.size),
            float(along.mean()) / self.parts.gray_span if along.size else 0.0,
            weak / max(usual, _TINY),
            float(np.percentile(deep, _STRONG_PERCENTILE)) / max(usual, _TINY) if deep.size else 1.0,
            float(values[mask].std()) / self.parts.gray_span,
            candidate.unambiguous,
            bool(solidity < _NECK_SOLIDITY) and has_neck(region),
        )


def _count_border_pixels(mask: Mask, window: Window, shape: Extent) -> int:
    """Count the pixels of a mask in a window that lie on the border of an image of this shape."""
    on = np.zeros_like(mask)
    for axis, (side, n) in enumerate(zip(window, shape, strict=True)):
        lines = np.moveaxis(on, axis, 0)
        lines[0] |= side.start == 0
        lines[-1] |= side.stop == n
    return int(np.count_nonzero(on & mask))
