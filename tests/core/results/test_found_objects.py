"""What a run proposes follows from the seeds it began with, and from what it found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cpm_core as cpm
from cpm_core.formats import SessionFile, save_session
from cpm_core.objects import compute_iou
from cpm_core.objects.all_objects import find_objects_everywhere
from cpm_core.results.found_objects import find_objects, is_run_everywhere, split_seeds
from cpm_core.shapes import Circle, Everywhere, Grid, Sphere, Threshold
from cpm_core.shapes.document_shapes import compute_seeds

ONE, OTHER = (18.0, 18.0), (43.0, 42.0)
SIDES = (1.0, 1.0)


@pytest.fixture(scope="module")
def disks() -> cpm.Image:
    """Two disks, of different gray levels."""
    places = np.indices((64, 64))
    away = [np.hypot(places[0] - row, places[1] - col) for row, col in (ONE, OTHER)]
    return cpm.Image(np.where(away[0] < 9, 140.0, np.where(away[1] < 12, 220.0, 20.0)))


def run(image: cpm.Image, seeds, **more) -> cpm.Result:
    return cpm.segment(image, seeds, cpm.PRESETS["automatic"], **more)


@pytest.mark.parametrize(
    "seed",
    [
        lambda image: cpm.uniform_grid(image.shape),
        lambda image: np.concatenate([cpm.uniform_grid(image.shape), cpm.circle(ONE, 5)]),
        lambda image: cpm.gradient_threshold(image.values),
        lambda image: cpm.divergence_centers(image.values),
        lambda image: cpm.gradient_threshold(image.values, fraction=0.02),
        lambda image: compute_seeds(image, [Threshold(((2.0, 2.0), (2.0, 60.0), (60.0, 60.0), (60.0, 2.0)))], 1.0),
    ],
)
def test_a_run_from_everywhere_proposes_all_objects_the_best_first(disks, seed) -> None:
    result = run(disks, seed(disks))
    found = result.objects
    assert {bool(one.mask[18, 18]) for one in found} == {True, False}
    assert [one.confidence for one in found] == sorted((one.confidence for one in found), reverse=True)
    everywhere = find_objects_everywhere(cpm.Partition.from_result(result))
    assert {one.mask.tobytes() for one in found} == {one.mask.tobytes() for one in everywhere}


@pytest.mark.parametrize("continues", [False, True])
def test_a_proposal_of_almost_no_confidence_has_the_remark_that_a_click_there_has(
    disks, monkeypatch, continues
) -> None:
    result = run(disks, cpm.circle(ONE, 12))
    monkeypatch.setattr("cpm_core.objects.partition.estimate_confidence", lambda features: 0.01)
    remark = cpm.partition(result).select([ONE]).remark
    assert remark and {one.remark for one in find_objects(result, continues=continues)} == {remark}


@pytest.mark.parametrize("smoothing", [2, 2.0])
def test_seeds_on_the_edges_by_which_a_run_is_smoothed_are_everywhere(disks, smoothing) -> None:
    noise = np.random.default_rng(1).normal(0.0, 30.0, disks.shape)
    seeds = cpm.gradient_threshold(disks.values + noise, smoothing=smoothing)
    assert is_run_everywhere(cpm.segment(disks.values + noise, seeds, cpm.Parameters(smoothing=smoothing), max_steps=1))


def test_a_run_from_drawn_starts_proposes_the_object_of_each_and_none_twice(disks) -> None:
    result = run(disks, cpm.circle(ONE, 5))
    (one,) = result.objects
    assert one.mask[18, 18] and not one.mask[43, 42]
    seeds = np.concatenate([cpm.circle(ONE, 4), cpm.circle(OTHER, 4), cpm.stroke([(16, 14), (20, 14)])])
    found = run(disks, seeds).objects
    assert sorted((bool(one.mask[18, 18]), bool(one.mask[43, 42])) for one in found) == [(False, True), (True, False)]


def test_a_grid_in_a_region_of_interest_is_everywhere_in_it(disks) -> None:
    regions = cpm.Regions(interest=(((2.0, 2.0), (2.0, 34.0), (34.0, 34.0), (34.0, 2.0)),))
    result = run(disks, cpm.uniform_grid(disks.shape), regions=regions)
    assert len(result.seeds) < 64 and is_run_everywhere(result)
    assert not is_run_everywhere(run(disks, cpm.circle(ONE, 5), regions=regions))


def test_a_grid_in_voxels_that_are_not_cubes_is_everywhere() -> None:
    places = np.moveaxis(np.indices((20, 32, 64)), 0, -1) * (2.5, 1.0, 1.0)
    away = [np.linalg.norm(places - (25.0, 16.0, col), axis=-1) for col in (16.0, 46.0)]
    volume = cpm.Image(200.0 * np.clip(11.0 - np.minimum(*away), 0.0, 1.0), spacing=(2.5, 1.0, 1.0))
    result = cpm.segment(volume, cpm.uniform_grid(volume.shape), cpm.PRESETS["volume"])
    assert is_run_everywhere(result) and len(result.objects) == 2


def test_a_region_drawn_after_a_run_gives_the_objects_of_one_drawn_before_it(disks) -> None:
    regions = cpm.Regions(interest=(((2.0, 2.0), (2.0, 34.0), (34.0, 34.0), (34.0, 2.0)),))
    parameters = cpm.PRESETS["automatic"]
    before = cpm.segment(disks, cpm.uniform_grid(disks.shape), parameters, regions=regions)
    engine = cpm.Engine(disks, parameters)
    state = engine.start(cpm.uniform_grid(disks.shape))
    while not state.stop_reason:
        state = engine.step(state, parameters)
    engine, state = engine.with_regions(regions), state.resume()
    while not state.stop_reason:
        state = engine.step(state, parameters)
    after = engine.result(state, parameters)
    assert is_run_everywhere(after)
    (there,), (here,) = before.objects, after.objects
    assert compute_iou(there.mask, here.mask) > 0.95


def test_rows_of_seeds_stay_together_and_clicks_are_apart() -> None:
    pieces = [
        cpm.circle((20, 20), 8),
        cpm.circle((20, 35.5), 3.5),  # closer than a row of clicks, yet apart
        Grid(((40.0, 40.0), (40.0, 90.0), (90.0, 90.0), (90.0, 40.0))).seeds(),
        cpm.stroke([(70, 5), (90, 30)]),
    ]
    clicks = np.array([(5.0, 60.0), (5.0, 80.0), (5.0, 100.0), (20.0, 60.0), (20.0, 80.0)])
    found = split_seeds(np.concatenate([*pieces, clicks]), SIDES)
    assert [len(piece) for piece in found] == [*map(len, pieces), *[1] * 5]
    assert [len(piece) for piece in split_seeds(clicks[:1], SIDES)] == [1]
    assert [len(piece) for piece in split_seeds(clicks[[0, 0, 1]], SIDES)] == [2, 1]


def test_the_bodies_of_a_volume_are_proposed_those_of_drawn_starts_or_all() -> None:
    places = np.moveaxis(np.indices((24, 30, 40)), 0, -1)
    centers = np.array([(11.0, 13.0, 10.0), (12.0, 15.0, 29.0)])
    away = np.min([np.linalg.norm(places - center, axis=-1) for center in centers], axis=0)
    image = cpm.Image(np.round(20.0 + 180.0 * np.clip(7.0 - away, 0.0, 1.0)))
    whole = cpm.segment(image, cpm.seeds_everywhere(image), "volume").objects
    assert len(whole) == 2
    assert [one.size for one in whole] == sorted((one.size for one in whole), reverse=True)
    (one,) = cpm.segment(image, Sphere((11.0, 13.0, 10.0), 4.0).seeds(), "volume").objects
    assert one.contains(centers).tolist() == [True, False]
    labels = cpm.objects_result(whole, image).labels
    assert [int(labels[one.mask].max()) for one in whole] == [1, 2]


def test_a_session_gives_the_same_objects_by_its_file_on_a_file_and_on_an_array(disks, tmp_path) -> None:
    session = SessionFile(shapes=(Everywhere("grid"),), parameters=cpm.PRESETS["automatic"])
    save_session(session, tmp_path / "a.cpm")
    np.save(tmp_path / "disks.npy", disks.values)
    there = cpm.run(tmp_path / "disks.npy", tmp_path / "a.cpm")
    here = cpm.run(disks.values, session)
    assert len(there.objects) == 2
    for one, other in zip(there.objects, here.objects, strict=True):
        np.testing.assert_array_equal(one.mask, other.mask)
    with pytest.raises(ValueError, match="has no start"):
        cpm.run(disks, SessionFile())


def test_a_result_without_its_image_says_so(disks) -> None:
    result = cpm.run(disks, SessionFile(shapes=(Circle(ONE, 4.0),)))
    assert len(result.objects) == 1
    with pytest.raises(ValueError, match="has no image"):
        _ = replace(result, image=None).objects
