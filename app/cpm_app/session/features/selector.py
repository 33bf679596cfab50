"""The partition of an image or a volume, kept up to date with the run, and selections by clicks on it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields, replace
from functools import cached_property, lru_cache
from typing import cast

import numpy as np
import scipy
from numpy.typing import ArrayLike
from PySide6.QtCore import QObject, QTimer, Signal

from cpm_app.model.document.document import Document, Mode
from cpm_app.model.document.modes import MODES
from cpm_app.model.document.objects import initial_clicks
from cpm_app.model.text.language import tr
from cpm_app.session.features.background import LatestOnlyWorker
from cpm_app.session.scene import Preview, Proposal
from cpm_app.session.session import Session
from cpm_app.session.tasks.tasks import ENDED_TASK, BackgroundTask
from cpm_core import (
    PRESETS,
    Image,
    Page,
    Parameters,
    Partition,
    Result,
    Selection,
    VolumePartition,
    partition,
    segment,
    uniform_grid,
)
from cpm_core.formats.stack_files import paint_tracks
from cpm_core.image import AnyRegions, plane_regions
from cpm_core.image.region import Region
from cpm_core.numerics.grids import expand_window, first_pixel
from cpm_core.numerics.polyline import as_line
from cpm_core.numerics.types import Array, Extent, JsonDict, Mask, frozen
from cpm_core.numerics.weak_cache import WeakCache
from cpm_core.objects import partition_without_run
from cpm_core.objects.boundaries.similar_pixels import measure_radius
from cpm_core.objects.segmented import (
    Click,
    SegmentedObject,
    collect_points,
    find_most_similar,
    keep_separate,
    selection_from_object,
    unite_regions,
)
from cpm_core.objects.segmented.segmented_object import Clicks
from cpm_core.results import find_objects
from cpm_core.segmentation.select import EVERYWHERE_PARAMETERS

_PARTITION_DELAY = 250
"""Time without a change of parameters or limits after which a run from everywhere is repeated [ms]."""


@frozen
class EverywhereRun:
    """Inputs of a run from everywhere."""

    image: Image
    parameters: Parameters
    regions: AnyRegions | None


AnyPartition = Partition | VolumePartition
"""Partition of an image or a volume, from which objects are selected."""

PartitionSource = Result | EverywhereRun
"""Input that a partition is made from."""

PreparedPartition = tuple[PartitionSource, AnyPartition]
"""Source of a partition, and the partition, ready to select from."""


class PartitionUpdater(QObject):
    """Makes partitions on other threads: from the contours of the run, or without one, from a run from everywhere.

    Until the latter ends, a partition without contours is used. `is_needed` returns whether a partition is needed now;
    call `update_partition` whenever its answer may have changed.
    """

    changed = Signal()
    """`partition` or `preparing` has changed."""

    def __init__(self, session: Session, is_needed: Callable[[], bool]) -> None:
        super().__init__(session)
        self.partition: AnyPartition | None = None
        self._session = session
        self._is_needed = is_needed
        self.source: PartitionSource | None = None
        """Source of `partition`."""
        self._asked_for: PartitionSource | None = None
        self.has_failed = False
        """Whether the partition that was asked for last could not be made."""
        self._everywhere: PreparedPartition | None = None
        self._models = {2: "", 3: ""}
        self._task = ENDED_TASK
        self._latest = LatestOnlyWorker(session, "cpm-partition", tr("preparing the selection of objects"))
        self._quiet = QTimer(self, singleShot=True, interval=_PARTITION_DELAY)
        self._quiet.timeout.connect(self.update_partition)
        session.image_changed.connect(self._on_image_changed)
        session.store.scene_changed.connect(self.update_partition)
        session.document_changed.connect(self._on_document_changed)

    @property
    def preparing(self) -> bool:
        """Whether a run from everywhere is going on."""
        return not self._task.is_over

    @property
    def is_current(self) -> bool:
        """Whether the partition is that of what the scene shows."""
        return self.source is not None and self.source == self._current_source()

    def update_partition(self, again: bool = False) -> None:
        """Start to make the partition that is needed now if its source is new; `again` even if it has failed before."""
        if again and self._latest.idle and not self.preparing:
            self._asked_for = self.source
        source, known = self._current_source(), self._everywhere
        if source is None or self._quiet.isActive() or not self._is_needed():
            return
        if known is not None and source == known[0]:
            self._asked_for = source
            if source != self.source:
                self._set_partition(known)
        elif source != self._asked_for:
            self._asked_for, self.has_failed = source, False
            self._task.cancel()
            if isinstance(source, EverywhereRun):
                alone = source.image.ndim == 3 or math.prod(source.image.shape) > MAX_OFFERED_PIXELS
                if self.partition is None or alone:  # usable at once; contours follow
                    model = self._models[source.image.ndim]
                    bare = partition_without_run(source.image, source.regions, source.parameters.channel, model)
                    self._set_partition((source, bare))
                if not alone:
                    self._start_run_everywhere(source)
            else:
                model = self._models[2 if source.surface is None else 3]
                self._latest.submit(
                    lambda: (source, _precompute_selection(partition(source, model=model))),
                    self._on_partition_made,
                    self._on_failure,
                )

    def find_prepared(self, source: PartitionSource) -> AnyPartition | None:
        """Find the partition made from a source with its contours, without a larger model; None if it is not known."""
        known = self._everywhere if isinstance(source, EverywhereRun) else (self.source, self.partition)
        made = known[1] if known is not None and known[0] == source else None
        return None if made is None or made.model else made

    def set_model(self, model: str, ndim: int) -> None:
        """Set the larger model that answers in images (2), or the server in volumes (3); empty for the network."""
        if model != self._models[ndim]:
            self._models[ndim] = model
            self._on_image_changed()
            self.update_partition()

    def _current_source(self) -> PartitionSource | None:
        scene = self._session.scene
        if scene.image is None:
            return None
        found = scene.reconstruction.result if scene.reconstruction is not None else None
        if isinstance(found, Result) and found.image is not None and (found.contours or found.surface is not None):
            return found
        return EverywhereRun(scene.image, parameters_everywhere(scene.document), scene.document.regions)

    def _start_run_everywhere(self, source: EverywhereRun) -> None:
        model = self._models[2]

        def run_everywhere(task: BackgroundTask) -> PreparedPartition:
            return source, _precompute_selection(partition_from_everywhere(source, task, model))

        name = tr("Finding contours everywhere, to outline objects exactly…")
        activity = tr("preparing the selection of objects")
        self._task = self._session.tasks.start_task(name, run_everywhere, activity, on_result=self._on_partition_made)
        self.changed.emit()

    def _on_partition_made(self, prepared: PreparedPartition) -> None:
        source, made = prepared
        if made.image is not self._session.image:
            return
        if isinstance(source, EverywhereRun):
            self._everywhere = prepared
            if source != self._asked_for:
                return
        elif not isinstance(self._current_source(), Result):
            return  # the run has been reset
        self._set_partition(prepared)

    def _set_partition(self, prepared: PreparedPartition) -> None:
        self.source, self.partition = prepared
        self.changed.emit()
        self.update_partition()

    def _on_failure(self) -> None:
        self.has_failed = True
        self.changed.emit()

    def _on_document_changed(self, document: Document) -> None:
        """Wait until parameters and limits stop changing before another run from everywhere."""
        source, before = self._current_source(), self._asked_for
        if isinstance(source, EverywhereRun) and isinstance(before, EverywhereRun) and source != before:
            self._quiet.start()

    def _on_image_changed(self) -> None:
        self._task.cancel()
        self._latest.drop_waiting()
        self._quiet.stop()
        self.partition = self.source = self._asked_for = self._everywhere = None
        self.changed.emit()


def partition_from_everywhere(source: EverywhereRun, task: BackgroundTask, model: str = "") -> Partition:
    """Make a partition with the contours of a run from everywhere; without contours if that would take too long."""
    image, regions = source.image, source.regions
    if math.prod(image.shape) > MAX_OFFERED_PIXELS:
        return Partition(image, (), plane_regions(regions), source.parameters.channel, model=model)
    grid = uniform_grid(image.shape)
    found = segment(image, grid, source.parameters, regions=regions, progress=lambda _: task.check_cancelled())
    return Partition.from_result(found, model)


def parameters_everywhere(document: Document) -> Parameters:
    """Return the parameters of a run from everywhere: those of a partition, with the user's changes to the preset."""
    return _merge_into_everywhere(document.mode, document.parameters)


