"""An image with the contours found in it, and the selection of objects by points, scribbles, boxes and lassos.

Where particles have closed a contour unambiguously, its inside is the object (`boundaries.closed_regions`). Elsewhere a
network answers that has learned from outlined images (`uses_network`).
"""

from __future__ import annotations

import itertools
import threading
from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import cached_property

import numpy as np
import scipy
import skimage
from numpy.typing import ArrayLike

from cpm_core.contours.contour import Contour
from cpm_core.field.edge_map import edge_map
from cpm_core.field.start_area.drawn_area import MIN_DRAWN_PLACES, close_line, drawn_area, is_closed_line, is_line
from cpm_core.field.start_area.start_area import object_enclosed_by
from cpm_core.image import drawing
from cpm_core.image.image import Image, as_plane
from cpm_core.image.region import Region
from cpm_core.image.regions import Regions
from cpm_core.image.volume_regions import AnyRegions, plane_regions
from cpm_core.numerics import polyline
from cpm_core.numerics.grids import (
    Window,
    bounding_window,
    expand_window,
    first_pixel,
    label_parts,
    measure_depth,
    nearest_pixels,
    running_maximum,
)
from cpm_core.numerics.parallel import map_in_parallel
from cpm_core.numerics.real_numbers import as_positions
from cpm_core.numerics.types import NO_PIXELS, NO_POINTS, Array, Arrays, Extent, Index, Mask, frozen, record
from cpm_core.objects.boundaries.boundary_guides import BoundaryGuides, build_boundary_guides
from cpm_core.objects.boundaries.closed_regions import ClosedRegions
from cpm_core.objects.boundaries.crossings import find_crossings
from cpm_core.objects.boundaries.necks import split_at_necks
from cpm_core.objects.boundaries.similar_pixels import find_similar_pixels
from cpm_core.objects.boundaries.snapping import snap_to_contours
from cpm_core.objects.confidence import ConfidenceFeatures, estimate_confidence
from cpm_core.objects.merged_basins import MergedBasins
from cpm_core.objects.outline import OBJECT_SMOOTHING, ObjectOutline, compute_outlines
from cpm_core.objects.prior.crops import measure_image_grays
from cpm_core.objects.prior.larger_models import check_model, model_title
from cpm_core.objects.prior.model_predictor import ModelPredictor
from cpm_core.objects.prior.object_predictor import (
    ObjectPredictor,
    Prediction,
    Predictor,
    Prompt,
    put_surroundings_last,
)
from cpm_core.objects.selection import (
    CONFLICTING_POINT_REMARK,
    EXCLUDED_POINT_REMARK,
    LEAST_CONFIDENCE,
    UNLIKELY_REMARK,
    Candidate,
    Selection,
    find_newer_points,
    is_among,
    keep_last_marks,
    remark_on_doubt,
)
from cpm_core.objects.vessels import find_thin_object
from cpm_core.objects.volume_partition import FoundInImage, VolumePartition, require_image
from cpm_core.parameters.formatting import format_count, format_repr, format_size, quote_value

_OUTLINE_MARGIN = 10
"""Margin around an object that its outline depends on: twice the reach of its edge map [px]."""

_DUPLICATE_IOU = 0.85
"""Overlap (intersection over union) from which two candidates are the same."""

_MAX_CANDIDATES = 8
"""Largest number of candidates."""

_MAX_CLOSED_CANDIDATES = 3
"""Largest number of candidates that closed contours enclose."""

_MAX_BASIN_CANDIDATES = 2
"""Largest number of candidates that are merged basins."""

_BASIN_REACH = 256
"""How far around points basins are looked for, if the points are at most twice as far apart [px]."""

_MAX_BASIN_SHARE = 0.6
"""Largest share of that part of the image that such a candidate covers."""

_CERTAINTY_WEIGHT = 2.0
"""How much the certainty of a correction counts, in how near its middle the points are.

For 559 further clicks in objects of 36 kinds that people outlined, up to twice as much made hardly any difference.
"""

_MIN_GROWTH = 1.2
"""Least area of an object joined with others across its necks, in areas of the object alone."""

_MAX_GROWTH = 8.0
"""Largest such area."""

_MIN_GRAY_SPAN = 1e-6
"""Least difference between white and black."""

_NEIGHBOR_REACH = 1.0
"""How far around an object such others are looked for, in lengths of the object."""

_MIN_PART_AREA = 5
"""Least area of a part of an object that limits have cut off from the rest [px²]."""

_MIDDLE_DEPTH = 0.5
"""Depth of a negative point in a part of an object from which it means the whole part, in depths of its middle.

Of 110 corrections that a robot made with the outline in mind, 3 were as deep in a part without a positive point.
"""

_MIN_DRAWN_SHARE = 0.1
"""Least share of what has been drawn that lies in a body that the prompt means."""

_NO_OBJECT_REMARK = "No object was found around these points: only their own pixels are selected."
"""Remark on a selection that holds only the pixels of its points."""

_LINE_CONFIDENCE = 0.02
"""Confidence below which a line that the points lie in precedes an answer, as it is right more often."""

_MIN_LINE_SHARE = 0.5
"""Least area of such a line, in areas of the answer: a smaller one is a detail of it, as the rim of a bone."""


