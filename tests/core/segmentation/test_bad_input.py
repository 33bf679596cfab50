"""What cannot be a volume, a start or a parameter is refused in one sentence, before anything is computed."""

import numpy as np
import pytest

import cpm_core as cpm
from cpm_core.numerics import memory

VOLUME = cpm.PRESETS["volume"]
SEEDS = cpm.sphere((10.0, 10.0, 10.0), 3.0, 20)


def ball(side=20):
    away = np.linalg.norm(np.moveaxis(np.indices((side,) * 3), 0, -1) - 10.0, axis=-1)
    return 200.0 * np.clip(6.5 - away, 0.0, 1.0)


def with_nan():
    values = ball()
    values[3, 4, 5] = np.nan
    return values


CASES = {
    "one plane": (lambda: ball()[:1], r"image has 1 x 20 x 20 voxels, but a volume needs at least 8 planes"),
    "few planes": (lambda: ball()[:7], r"image has 7 x 20 x 20 voxels, but a volume needs at least 8 planes"),
    "two sides": (lambda: cpm.Image(ball(), spacing=(1.0, 1.0)), r"spacing of image is .* must be three positive"),
    "no side": (lambda: cpm.Image(ball(), spacing=(0.0, 1.0, 1.0)), r"spacing of image is .* must be three positive"),
    "below zero": (lambda: cpm.Image(ball(), spacing=(1.0, -1.0, 1.0)), r"spacing of image is .* three positive"),
    "not a number": (lambda: cpm.Image(ball(), spacing=(1.0, np.nan, 1.0)), r"spacing of image is .* three positive"),
    "constant": (lambda: np.full((20, 20, 20), 3.0), r"image is constant \(3 everywhere\) and has no edges"),
    "no data": (lambda: np.full((20, 20, 20), np.nan), r"image holds no data: all its values are NaN or masked"),
    "infinite": (
        lambda: np.where(np.isnan(with_nan()), np.inf, ball()),
        r"image holds 1 infinite value",
    ),
    "complex": (lambda: ball() + 1j, r"holds values of type complex128, but gray levels must be real numbers"),
    "four axes": (lambda: ball()[None], r"image has 4 dimensions \(1, 20, 20, 20\)"),
}


def in_one_sentence(caught):
    text = str(caught.value)
    assert "\n" not in text
    assert text.endswith(".")
    assert ". " not in text


@pytest.mark.parametrize("run", [cpm.segment, lambda values, _seeds, parameters: cpm.Engine(values, parameters)])
@pytest.mark.parametrize("name", CASES)
def test_what_is_no_volume_is_refused(name, run):
    make, says = CASES[name]
    with pytest.raises(ValueError, match=says) as caught:
        run(make(), SEEDS, VOLUME)
    in_one_sentence(caught)


@pytest.mark.parametrize("run", [cpm.segment, lambda values, _seeds, parameters: cpm.Engine(values, parameters)])
def test_a_volume_without_room_in_memory_is_refused_with_the_size_that_fits(monkeypatch, run):
    values = ball(64)
    monkeypatch.setattr(memory, "available_memory", lambda: 1e6)
    with pytest.raises(
        ValueError, match=r"64 × 64 × 64 px, which need .* GB of memory, .* about (\d+) × \1 × \1 px"
    ) as caught:
        run(values, SEEDS, VOLUME)
    in_one_sentence(caught)


@pytest.mark.parametrize(
    ("seeds", "says"),
    [
        ([(50.0, 3.0, 3.0)], r"none of the 1 starting particles lies inside the image \(20 x 20 x 20 pixels\)"),
        ([(5.0, 3.0)], r"the starting particles have the shape \(1, 2\) but must be \(N, 3\)"),
        ([(5.0, 3.0, np.nan)], r"1 coordinates of the starting particles are not finite"),
        ([], r"there are no particles to start with"),
    ],
)
def test_a_start_that_cannot_be_is_refused(seeds, says):
    engine = cpm.Engine(ball(), VOLUME)
    for run in (lambda: cpm.segment(ball(), seeds, VOLUME), lambda: engine.start(seeds)):
        with pytest.raises(ValueError, match=says) as caught:
            run()
        in_one_sentence(caught)