@lru_cache(maxsize=8)  # asked for with each scene
def _merge_into_everywhere(mode: Mode, current: Parameters) -> Parameters:
    preset = PRESETS[MODES[mode].preset]
    changed = {
        field.name: getattr(current, field.name)
        for field in fields(Parameters)
        if getattr(current, field.name) != getattr(preset, field.name)
    }
    return replace(EVERYWHERE_PARAMETERS, **changed)


def _precompute_selection(made: AnyPartition) -> AnyPartition:
    """Have a partition compute and cache everything that a selection needs, so that the first one is fast."""
    middle = np.array([[0.5 * (side - 1) for side in made.shape]])
    if isinstance(made, VolumePartition):
        made.find_body_numbers(middle)
    else:
        made.select(middle)
    return made


MAX_OFFERED_PIXELS = 1 << 23
"""Number of pixels up to which a run from everywhere is started and objects are offered without a request."""

_MUCH_LARGER = 2.0
"""Ratio of sizes from which one object may lie in another, as a nucleus in a cell."""

_NESTING_MARGIN = 0.3
"""Width of the surroundings of an object that may lie in another, as a fraction of its radius."""

_SAMPLED_PIXELS = 100
"""Approximate number of pixels of a selection that are compared with objects."""

_SEEN_OBJECT_IOU = 0.5
"""Overlap (intersection over union) below which two objects at the same place are different ones."""