@record
class _Request:
    """What a user has given to select an object by.

    Attributes
    ----------
    inside, outside : ndarray, shape (M, 2) and (K, 2)
        Positive and negative points [px].
    start : ndarray, shape (N, 2)
        The positive points, as a closed line if they are one whose ends nearly meet [px].
    free : ndarray of bool, shape (H, W)
        Pixels that may be selected.
    previous : Selection or None
        The selection before the last points were added.
    has_only_positive : bool
        Whether there are positive points alone: no negative ones, scribble, box or previous mask.
    prompt : Prompt
        All this for the network, which may then answer with any object.
    correction : Prompt or None
        The previous mask with the points that may contradict it. They count one by one, also where they are drawn.
    remark : str
        One sentence on what is unusual about the points, or empty.
    """

    inside: Array
    outside: Array
    start: Array
    free: Mask
    previous: Selection | None
    has_only_positive: bool
    prompt: Prompt
    correction: Prompt | None
    remark: str

    @property
    def is_empty(self) -> bool:
        """Whether nothing says where the object is."""
        asked = self.correction or self.prompt
        return not len(asked.positive) and asked.drawn_area is None and asked.box is None


@frozen
class ParentImage:
    """An image too large for a partition of its own, in which the image of a partition is a part.

    Attributes
    ----------
    shape : tuple of int
        Its shape.
    corner : tuple of int
        The first pixel of the part.
    gray_range : tuple of float
        Its gray levels that become 0 and 255 for the network.
    smoothing : float
        Sigma of the edge map by which closed contours are judged unambiguous or not [px].
    """

    shape: Extent
    corner: Extent
    gray_range: tuple[float, ...]
    smoothing: float


def partition_without_run(
    image: Image, regions: AnyRegions | None = None, channel: str = "luminance", model: str = ""
) -> Partition | VolumePartition:
    """Prepare an image or a volume without a run, so that the network or a model answers all prompts."""
    check_model(model, image.ndim)
    if image.ndim == 3:
        return VolumePartition(image, regions=regions, model=model)
    return Partition(image, (), plane_regions(regions), channel, model=model)


