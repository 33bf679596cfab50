"""What the image and the network say for and against a region being an object."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np
import scipy
import skimage

from cpm_core.image.region import Region
from cpm_core.numerics.grids import Window, expand_window, find_largest_part, first_pixel, label_parts
from cpm_core.numerics.types import Extent, Mask, record
from cpm_core.objects.candidate_regions import has_neck, is_part_of, measure_solidity
from cpm_core.objects.confidence import ConfidenceFeatures, RegionFeatures
from cpm_core.objects.image_parts import ImageParts
from cpm_core.objects.merged_basins import MIN_OBJECT_AREA
from cpm_core.objects.partition import Partition
from cpm_core.objects.selection import Candidate

_MARGIN = 5
"""Margin around the box of a region in which it is measured [px]."""

_INNER_DEPTH = 3.5
"""Depth from which edges are those of the inside, not of the boundary [px]."""

_EDGE_PERCENTILE = 65.0
"""Percentile of the edge strength in a region above which edges part it."""

_MIN_TOP_HEIGHT = 0.75
"""How much deeper a place between edges is than the way to the next [px]."""

_MAX_PLACES = 24
"""Largest number of places at which the parts of a region are predicted."""

_MAX_CROP_SHARE = 0.75
"""Largest side of a crop in which a part is predicted, as a fraction of the side of the region."""

_SAME_PART_IOU = 0.8
"""Overlap (intersection over union) from which two parts are the same."""

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

    def predict_parts(self, clump: Candidate) -> Iterator[Candidate]:
        """Predict by the network, in crops around places between edges, the parts of what may be several objects."""
        whole = clump.region
        window = expand_window(whole.window, 1, self.partition.shape)
        mask, strength = whole.cut_out(window), self.parts.edge_strength[window]
        edges = strength > np.percentile(strength[mask], _EDGE_PERCENTILE)
        depth = scipy.ndimage.gaussian_filter(scipy.ndimage.distance_transform_edt(mask & ~edges), 1.0)
        tops = skimage.morphology.h_maxima(depth, _MIN_TOP_HEIGHT) > 0  # type: ignore[no-untyped-call]
        tops, count = label_parts(tops)
        places = np.array(scipy.ndimage.maximum_position(depth, tops, range(1, count + 1)), np.int64).reshape(-1, 2)
        deepest = places[np.argsort(-depth[tuple(places.T)], kind="stable")][:_MAX_PLACES]
        largest = _MAX_CROP_SHARE * max(mask.shape)
        found = []
        for pixel in deepest + first_pixel(window):
            for answer in self.partition.predict_at_scales(pixel, largest):
                inside = answer.mask & self.partition.interest
                if inside[tuple(pixel)]:
                    labels, _ = scipy.ndimage.label(inside)
                    part = Region.from_mask(labels == labels[tuple(pixel)]).filled
                    if is_part_of(part, whole) and part.size >= MIN_OBJECT_AREA:
                        found.append((answer.predicted_iou * answer.mean_certainty, part))
        known: list[Region] = []
        for _, part in sorted(found, key=lambda one: -one[0]):
            if all(part.compute_iou(one) < _SAME_PART_IOU for one in known):
                known.append(part)
                yield from self.predict_candidates(Candidate(part))

    def measure_candidates(self, candidates: Sequence[Candidate]) -> list[RegionFeatures]:
        """Measure what the confidence of each candidate is estimated from, among all candidates of the image."""
        best = np.zeros(self.partition.shape)
        for one in candidates:
            there = best[one.region.window]
            np.maximum(there, np.where(one.region.mask, one.likelihood, 0.0), out=there)
        for one in candidates:
            if one not in self._measured:
                self._measured[one] = self._measure_region(one)
        return [
            self._measured[one]._replace(
                rivalry=float(best[one.region.window][one.region.mask].mean()) - one.likelihood
            )
            for one in candidates
        ]

    @cached_property
    def _measured(self) -> dict[Candidate, RegionFeatures]:
        """What was measured of candidates, except for their rivalry."""
        return {}

    def _measure_region(self, candidate: Candidate) -> RegionFeatures:
        """Measure a candidate, except for its rivalry."""
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
            0.0,
            region.size,
            solidity,
            border / (border + along.size),
            float(along.mean()) / partition.gray_span if along.size else 0.0,
            weak / max(usual, _TINY),
            float(np.percentile(deep, _STRONG_PERCENTILE)) / max(usual, _TINY) if deep.size else 1.0,
            float(values[mask].std()) / partition.gray_span,
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