_MAX_KEPT_SELECTIONS = 50
"""Number of selections that are kept; in a volume, each has a surface."""


class Selector:
    """Selects objects on one partition and keeps the selections; each click changes the selection of those before it.

    Parameters
    ----------
    partition : Partition or VolumePartition
        The partition.
    items : sequence of SegmentedObject
        The existing objects.
    edited : int
        Number of the object being changed, 0 for none; its own clicks select it unchanged.
    found : tuple of Proposal
        Objects that a run proposes; the clicks of one of them select it unchanged, too.
    rejected : tuple of SegmentedObject
        Objects that are not proposed again.
    overlaps : bool
        Whether selections may run over existing objects that are not frozen.
    undone : sequence of SegmentedObject
        Objects whose acceptance was undone; their own clicks select them unchanged, as they were seen.
    shown : mapping of tuple of Click to Selection, optional
        What clicks have selected before the contours everywhere were known, or other objects changed, and the user has
        seen: another object takes its place only if it is more likely.
    """

    def __init__(
        self,
        partition: AnyPartition,
        items: Sequence[SegmentedObject],
        edited: int = 0,
        found: tuple[Proposal, ...] = (),
        rejected: tuple[SegmentedObject, ...] = (),
        overlaps: bool = False,
        undone: Sequence[SegmentedObject] = (),
        shown: Mapping[Clicks, Selection | None] | None = None,
    ) -> None:
        self.partition, self.edited = partition, edited
        self.made_of = partition, items, found, rejected, overlaps
        """All that it depends on besides the object being changed."""
        self.items, self.offered, self._rejected = items, found, rejected
        self._limits = [item.region for item in items if item.number != edited and (item.frozen or not overlaps)]
        self._shown = shown or {}
        self.known: dict[Clicks, Selection | None] = {}
        """What clicks have selected, the least recently used ones first."""
        self._stepped: tuple[Clicks, tuple[Sequence[Selection], int]] | None = None
        """The clicks whose candidates were requested last, and the candidates, which take long in a volume."""
        changed = {initial_clicks(item, partition.shape): item for item in items if item.number == edited}
        self._unchanged = {item.clicks: item for item in undone} | changed

    def selection_for(self, clicks: Clicks) -> Selection | None:
        """Return the object that clicks select; None if none of them is positive."""
        selection = self.known.pop(clicks) if clicks in self.known else self._compute_selection(clicks)
        if len(self.known) == _MAX_KEPT_SELECTIONS:
            del self.known[next(iter(self.known))]
        self.known[clicks] = selection
        return selection

    def _compute_selection(self, clicks: Clicks) -> Selection | None:
        inside = collect_points(clicks, inside=True)
        if not len(inside):
            return None
        item, made = self._unchanged.get(clicks), self._found_by_clicks.get(clicks)
        if made is None and item is not None:
            made = replace(selection_from_object(item, self.partition.shape), image=self.partition.image)
            if isinstance(self.partition, Partition):  # to be compared with what further clicks give
                made = replace(made, region=item.region.clipped(self.partition.shape))
        elif made is None and clicks[-1].step:
            found, default = self._find_candidates(clicks)
            made = found[min(max(default + clicks[-1].step, 0), len(found) - 1)]
        elif made is None:
            arguments = self._other_arguments(clicks)
            made, seen = self.partition.select(inside, **arguments), self._shown.get(clicks)
            if seen is not None and arguments["excluded"] is not None:
                seen = self.partition.remove_pixels(seen, arguments["excluded"])
            if (
                seen is not None
                and seen.confidence >= made.confidence
                and made.region.compute_iou(seen.region) < _SEEN_OBJECT_IOU
            ):
                made = seen
            made = self._find_another(clicks, made)
        if isinstance(self.partition, VolumePartition):
            known = (one for one in list(self.known.values()) if one is not None and one.has_same_region(made))
            made = next((one for one in known if one.remark == made.remark), made)
            _ = made.surface, made.contains(inside)  # cached on this thread, not on the window's
        return made

    def _find_another(self, clicks: Clicks, made: Selection) -> Selection:
        """Find the likeliest other object where a first click has made one that is there; else return what it made."""
        places = np.array(clicks[0].places)
        others = (item.region for item in self.items if item.number != self.edited)
        there = [one for one in others if one.encloses(places).mean() > 0.5] if len(clicks) == 1 else []

        def is_there(found: Selection) -> bool:
            return any(found.region.compute_iou(one) >= _SEEN_OBJECT_IOU for one in there)

        if not is_there(made):
            return made
        found = self.partition.find_candidates(places, **self._other_arguments(clicks))
        new = (each for each in found if not is_there(each))
        return max(new, key=lambda each: each.confidence, default=made)

    def propose(self, clicks: Clicks) -> tuple[Proposal, ...]:
        """Return the object that clicks select, and then what is offered elsewhere."""
        selection, offered = self.selection_for(clicks), self.proposals
        if selection is not None:
            corrected = next((each for each in offered if _corrects(clicks, each)), None)
            rest = (each for each in offered if each is not corrected)
            elsewhere = (each for each in rest if not selection.contains(np.array(each.clicks[0].places[:1]))[0])
            drafted = Proposal(selection, clicks, self.edited)
            if corrected is not None and not self.edited:
                drafted = replace(corrected, selection=selection, clicks=clicks, key=0)
            offered = (drafted, *elsewhere)
        for each in offered:
            if each.selection.has_boundary:
                _ = each.proposed_object  # cached on this thread, not on the window's
        return offered

    def preview_click(self, before: Clicks, click: Click) -> Preview | None:
        """Return what one more click would change; None where that takes too long, or it selects nothing."""
        after = self.selection_for((*before, click)) if self._is_quick((*before, click)) else None
        return None if after is None else Preview(after, self.selection_for(before), click.inside)

    def _is_quick(self, clicks: Clicks) -> bool:
        """Return whether the selection takes so little time that it can be shown while the pointer moves."""
        if not isinstance(self.partition, VolumePartition) or clicks in self.known:
            return True
        places = np.concatenate([np.array(each.places) for each in clicks])
        return self.partition.knows_bodies(places)

    def _other_arguments(self, clicks: Clicks) -> JsonDict:
        """Return the arguments of a selection other than the positive points."""
        outside, previous = collect_points(clicks, inside=False), self.selection_for(clicks[:-1])
        return {"outside": outside, "previous": previous, "excluded": self._find_excluded(clicks)}

    def _find_excluded(self, clicks: Clicks) -> Mask | None:
        """Find the pixels that the object of clicks must leave to other objects; None without any."""
        apart = keep_separate(clicks, self._limits)
        if len(apart) < len(self._limits):
            return unite_regions(apart, self.partition.shape)
        return self._taken if apart else None

    @cached_property
    def _taken(self) -> Mask:
        return unite_regions(self._limits, self.partition.shape)

    @cached_property
    def _found(self) -> tuple[Proposal, ...]:
        """The found objects, without the pixels of existing ones."""
        limited = map(self._limit_proposal, self.offered)
        return tuple(each for each in limited if each.selection.has_boundary)

    @cached_property
    def _found_by_clicks(self) -> dict[Clicks, Selection]:
        return {each.clicks: each.selection for each in self._found}

    def _limit_proposal(self, proposal: Proposal) -> Proposal:
        """Leave the pixels of existing objects out of a proposal."""
        excluded = self._find_excluded(proposal.clicks)
        if excluded is None:
            return proposal
        return replace(proposal, selection=self.partition.remove_pixels(proposal.selection, excluded))

    def _find_candidates(self, clicks: Clicks) -> tuple[Sequence[Selection], int]:
        """Find the candidates for clicks, from small to large, and the index of the one selected without a step."""
        clicks = (*clicks[:-1], replace(clicks[-1], step=0))
        if self._stepped is None or self._stepped[0] != clicks:
            found = self.partition.find_candidates(collect_points(clicks, inside=True), **self._other_arguments(clicks))
            self._stepped = clicks, (found, find_most_similar(found, cast("Selection", self.selection_for(clicks))))
        return self._stepped[1]

    def step_clicks(self, clicks: Clicks, by: int) -> tuple[Clicks, int, int]:
        """Return the clicks of a candidate some steps larger, or smaller below 0, its number from 1, and the count."""
        if self.selection_for(clicks) is None:
            return clicks, 1, 1
        found, default = self._find_candidates(clicks)
        last = len(found) - 1
        place = min(max(min(max(default + clicks[-1].step, 0), last) + by, 0), last)
        return (*clicks[:-1], replace(clicks[-1], step=place - default)), place + 1, len(found)

    @cached_property
    def proposals(self) -> tuple[Proposal, ...]:
        """The offered objects, except for rejected ones, those that exist, and parts of merged or corrected ones."""
        new = {
            each.clicks
            for each in self.offered
            if not is_covered(each.selection.region, self.partition.shape, self.items, self._rejected)
        }
        joined = [frozenset(item.clicks) for item in self.items]
        return tuple(
            each
            for each in self._found
            if each.clicks in new and not any(frozenset(each.clicks) < clicks for clicks in joined)
        )


