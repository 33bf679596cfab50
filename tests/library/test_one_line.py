"""Every public object is shown on one line, however long its parts and names are."""

from __future__ import annotations

import inspect

import pytest

import cpm_core as cpm

WIDEST = 120
ABSTRACT = {"ContourState", "Method", "State"}
"""Interfaces, of which there are no objects."""


@pytest.fixture(scope="module")
def objects():
    """An object of each public class."""
    image = cpm.example("disks")
    seeds = cpm.uniform_grid((64, 64))
    result = cpm.segment(image, seeds)
    ball = cpm.example("ball")
    surface = cpm.segment(ball, cpm.sphere((15, 15, 15), 4, 60), cpm.PRESETS["volume"])
    engine, state = cpm.Engine(image), cpm.Engine(image).start(seeds)
    partition, bodies = cpm.partition(result), cpm.partition(surface)
    front = cpm.CONTOUR_METHODS["geodesic"]
    start = cpm.Start((cpm.circle((32, 18), 5),))
    moment = cpm.run_method(front, image, start, max_steps=2)
    pages = list(cpm.follow_pages([image, image], cpm.circle((32, 18), 5)))
    truth = cpm.Truth(result.labels, result.contours)
    labels = cpm.VolumeTruth(surface.labels)
    evolution = cpm.evolve(image, seeds)
    return [
        image, result, ball, surface, surface.surface, engine, state, state.particles, partition, bodies, front, start,
        moment, pages[0], cpm.TrackEvent("splits", 3, 1, tuple(range(2, 60))), truth, evolution, next(evolution),
        labels, cpm.compare_surface(surface.surface, labels), result.contours[0], result.table(),
        cpm.compare(result.contours, truth), cpm.report_run(moment, truth), engine.forces(state, cpm.Parameters()),
        engine.energies(state, cpm.Parameters()), cpm.skeleton(image), partition.select([(32, 18)]),
        bodies.select([(15, 15, 15)]), cpm.centerlines(surface.labels), cpm.Geometry(), cpm.Parameters(),
        cpm.PlacedCharge((1 / 3, 2 / 3), 1 / 7), cpm.Bridge(seeds[:3], 12.0, 3.0), *result.faces,
        cpm.Regions([seeds[[0, 3, 20]]], [seeds[:2]]), cpm.VolumeRegions([((0, 0, 0), (9, 9, 9))]),
        cpm.Extrusion(tuple(map(tuple, seeds[[0, 3, 20]].tolist())), 0, 2, 7), *cpm.measure(result.contours),
        cpm.notebook_view(result),
    ]  # fmt: skip


def test_there_is_an_object_of_every_public_class(objects):
    classes = {name for name in cpm.__all__ if inspect.isclass(getattr(cpm, name))} - ABSTRACT
    assert classes <= {type(one).__name__ for one in objects}


def test_each_is_shown_on_one_line(objects):
    for one in objects:
        text = repr(one)
        assert type(one).__name__ in text, text
        assert text.isprintable(), text
        assert len(text) <= WIDEST, text
