"""All bodies of a volume: what closed surfaces bound, split into parts, and how likely each is an object."""

from __future__ import annotations

from collections.abc import Iterator

from cpm_core.numerics.types import Callback
from cpm_core.objects.body_evidence import MIN_INNER_CONFIDENCE
from cpm_core.objects.selection import Selection
from cpm_core.objects.volume_partition import VolumePartition


def find_bodies_everywhere(partition: VolumePartition, check: Callback = lambda: None) -> Iterator[Selection]:
    """Find all bodies inside the surface of a volume, and likely ones in its hollows, each with its confidence.

    They are split by `VolumePartition.split_body`. `check` is called between them, and may raise to end the search.
    """
    for number in range(1, int(partition.labels.max()) + 1):
        check()
        found = partition.split_body(number)
        yield from (one for one in found if number in partition.solid_bodies or one.confidence >= MIN_INNER_CONFIDENCE)