def _corrects(clicks: Clicks, proposal: Proposal) -> bool:
    """Tell whether clicks begin with those of a proposal, perhaps at another candidate."""
    first = [replace(each, step=0) for each in clicks[: len(proposal.clicks)]]
    return first == [replace(each, step=0) for each in proposal.clicks]


def find_proposals(result: Result, continues: bool, page: Page | None, task: BackgroundTask) -> tuple[Proposal, ...]:
    """Find the objects that a run proposes, each with the clicks that select it.

    A run `continues` if it began along the contours of the page before. Objects have the numbers of those on `page`.
    """
    found = find_objects(result, task.check_cancelled, continues=continues)
    numbers = [0] * len(found) if page is None or page.result is None else _find_tracks(found, page.result)
    return tuple(
        Proposal(one, (Click(as_line(one.inside)),), number) for one, number in zip(found, numbers, strict=True)
    )


def _find_tracks(found: Sequence[Selection], on_page: Result) -> list[int]:
    """Find the tracks of objects: those that most of their pixels have on the page, each once; 0 for none."""
    tracks, numbers = paint_tracks(on_page, on_page.shape), list[int]()
    for one in found:
        number = int(np.bincount(tracks[one.region.window][one.region.mask]).argmax())
        numbers.append(0 if number in numbers else number)
    return numbers


