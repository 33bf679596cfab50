"""Channels of color images: what they hold, and that all that looks at gray levels takes the chosen one."""

from __future__ import annotations

import json

import numpy as np
import PIL.Image
import pytest
from skimage.color import hed2rgb

from cpm_core import Engine, Parameters, cli, load_image, partition, segment
from cpm_core.formats import load_contours
from cpm_core.image.colors import Colors, extract_channel
from cpm_core.image.image import Image
from cpm_core.model.starts import circle
from cpm_core.results import objects_result
from cpm_core.shapes import Everywhere
from cpm_core.shapes.image_starts import SeedCache

SIDE = 64
ROW, COL = np.indices((SIDE, SIDE))
IN_RED, IN_BLUE = (np.hypot(ROW - 32, COL - col) < 11.0 for col in (18, 46))
"""A disc that is bright in the red channel alone, and one in the blue channel alone."""


def two_discs() -> np.ndarray:
    samples = np.full((SIDE, SIDE, 3), 60, np.uint8)
    samples[IN_RED, 0] = samples[IN_BLUE, 2] = 220
    samples[..., 1] = 40 + COL  # so that the green channel is not the same everywhere
    return samples


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    made = tmp_path_factory.mktemp("channels") / "discs.png"
    PIL.Image.fromarray(two_discs()).save(made)
    return made


@pytest.fixture(scope="module")
def image(path) -> Image:
    return load_image(path)


@pytest.mark.parametrize(("index", "channel"), list(enumerate(("red", "green", "blue"))))
@pytest.mark.parametrize("white", [255.0, 65535.0, 1.0])
def test_a_primary_color_is_its_samples_in_the_range_of_the_file(index, channel, white):
    samples = two_discs()
    found = extract_channel(np.zeros((SIDE, SIDE)), Colors(samples, white), channel)
    np.testing.assert_allclose(found, samples[..., index] * (white / 255.0), rtol=1e-12)
    assert found.dtype == np.float64


@pytest.mark.parametrize(("stain", "name"), list(enumerate(("hematoxylin", "eosin", "dab"))))
def test_a_stain_darkens_its_own_channel_and_no_other(stain, name):
    amounts = np.zeros((SIDE, SIDE, 3))
    amounts[IN_RED, stain] = 0.05
    colors = Colors(np.rint(255.0 * hed2rgb(amounts)).astype(np.uint8), 255.0)
    for other in ("hematoxylin", "eosin", "dab"):
        found = extract_channel(np.zeros((SIDE, SIDE)), colors, other)
        difference = found[~IN_RED].mean() - found[IN_RED].mean()
        assert (difference > 100.0) if other == name else abs(difference) < 10.0


def found_in(image: Image, channel: str):
    seeds = np.concatenate([circle((32.0, 18.0), 16.0), circle((32.0, 46.0), 16.0)])
    return segment(image, seeds, Parameters(scales=1, channel=channel))


@pytest.mark.parametrize(("channel", "col"), [("red", 18.0), ("blue", 46.0)])
def test_a_run_finds_what_is_in_its_channel_and_tells_it(image, channel, col, tmp_path):
    result = found_in(image, channel)
    closed = [contour for contour in result.contours if contour.closed]
    assert len(closed) == 1
    np.testing.assert_allclose(closed[0].points.mean(axis=0), (32.0, col), atol=1.5)
    assert result.channel == channel
    assert result.image is image
    cut = partition(result)
    assert cut.values[32, int(col)] == 220.0
    chosen = cut.select([[32.0, col]])
    assert abs(chosen.mask.sum() - IN_RED.sum()) < 40
    assert objects_result([chosen], image, channel=channel).channel == channel


def test_seeds_on_edges_are_those_of_the_channel(image):
    cache, start = SeedCache(image), Everywhere("gradient")
    for channel, inside in (("red", IN_RED), ("blue", IN_BLUE), ("red", IN_RED)):
        seeds = cache.seeds_for((start,), 1.0, channel=channel)[start]
        middle = np.argwhere(inside).mean(axis=0)
        assert len(seeds) > 10
        assert np.hypot(*(seeds - middle).T).max() < 16.0


def test_a_channel_without_edges_is_refused_in_words():
    samples = two_discs()
    samples[..., 1] = 60
    image = Image(samples @ (0.3, 0.6, 0.1), colors=Colors(samples, 255.0))
    with pytest.raises(ValueError, match="The channel green is the same everywhere and has no edges: choose another"):
        Engine(image, Parameters(channel="green"))


def test_the_command_line_takes_a_channel_and_tells_it_in_what_it_writes(path, tmp_path, capsys):
    target = tmp_path / "found.json"
    asked = ["run", str(path), "--circle", "32,46,16", "--scales", "1", "--export", str(target), "--channel"]
    assert cli.main([*asked, "blue"]) == 0
    assert "The channel blue of its colors was taken." in capsys.readouterr().err
    assert json.loads(target.read_text())["image"]["channel"] == "blue"
    assert load_contours(target)
    assert cli.main([*asked, "luminance"]) == 0
    assert "luminance" in capsys.readouterr().err
    assert "channel" not in json.loads(target.read_text())["image"]
    assert cli.main([*asked, "violet"]) == 2
    assert 'channel is "violet" but must be "luminance" or "red"' in capsys.readouterr().err
