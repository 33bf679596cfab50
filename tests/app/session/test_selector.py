"""What is known of earlier clicks is not worked out again, and accepted objects limit what clicks select."""

from dataclasses import replace

import numpy as np
import pytest
import scipy
from cpm_app.model.document.objects import object_from_selection
from cpm_app.session.features.selector import Selector, is_covered
from cpm_app.session.scene import Proposal

from cpm_core import Partition, VolumePartition, example, partition
from cpm_core.image.region import Region
from cpm_core.objects.segmented import Click, SegmentedObject


def test_each_place_under_the_pointer_costs_one_answer_however_many_came_before(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    there = partition(example("disks"))
    answer, asked = there.select([(32.0, 18.0)]), []
    monkeypatch.setattr(Partition, "select", lambda *given, **more: asked.append(given) or answer)
    selector, clicks = Selector(there, ()), tuple(Click(((32.0, col),)) for col in (16.0, 18.0, 20.0))
    for col in range(300):
        selector.selection_for((*clicks, Click(((10.0, float(col)),))))
    assert len(asked) == len(clicks) + 300


def test_an_accepted_object_in_a_volume_is_a_limit_unless_it_may_overlap_or_is_clicked() -> None:
    there = partition(example("ball"))
    whole = there.select([(15, 15, 12)])
    half = whole.mask & (np.indices(there.shape)[2] >= 16)
    item = SegmentedObject(1, (), region=Region.from_mask(half))
    beside, within = (Click(((15.0, 15.0, 12.0),)),), (Click(((15.0, 15.0, 20.0),)),)
    for clicks, overlaps, is_limited in ((beside, False, True), (beside, True, False), (within, False, False)):
        found = Selector(there, (item,), overlaps=overlaps).selection_for(clicks)
        assert (found.mask & half).any() != is_limited
        assert (found.mask & ~half).sum() > 0.9 * (whole.mask & ~half).sum()
    after_run = VolumePartition(there.image, whole.surface)
    offered = Proposal(after_run.select([(15, 15, 12)]), beside, key=-1)
    selected_elsewhere = replace(item, clicks=(Click(((1.0, 1.0, 1.0),)),))
    (left,) = Selector(after_run, (selected_elsewhere,), found=(offered,)).proposals
    np.testing.assert_array_equal(left.selection.mask, offered.selection.mask & ~half)


@pytest.mark.parametrize("is_sure", [True, False])
def test_an_answer_that_was_seen_gives_way_to_another_object_only_if_that_is_likelier(is_sure: bool) -> None:
    there, clicks = partition(example("disks")), (Click(((32.0, 18.0),)),)
    other = there.select([(32, 46)])
    seen = other if is_sure else replace(other, confidence=0.1)
    found = Selector(there, (), shown={clicks: seen}).selection_for(clicks)
    assert found.contains(np.array([(32.0, 46.0)])).all() == is_sure


def test_bodies_of_an_accepted_object_are_covered_but_not_a_nucleus_in_it_nor_parts_of_what_may_be_wrong() -> None:
    shape = 60, 90
    row, col = np.indices(shape)
    small, large = np.hypot(row - 30, col - 62) < 11, np.hypot(row - 30, col - 32) < 20
    whole = SegmentedObject(1, (), Region.from_mask(small | large))
    body, nucleus = Region.from_mask(small & ~large), Region.from_mask(np.hypot(row - 30, col - 32) < 8)
    assert is_covered(body, shape, [whole])
    assert not is_covered(nucleus, shape, [whole])
    assert not is_covered(body, shape, [], [whole])
    assert is_covered(whole.region, shape, [], [whole])


@pytest.mark.parametrize(
    ("shape", "center", "inner", "outer"),
    [((60, 60), (0, 0), 10, 40), ((60, 60), (59, 59), 10, 40), ((3, 60, 60), (1, 30, 30), 10, 25)],
)
def test_a_nucleus_at_the_edge_of_an_image_or_through_a_thin_volume_is_not_covered_by_its_cell(
    shape, center, inner, outer
) -> None:
    away = np.hypot(*(at - middle for at, middle in zip(np.indices(shape)[-2:], center[-2:], strict=True)))
    cell, nucleus = (Region.from_mask(away < radius) for radius in (outer, inner))
    assert not is_covered(nucleus, shape, [SegmentedObject(1, (), cell)])
    assert is_covered(nucleus, shape, [SegmentedObject(1, (), nucleus)])


def test_a_first_click_in_an_object_selects_another_one_there() -> None:
    row, col = np.indices((120, 120))
    cell, nucleus = np.hypot(row - 60, col - 60) < 38, np.hypot(row - 64, col - 55) < 13
    levels = scipy.ndimage.gaussian_filter(30.0 + 80.0 * cell + 20.0 * nucleus, 1.2)
    there = partition(levels + np.random.default_rng(5).normal(0.0, 4.0, cell.shape))
    clicks = (Click(((64.0, 55.0),)),)
    whole = Selector(there, ()).selection_for(clicks)
    item = object_from_selection(whole, clicks, 1, 1)
    other = Selector(there, (item,)).selection_for(clicks)
    assert whole.region.compute_iou(Region.from_mask(cell)) > 0.9
    assert other.region.compute_iou(Region.from_mask(nucleus)) > 0.8
    np.testing.assert_array_equal(Selector(there, (item,), edited=1).selection_for(clicks).mask, whole.mask)
