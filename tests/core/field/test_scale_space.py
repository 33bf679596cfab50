"""The scale space of an image: each part is computed when what it depends on has changed, and at no other time."""

import sys
from collections import Counter
from dataclasses import replace
from threading import Thread

import numpy as np
import pytest

from cpm_core.field import scale_field as scale_field_module
from cpm_core.field import scale_space as scale_space_module
from cpm_core.image.regions import Regions
from cpm_core.model.image_fields import ImageFields
from cpm_core.parameters import PARAMETERS, START_PARAMETERS, VOLUME_PARAMETERS, Parameters, find_invalidating
from cpm_core.parameters.choices import CHOICE_PARAMETERS

from ..scenes import disk

START = Parameters()
IMAGE = disk((72, 80), (35.4, 38.7), 20.0).values
REGIONS = Regions(interest=[[(4, 4), (4, 70), (66, 70), (66, 4)]], barriers=[[(10.3, 8.2), (10.3, 60.4)]])


class UsedFields(ImageFields):
    """Fields that are used at once, also by particles."""

    def __init__(self, image, scales, regions=None):
        super().__init__(image, replace(START, scales=scales), regions)

    def at(self, scale, parameters):
        field = self.scale_field(parameters, scale)
        field.force()
        return field


@pytest.fixture
def calls(monkeypatch):
    """How often each part of a scale field has been computed."""
    counted = Counter()

    def count(module, name):
        function = getattr(module, name)

        def counting(*arguments, **named):
            counted[name] += 1
            return function(*arguments, **named)

        monkeypatch.setattr(module, name, counting)

    count(scale_space_module, "build_scale_field")
    for name in ("build_pyramid", "prepare_for_edges", "automatic_smoothing", "apply_gamma", "compute_vesselness"):
        count(scale_space_module, name)
    count(scale_space_module, "build_barrier_map")
    for name in ("convolved_field", "find_pixels_inside_border"):
        count(scale_field_module, name)
    count(scale_space_module, "gradient_provider")
    return counted


def changed(name):
    """Other parameters than the usual ones, in one of them."""
    if name in CHOICE_PARAMETERS:
        return replace(START, **{name: list(CHOICE_PARAMETERS[name].choices)[-1]})
    info = PARAMETERS[name]
    value = {"w1": 0.5, "w2": 2.5}.get(name, 0.25 * info.slider_low + 0.75 * info.slider_high)
    return replace(START, **{name: value})


def others(calls):
    """What has been computed since the last call, nothing left out."""
    seen = {name: times for name, times in calls.items() if times}
    calls.clear()
    return seen


@pytest.mark.parametrize("name", [name for name, info in PARAMETERS.items() if info.invalidates != "field"])
def test_what_acts_at_the_next_step_rebuilds_nothing(calls, name):
    space = UsedFields(IMAGE, 3)
    before = [space.at(scale, START) for scale in range(3)]
    calls.clear()
    other = replace(START, scales=2) if name == "scales" else changed(name)
    assert all(space.at(scale, other) is before[scale] for scale in range(3))
    assert others(calls) == {}


def test_every_parameter_that_invalidates_the_field_builds_a_scale_field():
    space = UsedFields(IMAGE, 1)
    names = [name for name in find_invalidating("field") if name not in (*START_PARAMETERS, *VOLUME_PARAMETERS)]
    assert len(names) == 7
    built = [space.at(0, START), *(space.at(0, changed(name)) for name in names)]
    assert len({id(scale_field) for scale_field in built}) == 8


@pytest.mark.parametrize("regions", [None, REGIONS], ids=["whole", "regions"])
@pytest.mark.parametrize(
    "taken", [{"smoothing": 1.5}, {"smoothing": "auto"}, {"gamma": 0.6}, {"edges": "vessels"}], ids=str
)
def test_a_scale_field_does_not_depend_on_its_history(regions, taken):
    wanted = Parameters(**taken, edge_floor=0.2, max_border=0.1)
    space = UsedFields(IMAGE, 2, regions)
    for before in (START, replace(wanted, edge_floor=0.0), replace(wanted, max_border=0.0)):
        for scale in range(2):
            space.at(scale, before)
    for scale in range(2):
        roundabout, straight = space.at(scale, wanted), UsedFields(IMAGE, 2, regions).at(scale, wanted)
        np.testing.assert_array_equal(roundabout.packed, straight.packed)
        np.testing.assert_array_equal(roundabout.barrier_map.segments, straight.barrier_map.segments)
        assert roundabout.floor == straight.floor
        assert roundabout.smoothing == straight.smoothing


def test_many_threads_get_the_same_scale_field(calls):
    space, seen, other = UsedFields(IMAGE, 2), [], replace(START, smoothing=2.5)
    calls.clear()
    threads = [Thread(target=lambda: seen.append(space.at(0, other))) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(seen) == 8
    assert len({id(scale_field) for scale_field in seen}) == 1
    assert calls["build_scale_field"] == 1


def test_the_parts_in_which_an_image_is_worked_on_fit_together(monkeypatch):
    """Lines computed side by side are those of the whole: no seam, to the last bit."""
    image = np.random.default_rng(2).normal(0.0, 20.0, (150, 140)) + disk((150, 140), (70.0, 72.0), 40.0).values
    pieces = UsedFields(image, 1).at(0, START)
    monkeypatch.setattr(scale_field_module, "run_in_bands", lambda work, rows: work(0, rows))
    grids = sys.modules["cpm_core.numerics.grids"]
    monkeypatch.setattr(grids, "run_in_parallel", lambda work, count, _min_part_size: work(0, count))
    np.testing.assert_array_equal(UsedFields(image, 1).at(0, START).packed, pieces.packed)


def test_the_force_of_a_field_is_made_when_particles_need_it_and_shared_beyond_barriers(calls):
    fields = ImageFields(IMAGE, START)
    plain = fields.scale_field(START)
    barred = fields.with_regions(Regions(barriers=REGIONS.barriers)).scale_field(START)
    assert calls["convolved_field"] == 0
    assert barred.packed is plain.packed
    assert calls["convolved_field"] == 1


def test_fields_of_a_large_image_take_half_the_memory_and_differ_by_rounding_only(monkeypatch):
    double = ImageFields(IMAGE, START, REGIONS).scale_field(START)
    monkeypatch.setattr(scale_field_module, "LARGE_IMAGE_PIXELS", 0)
    single = ImageFields(IMAGE, START, REGIONS).scale_field(START)
    for name in ("gradient", "edge_map", "fixed_charges"):
        assert getattr(single, name).dtype == np.float32
        np.testing.assert_allclose(getattr(single, name), getattr(double, name), rtol=0, atol=1e-6 * double.strongest)
    np.testing.assert_allclose(single.packed[..., :2], double.packed[..., :2], rtol=0, atol=2e-3)
    window = (slice(8, 40), slice(20, 75))
    part = single.crop(window)
    np.testing.assert_array_equal(part.gradient, single.gradient[:, *window])
    np.testing.assert_allclose(part.packed, single.packed[window], rtol=0, atol=1e-4)
    np.testing.assert_array_equal(part.potential, single.potential[window])