@record
class Partition(drawing.Pictured):
    """An image with its contours, to select objects from.

    Attributes
    ----------
    image : Image
        The image.
    contours : tuple of Contour
        Closed ones are objects where they are unambiguous; outlines follow all contours next to them.
    regions : Regions or None
        Outside the regions of interest nothing is selected; barriers are boundaries.
    channel : str
        Channel of a color image whose edges count; with the luminance, the network sees the colors.
    uses_network : bool
        Whether the network answers where no contour is unambiguous.
    parent : ParentImage or None
        The larger image that contains this one.
    links : tuple of ndarray, each of shape (K, 2)
        Pieces that are no contours but separate what contours enclose; see `Result.links`.
    model : str
        The larger model that answers in place of the network, one of `cpm.MODELS` or the folder of one; empty for the
        network, which also rates what was found otherwise.

    Examples
    --------
    >>> partition = cpm.partition(cpm.example("disks"))
    >>> cpm.Partition.from_result(cpm.segment(partition.image, cpm.circle((32, 18), 5)))
    <Partition disks, 64 x 64 px, 2 contours>
    >>> partition.shape, partition.values.shape, bool(partition.interest.all()), round(partition.gray_span)
    ((64, 64), (64, 64), True, 200)
    >>> len(list(partition.find_unambiguous_objects()))
    2
    >>> chosen = partition.select([(32, 18)], outside=[(32, 46)])
    >>> again = partition.build_selection(chosen.mask, chosen.inside)
    >>> int(chosen.mask.sum()), bool((again.mask == chosen.mask).all())
    (301, True)
    >>> any(one.has_same_region(chosen) for one in partition.find_candidates([(32, 18)]))
    True
    >>> bool(partition.evaluate_mask(chosen.mask).predicted_iou > 0.8)
    True
    >>> bool(next(partition.predict_near(np.array([32, 18]), np.s_[20:44, 6:30])).mask[32, 18])
    True
    >>> len(partition.outline_mask(chosen.mask))
    1
    >>> partition.complete_object(chosen.mask, 301.0).shape
    (64, 64)
    >>> int(partition.remove_pixels(chosen, np.indices((64, 64))[0] > 32).mask.sum())
    160
    >>> axes = partition.plot()
    """

    image: Image
    contours: tuple[Contour, ...]
    regions: Regions | None = None
    channel: str = "luminance"
    uses_network: bool = True
    parent: ParentImage | None = None
    links: Arrays = ()
    model: str = ""

    @classmethod
    def from_result(cls, result: FoundInImage, model: str = "") -> Partition:
        """Make the partition of the image and the contours of a result; ValueError when it does not know its image."""
        return cls(
            as_plane(require_image(result)),
            tuple(result.contours),
            plane_regions(result.regions),
            result.channel,
            links=result.links,
            model=model,
        )

    @property
    def shape(self) -> Extent:
        """Shape of the image."""
        return self.image.shape

    def select(
        self,
        inside: ArrayLike = (),
        outside: ArrayLike = (),
        *,
        stroke: ArrayLike = (),
        box: ArrayLike = (),
        previous: Selection | None = None,
        excluded: Mask | None = None,
    ) -> Selection:
        """Select the object that positive points lie in, and negative ones do not.

        Parameters
        ----------
        inside, outside : array_like, shape (M, 2) and (K, 2)
            Positive and negative points (row, col) [px]. A point outside the image is moved to the nearest pixel. The
            first positive points may be a line in the object, or around it if its ends nearly meet, as of a circle.
        stroke : array_like, shape (N, 2)
            A scribble: a line that lies in the object, or one around it whose ends nearly meet.
        box : array_like, shape (2, 2)
            Two opposite corners of a box around the object; its sides may be a few pixels off.
        previous : Selection, optional
            The selection before the last points were added. A new positive point only adds to it, and a negative one
            only removes; in the middle of a part between necks, it removes the whole part, also where earlier points
            were positive. Points that change none of its pixels leave it as it is, with its confidence.
        excluded : ndarray of bool, shape (H, W), optional
            Pixels that are not selected, such as those of other objects.

        Returns
        -------
        Selection
            The object; empty without a positive point.

        Raises
        ------
        ValueError
            When points are not rows and columns, the box does not have two corners, or the excluded pixels are not
            those of the image.
        """
        request = self._read_request(inside, outside, stroke, box, previous, excluded)
        return self._outline_candidate(next(self._rank_candidates(request)), request)

    def find_candidates(
        self,
        inside: ArrayLike = (),
        outside: ArrayLike = (),
        *,
        stroke: ArrayLike = (),
        box: ArrayLike = (),
        previous: Selection | None = None,
        excluded: Mask | None = None,
    ) -> tuple[Selection, ...]:
        """Find the different objects that a prompt may mean, from the smallest to the largest.

        One of them is the result of `select`, which has the same parameters. The others are predictions in crops of
        other sizes, the insides of contours closed around the points, shape (M, 2) [px], bodies alone where
        necks join them to others, and together with them, and what edges bound around the points.
        """
        request = self._read_request(inside, outside, stroke, box, previous, excluded)
        first, *others = (self._outline_candidate(one, request) for one in self._rank_candidates(request))
        others.sort(key=lambda one: -one.confidence)
        return tuple(sorted([first, *others[: _MAX_CANDIDATES - 1]], key=lambda one: one.size))

    def _rank_candidates(self, request: _Request) -> Iterator[Candidate]:
        """Find the different objects that a request may mean, first the likeliest one."""
        prompt, free = request.prompt, request.free
        is_first = request.correction is None and prompt.has_only_positive
        answers = iter(self._keep_candidates(prompt) if is_first else self._predict_candidates(prompt))
        best = self._from_closed_contour(request) or self._from_previous(request)
        if best is None:
            best = Candidate(Region()) if request.is_empty else self._keep_connected(
                next(answers, Candidate(Region())), prompt, free
            )  # fmt: skip
        yield best
        if request.is_empty:
            return
        known = [best.region]

        def keep_new(others: Iterable[Candidate]) -> Iterator[Candidate]:
            for other in others:
                found = self._keep_connected(other, prompt, free)
                if not found.region.is_empty and all(found.region.compute_iou(one) < _DUPLICATE_IOU for one in known):
                    known.append(found.region)
                    yield found

        yield from keep_new(itertools.chain(answers, self._find_alternatives(best.region.paste(self.shape), prompt)))
        if request.has_only_positive:
            yield from itertools.islice(keep_new(self._rank_basins_around(prompt.positive)), _MAX_BASIN_CANDIDATES)

    def _from_closed_contour(self, request: _Request) -> Candidate | None:
        """Return what an unambiguous contour encloses around positive points alone, or what is drawn around."""
        if not request.has_only_positive:
            return None
        mask = self._closed_regions.find_object_around(request.start)
        unambiguous = mask is not None
        if mask is None:  # perhaps the points are drawn around an object
            mask = object_enclosed_by(self.values, request.start, ~self.interest)
        if mask is None:
            return None
        if (mask & ~request.free).any():
            return self._keep_connected(Candidate(Region.from_mask(mask)), request.prompt, request.free)
        return Candidate(Region.from_mask(mask), unambiguous=unambiguous)

    def _from_previous(self, request: _Request) -> Candidate | None:
        """Return the previous mask, if any, corrected by the points that contradict it.

        Closed contours correct it where they are unambiguous, otherwise the network corrects all the rest.
        """
        prompt = request.correction
        if prompt is None or prompt.previous_mask is None:
            return None
        mask, corrected = prompt.previous_mask, False
        while True:
            wrong = [(place, not mask[tuple(place)]) for place in prompt.find_contradictions(mask)]
            if not wrong:
                found = Candidate(Region.from_mask(mask), unambiguous=corrected)
                return self._keep_connected(found, prompt, request.free)
            fixed = prompt.negative, prompt.positive
            changed = (self._closed_regions.correct_mask(mask, place, adds, fixed[not adds]) for place, adds in wrong)
            better = next((one for one in changed if one is not None), None)
            if better is not None:
                mask, corrected = better, True
                continue
            part = _find_part_meant(mask, prompt, request.previous)
            if part is None:
                return self._correct_by_network(replace(prompt, previous_mask=mask), mask, request.free)
            mask, corrected = mask & ~part, False
            prompt = replace(prompt, positive=prompt.positive[~part[tuple(prompt.positive.T)]])

    def _correct_by_network(self, prompt: Prompt, mask: Mask, free: Mask) -> Candidate:
        """Correct the previous mask of a prompt by the network; positive points only add, negative ones only remove.

        The object may also be another one of those that the network predicts for the first point: a user points at the
        middle of what is wrong.
        """
        before, wrong = Region.from_mask(mask), prompt.find_contradictions(mask)
        adds, removes = not mask[tuple(prompt.positive.T)].all(), mask[tuple(prompt.negative.T)].any()

        def limit_change(found: Candidate) -> Candidate:
            return found._replace(
                region=found.region.united(before) if adds else found.region.shared_with(before),
                features=found.features and found.features._replace(point_count=prompt.point_count),
            )

        found = next(self._predict_candidates(prompt), Candidate(before))
        if adds != removes:
            first = prompt.positive[mask[tuple(prompt.positive.T)]][:1]
            others = map(limit_change, self._keep_candidates(Prompt(first)) if len(first) else ())
            fitting = [one for one in others if not len(prompt.find_contradictions(one.region.paste(self.shape)))]
            found = max((limit_change(found), *fitting), key=lambda one: _rate_correction(one, mask, wrong))
        return self._keep_connected(found, prompt, free)

    def _keep_candidates(self, prompt: Prompt) -> _KeptCandidates:
        """Return the candidates for positive points alone; they are kept until those for others are.

        Further points need them again.
        """
        key = prompt.positive.tobytes()
        kept = self._kept_candidates.get(key)
        if kept is None:
            kept = _KeptCandidates(self._predict_candidates(prompt))
            self._kept_candidates.clear()
            self._kept_candidates[key] = kept
        return kept

    @cached_property
    def _kept_candidates(self) -> dict[bytes, _KeptCandidates]:
        return {}

    def _outline_candidate(self, found: Candidate, request: _Request) -> Selection:
        """Outline a candidate, with a remark if hardly anything says that it is an object.

        What has not changed stays the previous selection: another point that says the same makes it no more likely.
        Nor does a negative one that leaves nearly all of it.
        """
        inside, outside, remark, previous = request.inside, request.outside, request.remark, request.previous
        mask = found.region.paste(self.shape)
        if request.is_empty:
            return self.build_selection(mask, inside, outside, remark or "No point is marked as inside.")
        if previous is not None and np.array_equal(mask, previous.mask):
            known = previous.remark if previous.remark in (_NO_OBJECT_REMARK, UNLIKELY_REMARK) else ""
            return replace(previous, inside=inside, outside=outside, remark=remark or known)
        features = found.features
        if features is None and mask.any():
            features = self._measure_features(mask, inside, request.prompt.point_count)
        answer = self.build_selection(mask, inside, outside, remark, features, found.unambiguous)
        answer = replace(answer, model=found.model)
        if (
            previous is not None
            and answer.size < previous.size
            and answer.region.compute_iou(previous.region) >= _DUPLICATE_IOU
        ):
            answer = replace(answer, confidence=min(answer.confidence, previous.confidence))
        if not remark and answer.has_only_points:
            return replace(answer, remark=_NO_OBJECT_REMARK)
        return remark_on_doubt(answer)

    def _read_request(
        self,
        inside: ArrayLike,
        outside: ArrayLike,
        stroke: ArrayLike,
        box: ArrayLike,
        previous: Selection | None,
        excluded: Mask | None,
    ) -> _Request:
        """Read what a user has given; ValueError when it cannot be used."""
        within, beyond, line, corners = (as_positions(given, 2) for given in (inside, outside, stroke, box))
        if len(corners) not in (0, 2):
            raise ValueError(f"the box has {len(corners)} corners: give two opposite ones.")
        if previous is not None and not isinstance(previous, Selection):
            raise ValueError(f"previous is {quote_value(previous)} but must be a selection.")
        if len(line) > 1:  # what it means depends on its shape alone, not on its vertices
            line = polyline.sample_path(line, 1.0)
        if is_closed_line(line):  # around the object, not in it
            within, line = np.concatenate([close_line(line, self.shape), within]), NO_POINTS
        free = self.interest
        if excluded is not None:
            if excluded.shape != self.shape:
                raise ValueError(
                    f"the excluded pixels are {format_size(excluded.shape)} but the image is {format_size(self.shape)}."
                )
            free = free & ~excluded.astype(bool)
        meant = within if previous is None else _replace_surrounding_points(within, previous)
        places, remark = self._resolve_points(meant, beyond, free, previous)
        start = close_line(meant, self.shape)
        lasso = start if len(start) >= MIN_DRAWN_PLACES else NO_POINTS
        prompt = self._add_drawn_prompts(places, lasso, line, corners, free)
        mask = previous.mask if previous is not None and previous.has_boundary else None
        has_only_points = mask is None and not len(line) and not len(corners)
        if has_only_points and len(beyond):  # negative points correct what a contour encloses
            mask = self._closed_regions.find_object_around(within)
        correction = None
        if mask is not None:
            correction = replace(self._add_drawn_prompts(places, NO_POINTS, line, corners, free), previous_mask=mask)
        has_only_positive = has_only_points and not len(beyond)
        return _Request(within, beyond, start, free, previous, has_only_positive, prompt, correction, remark)

    def _add_drawn_prompts(self, places: Prompt, start: Array, line: Array, corners: Array, free: Mask) -> Prompt:
        """Add to a prompt a start, which replaces its positive points, a scribble and the corners of a box."""
        prompt = places
        if len(start):
            area = drawn_area(start, self.shape)
            if not is_line(area):  # which counts as points
                prompt = replace(prompt, drawn_area=area, positive=prompt.positive[:0])
        if len(line):
            along, _ = self._resolve_points(line, NO_POINTS, free)
            prompt = replace(prompt, positive=np.concatenate([prompt.positive, along.positive]))
        if len(corners):
            (top, left), (bottom, right) = corners.min(axis=0), corners.max(axis=0)
            prompt = replace(prompt, box=(top, bottom, left, right))
        return prompt

    def _resolve_points(
        self, inside: Array, outside: Array, free: Mask, previous: Selection | None = None
    ) -> tuple[Prompt, str]:
        """Resolve points to pixels, with one sentence on what is unusual about them.

        Points on pixels that are not `free`, shape (H, W), are left out. Where the same pixel is positive and negative,
        the last mark counts, which the `previous` selection tells.
        """
        remark = ""
        limit = np.array(self.shape) - 1
        every = np.concatenate([inside, outside])
        within, beyond = (nearest_pixels(places, self.shape) for places in (inside, outside))
        pixels = np.concatenate([within, beyond])
        if ((every < -0.5) | (every > limit + 0.5)).any():
            remark = "A point outside the image counts as the nearest one in it."
        elif not self.interest[tuple(pixels.T)].all():
            remark = "A point outside the regions of interest is ignored."
        elif not free[tuple(pixels.T)].all():
            remark = EXCLUDED_POINT_REMARK
        within, beyond, contradicting = keep_last_marks(within, beyond, find_newer_points(inside, outside, previous))
        remark = CONFLICTING_POINT_REMARK if contradicting else remark
        return Prompt(*(pixels[free[tuple(pixels.T)]] for pixels in (within, beyond))), remark

    def _predict_candidates(self, prompt: Prompt, area: float | None = None) -> Iterator[Candidate]:
        """Predict the candidates for a prompt, the most likely one first.

        A tree of vessels precedes all others, and any other thin object those that the network holds for unlikely,
        unless it is a detail of them.
        Of an object whose `area` [px²] is known, the candidates of similar size come first.
        """
        if not self.uses_network:
            return
        thin = find_thin_object(self.values, prompt.positive) if prompt.has_only_positive else None
        if thin is not None and thin.is_tree:
            yield Candidate(Region.from_mask(thin.mask))
            thin = None
        for likely in _put_likely_first(self._predictor.predict_objects(prompt, area), prompt):
            mask = likely.mask
            if likely.downsampling > 1.0 and self.contours:  # contours are more exact than a coarse prediction
                box, corner = _padded_box(mask)
                paths = self._find_contour_paths(box, corner)
                if paths:
                    mask[box] = snap_to_contours(mask[box], find_crossings(paths, mask[box].shape), likely.downsampling)
            features = ConfidenceFeatures(*likely[2:], point_count=prompt.point_count)
            is_unlikely = estimate_confidence(features) < _LINE_CONFIDENCE
            if thin is not None and is_unlikely and thin.mask.sum() >= _MIN_LINE_SHARE * mask.sum():
                yield Candidate(Region.from_mask(thin.mask))
                thin = None
            yield Candidate(Region.from_mask(mask), features, model=model_title(self.model))
        if thin is not None:
            yield Candidate(Region.from_mask(thin.mask))

    def _find_alternatives(self, mask: Mask, prompt: Prompt) -> Iterator[Candidate]:
        """Find alternatives to an object: closed contours around it, a body of it alone, or more than it."""
        pixels = prompt.positive if prompt.drawn_area is None else np.argwhere(prompt.drawn_area)
        if len(pixels):
            enclosed = self._closed_regions.find_enclosing_masks(pixels)
            for found in (*itertools.islice(enclosed, _MAX_CLOSED_CANDIDATES), _cut_body_at_necks(mask, pixels)):
                yield Candidate(Region.from_mask(found))
        if mask.any():
            joined = self._join_similar_pixels(mask)
            if _MIN_GROWTH < np.count_nonzero(joined) / np.count_nonzero(mask) < _MAX_GROWTH:
                yield Candidate(Region.from_mask(joined))

    def _rank_basins_around(self, pixels: Index) -> list[Candidate]:
        """Find the merged basins that hold some pixels, shape (N, 2), first those that the network changes least."""
        if not len(pixels) or not self.uses_network or np.ptp(pixels, axis=0).max() > 2 * _BASIN_REACH:
            return []
        low, high = pixels.min(axis=0).tolist(), (pixels.max(axis=0) + 1).tolist()
        window = expand_window(tuple(map(slice, low, high)), _BASIN_REACH, self.shape)
        corner, values = first_pixel(window), self.values[window]
        lines = find_crossings(self._find_contour_paths(window, corner), values.shape).pixels
        basins = MergedBasins.from_edges(edge_map(values, "auto"), running_maximum(lines, 1), self.gray_span)
        most = _MAX_BASIN_SHARE * values.size
        around = basins.find_regions_around(tuple(pixels[0] - corner))
        regions = (Region.from_mask(inside, first_pixel(box) + corner) for box, inside in around)
        held = [one for one in regions if one.size <= most and one.encloses(pixels.astype(float)).all()]
        seen = ((one, expand_window(one.window, 1, self.shape)) for one in held)
        whole = [  # not cut off where the part of the image ends
            one
            for one, near in seen
            if all(within.start <= at.start and at.stop <= within.stop for at, within in zip(near, window, strict=True))
        ]

        def evaluate(region: Region) -> tuple[float, Candidate]:
            answer = self.evaluate_mask(region.paste(self.shape), pixels)
            features = ConfidenceFeatures(*answer[2:5], point_count=len(pixels))  # no other crop has said the same
            return answer.mean_certainty * answer.iou_to_previous, Candidate(region, features)

        return [one for _, one in sorted(map_in_parallel(evaluate, whole), key=lambda each: -each[0])]

    def _join_similar_pixels(self, mask: Mask) -> Mask:
        """Join an object, shape (H, W), with the pixels connected to it that are similar."""
        box, _ = _padded_box(mask)
        lengths = [int(_NEIGHBOR_REACH * (side.stop - side.start)) for side in box]
        wide = tuple(
            slice(max(side.start - length, 0), side.stop + length) for side, length in zip(box, lengths, strict=True)
        )
        similar = find_similar_pixels(self.values[wide], mask[wide], self.interest[wide])
        joined = np.zeros_like(mask)
        joined[wide] = _select_connected(similar, np.argwhere(mask[wide]))
        return joined

    def _keep_connected(self, candidate: Candidate, prompt: Prompt, free: Mask) -> Candidate:
        """Keep the free parts that are connected to the prompt, with all positive points and no negative one."""
        mask = candidate.region.paste(self.shape) & free
        mask[tuple(prompt.positive.T)] = True
        mask[tuple(prompt.negative.T)] = False
        box, corner = _padded_box(mask)
        part = mask[box]
        held = [prompt.positive - corner]
        if prompt.drawn_area is not None:
            held.append(np.argwhere(prompt.drawn_area[box] & part))
        if prompt.box is not None:
            held.append(np.argwhere(part))
        part = _select_connected(
            part, np.concatenate(held), find_crossings(self._find_barrier_paths(corner), part.shape).pixels
        )
        # what is drawn may hold specks
        mask[box] = drop_fragments(part, ~free[box] if len(prompt.positive) else np.ones_like(part))
        return candidate._replace(region=Region.from_mask(mask))

    def complete_object(self, drawn: Mask, area: float, outside: Index = NO_PIXELS) -> Mask:
        """Complete drawn pixels to an object of about this area [px²] without pixels, shape (K, 2), outside it.

        The masks have shape (H, W).
        """
        prompt = Prompt(NO_PIXELS, outside, drawn)
        found = next(self._predict_candidates(prompt, area), Candidate(Region()))
        return self._keep_connected(found, prompt, self.interest).region.paste(self.shape)

    def find_unambiguous_objects(self) -> Iterator[Mask]:
        """Find the objects that closed contours enclose unambiguously, each of shape (H, W), the largest first."""
        return self._closed_regions.find_objects()

    def build_selection(
        self,
        mask: Mask,
        inside: Array = NO_POINTS,
        outside: Array = NO_POINTS,
        remark: str = "",
        features: ConfidenceFeatures | None = None,
        unambiguous: bool = False,
    ) -> Selection:
        """Build the selection of a set of pixels, shape (H, W), whose boundary follows contours next to it.

        `inside` and `outside` are points, shape (M, 2) and (K, 2) [px]. Without features, the network is asked for
        them.
        """
        if not mask.any():
            return Selection(Region(), self.shape, inside, outside, confidence=0.0, remark=remark, image=self.image)
        found = self.outline_mask(mask)
        if features is None:
            features = self._measure_features(mask, inside, len(inside) + len(outside))
        features = features._replace(unambiguous=unambiguous)
        contours = tuple(outline.contour for outline in found)
        gaps = tuple(gap for outline in found for gap in outline.gaps)
        confidence = estimate_confidence(features)
        return Selection(
            Region.from_mask(mask), self.shape, inside, outside, contours, gaps, confidence, remark, features,
            image=self.image,
        )  # fmt: skip

    def _measure_features(self, mask: Mask, inside: Array, point_count: int) -> ConfidenceFeatures:
        """Measure what the confidence of a set of pixels, shape (H, W), with points in it is estimated from."""
        if not self.uses_network:
            return ConfidenceFeatures(point_count=point_count)
        return ConfidenceFeatures(*self.evaluate_mask(mask, inside)[2:], point_count=point_count)

    def remove_pixels(self, selection: Selection, excluded: Mask) -> Selection:
        """Remove pixels from a selection, masks of shape (H, W), and what they cut off from its positive points.

        The rest is as likely an object as the whole was.
        """
        if not (selection.mask & excluded).any():
            return selection
        prompt, _ = self._resolve_points(selection.inside, NO_POINTS, self.interest & ~excluded)
        mask = selection.mask & ~excluded
        if len(prompt.positive):
            mask = _select_connected(mask, prompt.positive)
        mask = drop_fragments(mask, excluded)
        left = self.build_selection(mask, selection.inside, selection.outside, selection.remark, selection.features)
        return replace(left, confidence=selection.confidence, model=selection.model) if left.has_boundary else left

    def outline_mask(self, mask: Mask) -> tuple[ObjectOutline, ...]:
        """Outline a set of pixels, shape (H, W), along the contours next to it."""
        box, corner = _padded_box(mask)
        found = compute_outlines(mask[box], self._build_guides(box, corner))
        return tuple(replace(one, contour=replace(one.contour, points=one.contour.points + corner)) for one in found)

    def predict_near(self, pixel: Index, window: Window) -> Iterator[Prediction]:
        """Predict by the network what a pixel may mean, in a crop around a window, without what the crop cuts."""
        return self._network.predict_near(pixel, window)

    def evaluate_mask(self, mask: Mask, inside: ArrayLike = NO_POINTS) -> Prediction:
        """Evaluate an object, shape (H, W), found otherwise, by the network, with points in it, shape (M, 2)."""
        pixels = nearest_pixels(inside, mask.shape)
        pixels = pixels[mask[tuple(pixels.T)]]
        if not len(pixels) or len(pixels) >= MIN_DRAWN_PLACES:
            box, corner = _padded_box(mask)
            depth = scipy.ndimage.distance_transform_edt(mask[box])
            pixels = np.argwhere(depth == depth.max())[:1] + corner
        return self._network.evaluate_mask(mask, pixels)

    @cached_property
    def values(self) -> Array:
        """Gray levels that boundaries are judged by, shape (H, W)."""
        return self.image.gray_levels(self.channel)

    @cached_property
    def gray_span(self) -> float:
        """Difference of the gray levels that are black and white for the network."""
        low, high = measure_image_grays(self.values) if self.parent is None else self.parent.gray_range
        return max(high - low, _MIN_GRAY_SPAN)

    @cached_property
    def interest(self) -> Mask:
        """Pixels in the regions of interest, shape (H, W)."""
        return (self.regions or Regions()).pixel_mask(self.shape)

    def _build_guides(self, box: Window, corner: Index) -> BoundaryGuides:
        """Build what outlines follow in a part of the image."""
        values, regions = self.values[box], self.regions or Regions()
        return build_boundary_guides(
            values,
            edge_map(values, OBJECT_SMOOTHING),
            self._find_contour_paths(box, corner),
            self._find_barrier_paths(corner),
            list(regions.rim_segments().reshape(-1, 2, 2) - corner),
            self.interest[box],
        )

    def _find_contour_paths(self, box: Window, corner: Index) -> list[Array]:
        """Find the paths of contours in a part of the image, relative to its first pixel."""
        last = [part.stop for part in box]
        near = (one for one in self.contours if (one.box[1] >= corner).all() and (one.box[0] <= last).all())
        return [contour.path - corner for contour in near]

    def _find_barrier_paths(self, corner: Index) -> list[Array]:
        """Find the paths of barriers, relative to a pixel."""
        return [np.array(line) - corner for line in self.regions.barriers] if self.regions is not None else []

    @cached_property
    def _closed_regions(self) -> ClosedRegions:
        free = self.regions is None or not (self.regions.interest or self.regions.barriers)
        contours = self.contours if free else ()
        return ClosedRegions(contours, self.values, "auto" if self.parent is None else self.parent.smoothing)

    @cached_property
    def _network(self) -> ObjectPredictor:
        colors = self.image.colors if self.channel == "luminance" else None
        grays = () if self.parent is None else self.parent.gray_range
        return ObjectPredictor(self.values if colors is None else colors.samples, gray_range=grays)

    @cached_property
    def _predictor(self) -> Predictor:
        """What answers prompts."""
        seen = self._network
        return ModelPredictor(seen.values, self.model, seen.gray_range) if self.model else seen

    def __repr__(self) -> str:
        return format_repr(
            "Partition", self.image.source, format_size(self.shape), format_count(len(self.contours), "contour")
        )

    def plot(self, ax: drawing.Axes | None = None) -> drawing.Axes:
        """Draw the image with the contours by matplotlib."""
        return drawing.draw_curves_on_image(ax, self.image.values, self.contours, self.image.spacing)


