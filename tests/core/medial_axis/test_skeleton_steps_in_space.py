"""The skeleton of a volume as a run of three steps, by the same name as that of an image."""

from dataclasses import replace

import numpy as np
import pytest

from cpm_core import METHODS, PRESETS, Image, VolumeRegions, VolumeTruth, skeleton
from cpm_core.formats import to_bytes
from cpm_core.image.region import Region

VOLUME = PRESETS["volume"]


def tubes(sides=(1.0, 1.0, 1.0)):
    """A bright cross of two rods in a dark volume."""
    planes, rows, cols = np.indices((26, 44, 44))
    along = np.hypot(planes - 12.5, rows - 20.0) - 4.0
    across = np.hypot(planes - 12.5, cols - 22.0) - 4.0
    inside = (along < 0) & (cols > 4) & (cols < 39) | (across < 0) & (rows > 4) & (rows < 39)
    values = 20.0 + 150.0 * inside
    return Image(values, spacing=sides, unit="mm", source="cross")


def run(method, parameters=VOLUME):
    state, states = method.start(), []
    while not state.stop_reason:
        state = method.step(state, parameters)
        states.append(state)
    return states


@pytest.mark.parametrize("sides", [(1.0, 1.0, 1.0), (1.0, 0.5, 0.5)])
def test_three_steps_find_what_the_function_finds(sides):
    volume = tubes(sides)
    method = METHODS["skeleton"](volume)
    states = run(method)
    assert [state.step for state in states] == [1, 2, 3]
    assert [len(state.position) > 0 for state in states] == [True, True, False]
    found, whole = method.result(states[-1], VOLUME), skeleton(volume, VOLUME)
    assert states[-1].converged
    assert len(found.contours) == len(whole.contours) == 4
    assert all(np.array_equal(a.points, b.points) for a, b in zip(found.contours, whole.contours, strict=True))
    assert found.length * min(sides) == pytest.approx(whole.lengths.sum())
    thick = 2.0 * np.percentile(np.concatenate(whole.radii), 95.0)
    assert found.thickness * min(sides) == pytest.approx(thick)
    assert to_bytes(found.lines, ".swc") == to_bytes(whole, ".swc")
    assert method.step(states[-1], VOLUME) is states[-1]
    assert states[-1].list_arrays()


def test_pruning_alone_begins_with_the_last_step_and_everything_else_with_the_first():
    method = METHODS["skeleton"](tubes())
    last = run(method)[-1].resume()
    pruned = method.step(last, replace(VOLUME, pruning=9.0))
    assert pruned.stop_reason
    assert pruned.structure is last.structure
    again = method.step(last, replace(VOLUME, edge_floor=0.3))
    assert not again.stop_reason
    assert again.axis is None


def test_regions_and_surfaces_say_what_has_a_skeleton():
    volume = tubes()
    half = METHODS["skeleton"](volume).with_regions(VolumeRegions([((0, 0, 0), (25, 43, 12))]))
    found = half.result(run(half)[-1], VOLUME)
    assert max(contour.points[:, 2].max() for contour in found.contours) <= 12.5
    rod = np.zeros(volume.shape, bool)
    rod[10:16, 10:16, 4:40] = True
    whole = METHODS["skeleton"](volume)
    one = whole.for_objects([Region.from_surface(VolumeTruth(rod).surface)])
    lines = one.result(run(one)[-1], VOLUME)
    assert len(lines.contours) == 1
    assert np.allclose(np.median(lines.contours[0].points[:, :2], axis=0), 12.5, atol=0.6)
    assert len(whole.result(run(whole)[-1], VOLUME).contours) == 4
