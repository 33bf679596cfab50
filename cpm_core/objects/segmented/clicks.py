"""Objects by clicks: each click corrects what those before it selected, and objects leave one another alone."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from cpm_core.image.region import Region
from cpm_core.numerics.types import Extent, Mask
from cpm_core.objects.partition import Partition
from cpm_core.objects.segmented.segmented_object import Clicks, collect_points
from cpm_core.objects.selection import Selection
from cpm_core.objects.volume_partition import VolumePartition


def select_by_clicks(
    partition: Partition | VolumePartition, objects: Iterable[Clicks], others: Iterable[Selection] = ()
) -> tuple[Selection, ...]:
    """Select objects by clicks, one after the other, as the window does.

    Parameters
    ----------
    partition : Partition or VolumePartition
        What they are selected from.
    objects : iterable of tuple of Click
        The clicks of each object in their order, a positive one among them.
    others : iterable of Selection
        Objects whose pixels are left to them, as to those that are selected before.

    Returns
    -------
    tuple of Selection
        The objects.

    Examples
    --------
    >>> from cpm_core.objects.segmented import Click, select_by_clicks
    >>> select_by_clicks(cpm.partition(cpm.example("disks")), [[Click(((32, 18),))], [Click(((32, 46),))]])
    (<Selection 301 px, 1 contour, 0 gaps, 92 % sure>, <Selection 301 px, 1 contour, 0 gaps, 92 % sure>)
    """
    found: list[Selection] = []
    known = [one.region for one in others]
    for clicks in objects:
        limits = [*known, *(one.region for one in found)]
        selection: Selection | None = None
        for count in range(1, len(clicks) + 1):
            selection = _add_click(partition, tuple(clicks[:count]), selection, limits)
        if selection is None:
            raise ValueError("The clicks of an object are all outside it: add one inside.")
        found.append(selection)
    return tuple(found)


def _add_click(
    partition: Partition | VolumePartition, clicks: Clicks, previous: Selection | None, limits: Sequence[Region]
) -> Selection | None:
    """Add the last of some clicks to what those before it selected; None without a positive one."""
    inside = collect_points(clicks, inside=True)
    if not len(inside):
        return None
    apart = keep_separate(clicks, limits)
    given: dict[str, Any] = {
        "outside": collect_points(clicks, inside=False),
        "previous": previous,
        "excluded": unite_regions(apart, partition.shape) if apart else None,
    }
    plain = partition.select(inside, **given)
    if not clicks[-1].step:
        return plain
    candidates = partition.find_candidates(inside, **given)
    return candidates[min(max(find_most_similar(candidates, plain) + clicks[-1].step, 0), len(candidates) - 1)]


def find_most_similar(candidates: Sequence[Selection], selection: Selection) -> int:
    """Find the index of the candidate most similar to a selection: by overlap, or in a volume by the volumes."""
    if len(selection.shape) == 2:
        return int(np.argmax([one.region.compute_iou(selection.region) for one in candidates]))
    return int(np.argmin([abs(one.size - selection.size) for one in candidates]))


def keep_separate(clicks: Clicks, regions: Sequence[Region]) -> list[Region]:
    """Keep the regions that the object of clicks must not run over.

    One that a positive click lies in, for the most part, is none of these: the click is for what it holds, or for what
    holds it.
    """
    within = [np.array(click.places) for click in clicks if click.inside]
    return [region for region in regions if not any(region.encloses(places).mean() > 0.5 for places in within)]


def unite_regions(regions: Iterable[Region], shape: Extent) -> Mask:
    """Unite the pixels of regions of an image of this shape."""
    united = np.zeros(shape, bool)
    for region in regions:
        region.fill_into(united)
    return united