def _padded_box(mask: Mask) -> tuple[Window, Index]:
    """Return the rows and columns of the true pixels of a mask with a margin, and the first of them."""
    found = bounding_window(mask) if mask.any() else (slice(0, 1),) * 2
    box = expand_window(found, _OUTLINE_MARGIN, mask.shape)
    return box, first_pixel(box)


def _select_connected(mask: Mask, pixels: Index, barred: Mask | None = None) -> Mask:
    """Select the parts of a mask, shape (H, W), that hold pixels, shape (N, 2), up to barriers."""
    parts, _ = label_parts(mask if barred is None else mask & ~barred)
    if barred is not None and barred.any():
        parts = np.where(mask, skimage.segmentation.expand_labels(parts, 2.0), 0)  # type: ignore[no-untyped-call]
    held = np.zeros(int(parts.max()) + 1, bool)
    held[parts[tuple(pixels.T)]] = True
    held[0] = False
    return held[parts]


def drop_fragments(mask: Mask, cut: Mask) -> Mask:
    """Drop small parts of a mask next to pixels cut from it, both of shape (H, W), where there are larger parts."""
    if not cut.any():
        return mask
    parts, count = scipy.ndimage.label(mask)
    large = np.bincount(parts.ravel(), minlength=count + 1) >= _MIN_PART_AREA
    if not large[1:].any():
        return mask
    beside_cut = np.zeros(count + 1, bool)
    beside_cut[parts[scipy.ndimage.binary_dilation(cut, np.ones((3, 3), bool))]] = True
    return mask & (large | ~beside_cut)[parts]


