"""An object in the hole of another: neither is lost in a mask, and each area is that of its pixels."""

import contextlib
import itertools
import json
from dataclasses import replace

import numpy as np
import pytest
from pycocotools.coco import COCO
from shapely.geometry import shape

import cpm_core as cpm
from cpm_core.contours.contour import Contour
from cpm_core.contours.measurements import measure
from cpm_core.contours.rasterize import paint

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
    labels = paint(contours, SHAPE)
    distance = np.hypot(*(np.indices(SHAPE) - CENTER))
    rows = {row.name: row for row in measure(contours, contrast=False) if row.label}
    inside_core, inside_ring = distance < radius - 1, (distance < 34) & (distance > max(radius, 18.0) + 1)
    assert np.all(labels[inside_core] == rows["core"].label)
    assert np.all(labels[inside_ring] == rows["ring"].label)
    for row in rows.values():
        boundaries = 2 * np.pi * (35.0 + max(radius, 18.0))  # half a pixel along them may be either's
        assert row.net_area == pytest.approx((labels == row.label).sum(), abs=0.5 * boundaries)
    assert rows["core"].net_area == pytest.approx(np.pi * radius**2, rel=1e-3)


@pytest.mark.parametrize("order", list(itertools.permutations(range(3))))
def test_rings_in_rings_keep_their_areas_in_any_order(order):
    """Each one fills the hole of the next."""
    objects = [ring(1, 40.0, 30.0), ring(2, 30.0, 20.0), [circle(20.0, group=3, name="core")]]
    contours = [contour for place in order for contour in objects[place]]
    labels = paint(contours, SHAPE)
    wanted = {1: np.pi * (1600 - 900), 2: np.pi * (900 - 400), 3: np.pi * 400}
    for contour, row in zip(contours, measure(contours, contrast=False), strict=True):
        if row.label:
            assert row.net_area == pytest.approx(wanted[contour.group], rel=1e-3)
            assert (labels == row.label).sum() == pytest.approx(wanted[contour.group], rel=0.03)


@pytest.mark.filterwarnings("ignore:__array__ implementation:DeprecationWarning")  # of pycocotools
@pytest.mark.parametrize("first", [0, 1])
def test_files_of_a_ring_and_its_core_hold_both(tmp_path, first):
    rows, cols = np.indices(SHAPE)
    away = np.hypot(rows - CENTER, cols - CENTER)
    noise = np.random.default_rng(1).normal(0.0, 2.0, SHAPE)
    image = cpm.Image(60.0 + 120.0 * ((away < 35) & (away > 18)) + noise, spacing=(0.5, 0.5), unit="mm")
    parted = cpm.partition(image)
    core = parted.select([(44, 44)], [(44, 71)])
    around = parted.select([(44, 71)], [(44, 44)])
    chosen = [core, around] if first == 0 else [around, core]
    result = cpm.objects_result(chosen, image, ["core", "ring"] if first == 0 else ["ring", "core"])
    cpm.export(result, tmp_path / "a.coco.json", tmp_path / "a.geojson", tmp_path / "a.tif")
    labels = cpm.load_image(tmp_path / "a.tif").values
    assert [np.array_equal(labels == number, one.mask) for number, one in enumerate(chosen, start=1)] == [True, True]
    with contextlib.redirect_stdout(None):
        coco = COCO(str(tmp_path / "a.coco.json"))
    for annotation, one in zip(coco.dataset["annotations"], chosen, strict=True):
        assert annotation["area"] == pytest.approx(one.mask.sum(), rel=0.03)
        assert coco.annToMask(annotation).sum() == pytest.approx(one.mask.sum(), rel=0.03)
    for feature in json.loads((tmp_path / "a.geojson").read_text())["features"]:
        polygon, told = shape(feature["geometry"]), feature["properties"]["measurements"]
        assert polygon.is_valid
        assert polygon.area == pytest.approx(told["Net area px^2"], rel=1e-3)
        assert polygon.area / 4 == pytest.approx(told["Net area mm^2"], rel=1e-3)


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


def test_a_mask_tells_of_contours_that_no_pixel_shows(tmp_path):
    rows, cols = np.indices(SHAPE)
    image = cpm.Image(60.0 + 120.0 * (np.hypot(rows - CENTER, cols - CENTER) < 35))
    result = cpm.objects_result([cpm.partition(image).select([(44, 44)])], image)
    told = []
    covered = replace(result, contours=(circle(20.0), circle(20.0)))
    cpm.export(covered, tmp_path / "a.png", tmp_path / "a.svg", tmp_path / "a.coco.json", warn=told.append)
    assert told == [f"{tmp_path / 'a.png'}: 1 closed contour has no pixel of its own and is not in a mask."]
    speck = Contour(CENTER + np.array([[0.2, 0.2], [0.2, 0.4], [0.4, 0.3]]), True, 1.0)
    told.clear()
    cpm.export(replace(result, contours=(speck, speck, circle(9.0))), tmp_path / "b.tif", warn=told.append)
    assert told == [f"{tmp_path / 'b.tif'}: 2 closed contours have no pixel of their own and are not in a mask."]
    told.clear()
    cpm.export(covered, tmp_path / "c.png", outlines=True, warn=told.append)
    assert not told
