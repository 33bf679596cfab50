"""An object in the hole of another: neither is lost in a mask, and each area is that of its pixels."""

import contextlib
from dataclasses import replace

import numpy as np
import pytest
from pycocotools.coco import COCO

import cpm_core as cpm
from cpm_core.contours.contour import Contour
from cpm_core.contours.measurements import measure
from cpm_core.contours.rasterize import rasterize_labels

SHAPE, CENTER = (90, 90), 44.0
TURN = np.linspace(0.0, 2.0 * np.pi, 200, endpoint=False)


def circle(radius, **more):
    points = CENTER + radius * np.column_stack([np.cos(TURN), np.sin(TURN)])
    return Contour(points, True, 1.0, **more)


def ring(group, outer=35.0, inner=18.0):
    return [circle(outer, group=group, name="ring"), circle(inner, group=group, name="ring", hole=True)]


@pytest.mark.parametrize("radius", [10.0, 17.6, 18.0, 18.4, 22.0, 30.0])
@pytest.mark.parametrize("first", ["ring", "core"])
def test_labels_and_net_areas_of_a_ring_and_its_core_are_those_of_their_pixels(radius, first):
    core = [circle(radius, group=2, name="core")]
    contours = [*ring(1), *core] if first == "ring" else [*core, *ring(1)]
    labels = rasterize_labels(contours, SHAPE)
    distance = np.hypot(*(np.indices(SHAPE) - CENTER))
    rows = {row.name: row for row in measure(contours, contrast=False) if row.label}
    inside_core, inside_ring = distance < radius - 1, (distance < 34) & (distance > max(radius, 18.0) + 1)
    assert np.all(labels[inside_core] == rows["core"].label)
    assert np.all(labels[inside_ring] == rows["ring"].label)
    for row in rows.values():
        boundaries = 2 * np.pi * (35.0 + max(radius, 18.0))  # half a pixel along them may be either's
        assert row.net_area == pytest.approx((labels == row.label).sum(), abs=0.5 * boundaries)
    assert rows["core"].net_area == pytest.approx(np.pi * radius**2, rel=1e-3)


@pytest.mark.filterwarnings("ignore:__array__ implementation:DeprecationWarning")  # of pycocotools
def test_an_object_under_another_keeps_its_own_mask_in_a_coco_file(tmp_path):
    rows, cols = np.indices(SHAPE)
    image = cpm.Image(60.0 + 120.0 * (np.hypot(rows - CENTER, cols - CENTER) < 35))
    result = cpm.objects_result([cpm.partition(image).select([(44, 44)])], image)
    hidden = replace(result, contours=(*ring(1), circle(35.0, group=2), circle(8.0, group=3)))
    cpm.export(hidden, tmp_path / "a.coco.json")
    with contextlib.redirect_stdout(None):
        coco = COCO(str(tmp_path / "a.coco.json"))
    areas = np.pi * np.array([35.0**2 - 18.0**2, 35.0**2, 8.0**2])
    for annotation, area in zip(coco.dataset["annotations"], areas, strict=True):
        assert coco.annToMask(annotation).sum() == pytest.approx(area, rel=0.06)