def _cut_body_at_necks(mask: Mask, pixels: Index) -> Mask:
    """Cut an object, shape (H, W), at its necks; keep the parts that hold enough of some pixels, shape (N, 2)."""
    box, corner = _padded_box(mask)
    parts = split_at_necks(mask[box])
    there = np.clip(pixels - corner, 0, np.array(parts.shape) - 1)
    counts = np.bincount(parts[tuple(there.T)], minlength=int(parts.max()) + 1)
    held = counts >= max(_MIN_DRAWN_SHARE * len(pixels), 1.0)
    held[0] = False
    body = np.zeros_like(mask)
    body[box] = held[parts]
    return body


class _KeptCandidates:
    """Candidates that are predicted once, one after another, when they are first asked for; threads may share them."""

    def __init__(self, predicted: Iterator[Candidate]) -> None:
        self._predicted, self._known = predicted, list[Candidate]()
        self._lock = threading.Lock()

    def __iter__(self) -> Iterator[Candidate]:
        for at in itertools.count():
            with self._lock:
                if at == len(self._known):
                    self._known += itertools.islice(self._predicted, 1)
            if at == len(self._known):
                return
            yield self._known[at]


def _put_likely_first(answers: Iterator[Prediction], prompt: Prompt) -> Iterator[Prediction]:
    """Yield predictions in their order, or the surest first where the first of them may be no object.

    All are then refined before the first is yielded. Of 198 first clicks in objects of 44 kinds that people outlined,
    8 are answered otherwise, and overlap by 0.661 on average, by 0.653 without.
    """

    def confidence(found: Prediction) -> float:
        return estimate_confidence(ConfidenceFeatures(*found[2:], point_count=prompt.point_count))

    first = list(itertools.islice(answers, 1))
    if first and prompt.has_only_positive and confidence(first[0]) < LEAST_CONFIDENCE:
        yield from put_surroundings_last(sorted([*first, *answers], key=confidence, reverse=True), prompt)
    else:
        yield from itertools.chain(first, answers)


