"""What the library returns goes to another process and comes back the same."""

from __future__ import annotations

import copy
import multiprocessing
import pickle

import numpy as np
import pytest

import cpm_core as cpm

SEEDS = cpm.circle((32, 32), 8)


@pytest.fixture(scope="module")
def objects():
    """What a user gets from the library, by name."""
    image, ball = cpm.example("disk"), cpm.example("ball")
    result = cpm.segment(image, SEEDS)
    surface = cpm.segment(ball, cpm.sphere((15, 15, 15), 4, 60), "volume")
    run = cpm.evolve(image, SEEDS)
    moments = [next(run) for _ in range(20)]
    partition, bodies = cpm.partition(result), cpm.partition(surface)
    return {
        "image": image, "result": result, "contour": result.contours[0], "table": result.table(),
        "volume result": surface, "surface": surface.surface, "engine": cpm.Engine(image), "evolution": run,
        "run state": moments[-1], "state": moments[-1].state, "partition": partition, "volume partition": bodies,
        "selection": partition.select([(32, 32)], outside=[(2, 2)]), "body": bodies.select([(15, 15, 15)]),
        "predicted body": cpm.partition(ball).select([(15, 15, 15)]), "skeleton": cpm.skeleton(image),
        "center lines": cpm.centerlines(surface.labels), "truth": cpm.Truth(result.labels, result.contours),
        "face": result.faces[0], "comparison": cpm.compare(result.contours, cpm.Truth(result.labels, result.contours)),
        "published": cpm.evolve(image, SEEDS, "published", method="published"),
    }  # fmt: skip


def test_everything_can_be_pickled_and_copied(objects):
    for name, given in objects.items():
        for other in (pickle.loads(pickle.dumps(given)), copy.copy(given), copy.deepcopy(given)):
            assert repr(other) == repr(given), name


def test_a_pickled_result_measures_and_encodes_the_same(objects):
    for name in ("result", "volume result"):
        given, other = objects[name], pickle.loads(pickle.dumps(objects[name]))
        assert np.array_equal(other.labels, given.labels)
        assert [contour.contrast for contour in other.contours] == [contour.contrast for contour in given.contours]
        assert all(np.array_equal(other.table()[column], values) for column, values in given.table().items())
        assert other.provenance.parameters == given.provenance.parameters
    assert cpm.to_bytes(pickle.loads(pickle.dumps(objects["result"])), ".json") == cpm.to_bytes(
        objects["result"], ".json"
    )


def test_a_pickled_run_continues_as_the_run_itself():
    run = cpm.evolve(cpm.example("disk"), SEEDS)
    for _ in range(10):
        next(run)
    other = pickle.loads(pickle.dumps(run))
    ends = [list(one)[-1] for one in (run, other)]
    assert ends[0].step == ends[1].step
    assert np.array_equal(ends[0].position, ends[1].position)


def test_a_pickled_partition_selects_the_same(objects):
    for name, place in (("partition", (32, 32)), ("volume partition", (15, 15, 15))):
        other = pickle.loads(pickle.dumps(objects[name]))
        assert np.array_equal(other.select([place]).mask, objects[name].select([place]).mask)


def test_a_pickled_engine_keeps_regions_and_scales():
    regions = cpm.Regions(interest=[[(0, 0), (63, 0), (63, 31), (0, 31)]])
    engine = cpm.Engine(cpm.example("disk"), cpm.Parameters(scales=2)).with_regions(regions)
    other = pickle.loads(pickle.dumps(engine))
    assert (other.regions, other.scales) == (regions, 2)
    assert np.array_equal(other.edge_map(cpm.Parameters()), engine.edge_map(cpm.Parameters()))


def test_a_pickled_skeleton_method_keeps_its_objects(objects):
    method = cpm.METHODS["skeleton"](cpm.example("disk"), within=objects["result"].contours)
    other = pickle.loads(pickle.dumps(method))
    states = [one.start() for one in (method, other)]
    parameters = cpm.PRESETS["noisy"]
    for _ in range(3):
        states = [one.step(state, parameters) for one, state in zip((method, other), states, strict=True)]
    assert len(states[1].contours) == len(states[0].contours) > 0


def test_a_pickled_result_is_as_large_as_its_image_particles_and_contours():
    rows, cols = np.mgrid[:256, :256]
    image = cpm.Image((200 * ((rows % 64 - 32) ** 2 + (cols % 64 - 32) ** 2 < 400)).astype(np.uint8))
    result = cpm.segment(image, cpm.uniform_grid(image.shape))
    assert len(result.contours) == 16
    _ = result.labels, result.faces, cpm.measure(result.contours), cpm.partition(result).select([(32, 32)])
    curves = [one.points for one in result.contours]
    arrays = sum(one.nbytes for one in (image.stored, result.particles, result.seeds, *curves))
    assert len(pickle.dumps(result)) < 1.1 * arrays
    assert len(pickle.dumps(cpm.partition(result))) < 1.1 * arrays
    assert len(pickle.dumps(result.contours[0])) < result.contours[0].points.nbytes + 1000


def run_on(seeds):
    """A run in another process, which gives its result, a selection, and a run to be continued here."""
    result = cpm.segment(cpm.example("disk"), seeds)
    return result, cpm.partition(result).select([(32, 32)]), cpm.evolve(result.image, seeds)


@pytest.mark.parametrize("kind", [one for one in ("fork", "spawn") if one in multiprocessing.get_all_start_methods()])
def test_other_processes_return_results(kind, objects):
    with multiprocessing.get_context(kind).Pool(1) as pool:
        result, chosen, run = pool.map(run_on, [SEEDS])[0]
    assert np.array_equal(result.particles, objects["result"].particles)
    assert np.array_equal(chosen.mask, result.labels > 0)
    assert run.moment.step == 0
    assert next(run).count == len(SEEDS)