def is_covered(
    region: Region, shape: Extent, items: Iterable[SegmentedObject], doubted: Iterable[SegmentedObject] = ()
) -> bool:
    """Tell whether objects cover half of a region or more, in an image of this shape.

    One in which the region lies with its surroundings, as a nucleus in a cell, does not count. Nor does a much larger
    one that is `doubted`, as it may be wrong.
    """
    places = _sample_pixels(region.mask, region.origin)
    if not len(places):
        return False
    low, high, large = places.min(axis=0), places.max(axis=0), _MUCH_LARGER * region.count
    known = [item.region for item in items]
    others = (*known, *(item.region for item in doubted if item.region.size < large))
    near = (one for one in others if one.size > 0.0 and (one.bounds[0] <= high).all() and (one.bounds[1] >= low).all())
    covered = [(one, one.encloses(places)) for one in near]
    if not _cover_half(there for _, there in covered):
        return False
    return _cover_half(
        there for one, there in covered if one.size < large or not (there.any() and _lies_within(region, one, shape))
    )


def _cover_half(covered: Iterable[Mask]) -> bool:
    """Tell whether half of some places or more are covered, given which of them each object covers."""
    masks = list(covered)
    return bool(masks) and bool(np.any(masks, axis=0).mean() >= 0.5)


