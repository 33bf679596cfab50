"""Limits of a run, as sessions keep them: each is read again as it was, and what cannot be one is refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cpm_core import VolumeRegions
from cpm_core.formats.common.json_values import regions_from_json, regions_to_json
from cpm_core.formats.sessions.session_file import decode_session
from cpm_core.image.region import Region
from cpm_core.image.regions import Regions
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.numerics.packed_mask import PackedMask
from cpm_core.shapes.document_shapes import collect_regions
from tests.faults.fuzzing.inputs.session_samples import SAMPLES

MASK = np.random.default_rng(3).random((5, 6, 7)) > 0.5
BOX = ((1.0, 1.0, 1.0), (4.0, 5.0, 6.0))


def kept(regions: AnyRegions) -> AnyRegions | None:
    """The limits after they have been written and read."""
    return regions_from_json(json.loads(json.dumps(regions_to_json(regions))), "regions")


@pytest.mark.parametrize("first", [None, (0, 0, 0), (-2, 3, 400)])
def test_voxels_are_kept_wherever_they_begin(first: tuple[int, ...] | None) -> None:
    regions = VolumeRegions(
        interest=(BOX, Region(pixels=PackedMask.pack(MASK), first=first)),
        barriers=(((0.0, 0.0, 3.5), (0.0, 0.0, 1.0)), MASK),
    )
    again = kept(regions)
    assert isinstance(again, VolumeRegions)
    assert (again.interest, again.barriers) == (regions.interest, regions.barriers)


@pytest.mark.parametrize("name", sorted(SAMPLES))
def test_the_limits_of_every_shape_are_kept(name: str, tmp_path: Path) -> None:
    regions = collect_regions(decode_session(json.dumps(SAMPLES[name](tmp_path)).encode(), name).shapes)
    assert regions is None or kept(regions) == regions
    assert regions is None or isinstance(regions, Regions | VolumeRegions)


@pytest.mark.parametrize(
    "change",
    [
        {"shape": [10**5] * 3}, {"shape": [0, 6, 7]}, {"shape": [5, 6]}, {"shape": [5, 6, 8]}, {"shape": None},
        {"first": [1, 2]}, {"first": [0.5, 1, 1]}, {"first": [10**9, 0, 0]}, {"voxels": ""}, {"voxels": 7},
    ],
)  # fmt: skip
def test_damaged_voxels_are_refused_before_they_take_memory(change: dict[str, Any]) -> None:
    plain = regions_to_json(VolumeRegions(interest=(Region.from_mask(MASK),)))
    plain["volume_regions"]["interest"][0] |= change
    with pytest.raises(ValueError, match=r"regions .*\.$"):
        regions_from_json(plain, "regions")
