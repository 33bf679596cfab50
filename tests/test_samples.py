"""The sample images are what their script draws, and their starts find what is on them."""

import importlib.util
import json
from pathlib import Path

import numpy as np
import PIL.Image
import pytest
from cpm_app.model.document.document import Document
from cpm_app.model.document.samples import find_sample_named
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

import cpm_core as cpm
from cpm_core.shapes.image_starts import SeedCache

SAMPLES = Path(__file__).parent.parent / "assets" / "samples"
LISTED = json.loads((SAMPLES / "samples.json").read_text(encoding="utf-8"))
OBJECTS = {"u_shape.png": 1, "cells.png": 16, "rings.png": 5, "noisy.png": 2, "nuclei.png": 13}
OPEN_ENDED = {
    # place (row, col) beside which a contour must run, and one that must stay far from all of them
    "artery.png": (((40, 124), (150, 132), (265, 82), (84, 205), (120, 290)), ((50, 50), (200, 280), (250, 150))),
    "hand.png": (((35, 173), (128, 26), (56, 260), (116, 328), (300, 253)), ((60, 60), (60, 350), (330, 60))),
}
"""Samples whose objects leave the image, so that their contours are open."""
VOLUME = "vessels.tif"
VOXELS = {"vessels.tif": (0.6, 0.4, 0.4), "head.tif": (3.0, 2.0, 2.0)}
"""Sizes of the voxels of volumes [mm]."""
ENDS = ((56, 96, 75), (22, 96, 17), (38, 86, 96), (72, 87, 38), (31, 39, 96), (69, 26, 84), (46, 33, 1), (63, 17, 22))
"""Where the vessels end, or leave the volume (plane, row, col), in columns."""


@pytest.fixture(scope="module")
def redrawn(tmp_path_factory):
    """Folder with the samples drawn anew."""
    folder = tmp_path_factory.mktemp("samples")
    specification = importlib.util.spec_from_file_location("make_samples", SAMPLES / "make_samples.py")
    script = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(script)
    script.write(folder)
    return folder


def test_the_list_is_what_the_script_writes(redrawn):
    assert json.loads((redrawn / "samples.json").read_text(encoding="utf-8")) == LISTED


@pytest.mark.parametrize("file", [*OBJECTS, *OPEN_ENDED])
def test_the_images_are_what_the_script_draws(redrawn, file):
    kept, drawn = (np.asarray(PIL.Image.open(folder / file), dtype=int) for folder in (SAMPLES, redrawn))
    assert kept.shape == drawn.shape
    # another processor may round a value that lies between two gray levels the other way
    assert np.abs(kept - drawn).max() <= 1
    assert np.mean(kept != drawn) < 1e-3


@pytest.mark.parametrize("file", VOXELS)
def test_the_volumes_are_what_the_script_draws_and_contain_the_size_of_their_voxels(redrawn, file):
    kept, drawn = (cpm.load_volume(folder / file) for folder in (SAMPLES, redrawn))
    assert np.mean(kept.values != drawn.values) < 1e-3
    assert kept.spacing == pytest.approx(VOXELS[file], rel=1e-4)
    assert kept.unit == "mm"
    assert (SAMPLES / file).stat().st_size < 200_000


def test_a_click_in_the_head_has_the_lesion_among_its_candidates():
    volume = cpm.load_volume(SAMPLES / "head.tif")
    lesion = cpm.partition(volume).find_candidates([(29, 45, 31)])[0]
    low, high = lesion.surface.vertices.min(axis=0), lesion.surface.vertices.max(axis=0)
    assert (low + high) / 2 == pytest.approx((28.8, 45.0, 31.5), abs=1.5)
    assert lesion.size == pytest.approx(4 / 3 * np.pi * 15 * 16 * 10, rel=0.15)


def test_the_sphere_of_the_volume_finds_the_whole_tree_in_one_piece():
    surface = run(VOLUME).surface
    edges = np.concatenate([surface.faces[:, :2], surface.faces[:, 1:]])
    count = len(surface.vertices)
    graph = coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), (count, count))
    assert connected_components(graph, directed=False)[0] == 1
    assert count - len(surface.faces) / 2 == 2, "a tree without holes has the Euler characteristic of a sphere"
    near = KDTree(surface.vertices * (1.5, 1.0, 1.0))
    assert near.query(ENDS)[0].max() < 5.0


def run(file):
    """What the sample of this name gives when it is run as it is opened."""
    sample = find_sample_named(file)
    image = (cpm.load_volume if file in VOXELS else cpm.load_image)(sample.path)
    document = Document(shapes=sample.shapes, parameters=sample.parameters)
    seeds = document.collect_seeds(
        SeedCache(image).seeds_for(document.image_starts, sample.parameters.smoothing, document.regions)
    )
    assert np.all((seeds >= 0) & (seeds <= np.array(image.shape) - 1))
    return cpm.segment(image, seeds, sample.parameters)


@pytest.mark.parametrize("file", OBJECTS)
def test_the_start_of_a_sample_lies_in_the_image_and_finds_its_objects(file):
    assert sum(contour.closed for contour in run(file).contours) == OBJECTS[file]


@pytest.mark.parametrize("file", OPEN_ENDED)
def test_the_start_of_a_sample_finds_every_limb_and_nothing_beside_it(file):
    found = np.concatenate([contour.path for contour in run(file).contours])
    beside, far = OPEN_ENDED[file]
    for place in beside:
        assert np.hypot(*(found - place).T).min() < 12, place
    for place in far:
        assert np.hypot(*(found - place).T).min() > 15, place