def is_offered(selection: Selection, offered: Iterable[Proposal]) -> bool:
    """Tell whether proposals cover half of a selection or more, not counting much larger ones that are less likely."""
    known = [each for each in offered if each.selection.has_boundary]
    better = [each.proposed_object for each in known if each.selection.confidence >= selection.confidence]
    return is_covered(selection.region, selection.shape, better, (each.proposed_object for each in known))


def find_limits(example: SegmentedObject, items: Iterable[SegmentedObject], shape: Extent) -> list[Region]:
    """Find the objects that others like one leave alone: all, but where it lies in a larger one only the small ones."""
    regions, large = [item.region for item in items], _MUCH_LARGER * example.region.size
    if any(one.size >= large and _lies_within(example.region, one, shape) for one in regions):
        return [one for one in regions if one.size < large]
    return regions


def _lies_within(region: Region, other: Region, shape: Extent) -> bool:
    """Tell whether a region lies in another with most of its surroundings in an image of this shape."""
    around = _SURROUNDINGS.get(_sample_surroundings, region, shape)
    return bool(len(around)) and bool(other.encloses(around).mean() >= 0.5)


def _sample_surroundings(region: Region, shape: Extent) -> Array:
    """Return the places of some of the pixels around a region, which takes long for a large one in a volume."""
    width = math.ceil(_NESTING_MARGIN * measure_radius(region.mask, np.ones(region.ndim)))
    window = expand_window(region.clipped(shape).window, width, shape)
    away = scipy.ndimage.distance_transform_edt(~region.cut_out(window))
    return _sample_pixels((away > 0.0) & (away <= width), first_pixel(window))


_SURROUNDINGS = WeakCache[Array](1024)


def _sample_pixels(mask: Mask, origin: ArrayLike) -> Array:
    """Return the places of some of the pixels of a mask whose first pixel lies at `origin`."""
    pixels = np.argwhere(mask)
    return (pixels[:: max(len(pixels) // _SAMPLED_PIXELS, 1)] + np.asarray(origin)).astype(float)
