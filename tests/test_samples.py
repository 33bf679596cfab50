"""The sample images are what their script draws, and their starts find what is on them."""

import importlib.util
import json
from pathlib import Path

import numpy as np
import PIL.Image
import pytest

import cpm_core as cpm

SAMPLES = Path(__file__).parent.parent / "assets" / "samples"
LISTED = json.loads((SAMPLES / "samples.json").read_text(encoding="utf-8"))
OBJECTS = {"u_shape.png": 1, "cells.png": 16, "rings.png": 5, "noisy.png": 2}


@pytest.fixture(scope="module")
def redrawn(tmp_path_factory):
    """Folder with the samples drawn anew."""
    folder = tmp_path_factory.mktemp("samples")
    specification = importlib.util.spec_from_file_location("make_samples", SAMPLES / "make_samples.py")
    script = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(script)
    script.write(folder)
    return folder


def test_every_sample_file_is_listed():
    assert {entry["file"] for entry in LISTED} == {path.name for path in SAMPLES.glob("*.png")} == set(OBJECTS)


def test_the_list_is_what_the_script_writes(redrawn):
    assert json.loads((redrawn / "samples.json").read_text(encoding="utf-8")) == LISTED


@pytest.mark.parametrize("file", OBJECTS)
def test_the_images_are_what_the_script_draws(redrawn, file):
    kept, drawn = (np.asarray(PIL.Image.open(folder / file), dtype=int) for folder in (SAMPLES, redrawn))
    assert kept.shape == drawn.shape
    # another processor may round a value that lies between two grey levels the other way
    assert np.abs(kept - drawn).max() <= 1
    assert np.mean(kept != drawn) < 1e-3


@pytest.mark.parametrize("entry", LISTED, ids=lambda entry: entry["file"])
def test_the_start_of_a_sample_lies_in_the_image_and_finds_its_objects(entry):
    image = cpm.load_image(SAMPLES / entry["file"])
    seeds = np.concatenate([cpm.circle((row, col), radius) for row, col, radius in entry["circles"]])
    assert np.all((seeds >= 0) & (seeds <= np.array(image.shape) - 1))
    result = cpm.segment(image, seeds, cpm.PRESETS[entry["preset"]])
    assert sum(contour.closed for contour in result.contours) == OBJECTS[entry["file"]]