def _rate_correction(found: Candidate, previous: Mask, places: Index) -> float:
    """Rate a correction: how near the middle of what it changes the points, shape (N, 2), are, and its certainty.

    It is 0 for one that does not change the pixels of all points.
    """
    changed = found.region.paste(previous.shape) != previous
    if not changed[tuple(places.T)].all():
        return 0.0
    box, corner = _padded_box(changed)
    depth = measure_depth(changed[box])
    centrality = depth[tuple((places - corner).T)].mean() / depth.max()
    return float(centrality) + _CERTAINTY_WEIGHT * (found.features or ConfidenceFeatures()).mean_certainty


def _find_part_meant(mask: Mask, prompt: Prompt, previous: Selection | None) -> Mask | None:
    """Find the part of an object, shape (H, W), between its necks that a negative point in its middle means as a whole.

    None if it is all of the object, or holds positive points that are not among those of the selection before.
    """
    surplus = prompt.negative[mask[tuple(prompt.negative.T)]]
    if not len(surplus):
        return None
    box, corner = _padded_box(mask)
    parts = split_at_necks(mask[box])
    islands, _ = label_parts(mask[box] & (parts == 0), corners=False)  # too small for a body
    parts = np.where(islands > 0, islands + parts.max(), parts)
    known = prompt.positive[:0] if previous is None else nearest_pixels(previous.inside, mask.shape)
    for pixel in surplus - corner:
        part = parts == parts[tuple(pixel)]
        depth = scipy.ndimage.distance_transform_edt(np.pad(part, 1, mode="edge"))[1:-1, 1:-1]
        within = np.zeros_like(mask)
        within[box] = part
        held = within[tuple(prompt.positive.T)]
        if (
            depth[tuple(pixel)] >= _MIDDLE_DEPTH * depth.max()
            and not held.all()
            and is_among(prompt.positive[held], known).all()
        ):
            return within
    return None


def _replace_surrounding_points(inside: Array, before: Selection) -> Array:
    """Drop points around the object selected before; add the middle of each of its parts without a point."""
    around = before.inside[~before.contains(before.inside)]
    if not len(around) or not before.has_boundary:
        return inside
    rest = inside[~is_among(inside, around)]
    parts, count = label_parts(np.pad(before.mask, 1))
    place = nearest_pixels(rest[before.contains(rest)], before.shape) + 1
    empty = np.setdiff1d(np.arange(1, count + 1), parts[tuple(place.T)])
    depth = scipy.ndimage.distance_transform_edt(parts > 0)
    middles = np.array(scipy.ndimage.maximum_position(depth, parts, empty), float).reshape(-1, 2) - 1.0
    return np.concatenate([middles, rest])
