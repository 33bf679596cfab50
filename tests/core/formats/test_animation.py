"""Animations: what other programs find in the files are the frames, at their times."""

import importlib.machinery
import sys
import types
from pathlib import Path

import numpy as np
import PIL.Image
import pytest

from cpm_core.formats.animation import ANIMATIONS_WRITABLE, check_animation, write_animation, write_picture

SUFFIXES = (".gif", ".png")


def scene(step, shape=(75, 101)):
    """A picture of few colours with a dot that moves."""
    frame = np.zeros((*shape, 3), np.uint8)
    frame[:] = np.linspace(20, 235, shape[1]).astype(np.uint8)[:, None] // 8 * 8
    frame[8:10, 5 + 7 * step : 7 + 7 * step] = (0xF0, 0xE4, 0x42)
    return frame


def frames_of(path):
    """Frames (N, H, W, 3) and their durations [ms], as Pillow finds them."""
    with PIL.Image.open(path) as image:
        shown, durations = [], []
        for number in range(image.n_frames):
            image.seek(number)
            shown.append(np.asarray(image.convert("RGB")))
            durations.append(image.info["duration"])
        assert image.info["loop"] == 0
    return np.array(shown), durations


class StopError(Exception):
    """Whoever counts the frames wants no more."""


def stop_at(last):
    """Counts frames, and raises after so many."""

    def count(number):
        if number > last:
            raise StopError

    return count


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_all_frames_are_there_for_their_time(tmp_path, suffix):
    seen = []
    steps = [scene(step) for step in range(7)]
    write_animation(iter(steps), tmp_path / f"a{suffix}", 12.5, progress=seen.append)
    shown, durations = frames_of(tmp_path / f"a{suffix}")
    assert np.array_equal(shown, steps)
    assert durations == [80.0] * 7
    assert seen == [1, 2, 3, 4, 5, 6, 7]
    assert [path.name for path in tmp_path.iterdir()] == [f"a{suffix}"]


def test_times_do_not_drift_where_hundredths_do_not_suffice(tmp_path):
    write_animation((scene(0) + np.uint8(k % 20) for k in range(30)), tmp_path / "a.gif", 30.0)
    durations = frames_of(tmp_path / "a.gif")[1]
    assert set(durations) == {30, 40}
    assert sum(durations) == 1000


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_cancelled_at_any_frame_it_leaves_the_old_file(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    path.write_bytes(b"old")
    for last in range(4):
        drawn = []

        def drawing(drawn=drawn):
            for step in range(10):
                drawn.append(step)
                yield scene(step)

        with pytest.raises(StopError):
            write_animation(drawing(), path, progress=stop_at(last))
        assert len(drawn) <= last + 1
        assert path.read_bytes() == b"old"
        assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_frame_that_is_none_or_of_another_size_leaves_nothing(tmp_path, suffix):
    for frames, sentence in (
        ([], "would be an animation without frames"),
        ([scene(0), scene(1, (75, 99))], r"of shape \(75, 99, 3\)"),
        ([scene(0), scene(1)[..., 0]], r"holds uint8 of shape \(75, 101\)"),
        ([scene(0) / 2.0], "holds float64"),
    ):
        with pytest.raises(ValueError, match=sentence):
            write_animation(frames, tmp_path / f"a{suffix}")
        assert list(tmp_path.iterdir()) == []


def test_speeds_that_cannot_be_shown_are_refused(tmp_path):
    for speed in (0.0, -1.0, 1000.0, float("nan")):
        with pytest.raises(ValueError, match=r"frames_per_second is .* but must be a number from 0\.1 to 120"):
            write_animation([scene(0)], tmp_path / "a.png", speed)
    with pytest.raises(ValueError, match=r"from 0\.1 to 50"):
        write_animation([scene(0)], tmp_path / "a.gif", 60)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "sentence"),
    [("a.avi", r"choose one of \.gif"), ("a", "has no suffix"), ("none/a.gif", "there is no such folder")],
)
def test_places_where_no_animation_can_be_are_told_beforehand(tmp_path, name, sentence):
    with pytest.raises(ValueError, match=sentence) as caught:
        check_animation(tmp_path / name)
    assert all(suffix in str(caught.value) for suffix in ANIMATIONS_WRITABLE) or "folder" in sentence


class Ffmpeg:
    """Replaces the optional encoder: keeps its frames, and writes them unchanged."""

    def __init__(self, monkeypatch, fail=False):
        self.given, self.frames, self.fail = {}, [], fail
        module = types.ModuleType("imageio_ffmpeg")
        module.__spec__ = importlib.machinery.ModuleSpec("imageio_ffmpeg", None)
        module.write_frames = self.write_frames
        monkeypatch.setitem(sys.modules, "imageio_ffmpeg", module)

    def write_frames(self, path, size, **options):
        self.given = {"size": size, **options}
        with Path(path).open("wb") as stream:
            try:
                while True:
                    frame = yield
                    if self.fail:
                        raise OSError("broken pipe")
                    self.frames.append(np.array(frame))
                    stream.write(bytes(frame))
            finally:
                stream.write(b"end")


def test_films_have_even_sizes_with_the_last_row_and_column_repeated(tmp_path, monkeypatch):
    encoder = Ffmpeg(monkeypatch)
    steps = [scene(step) for step in range(3)]
    write_animation(steps, tmp_path / "a.mp4", 24)
    assert (encoder.given["size"], encoder.given["fps"], encoder.given["codec"]) == (
        (102, 76),
        24,
        "libx264",
    )
    for frame, step in zip(encoder.frames, steps, strict=True):
        assert frame.shape == (76, 102, 3)
        assert np.array_equal(frame[:75, :101], step)
        assert np.array_equal(frame[75, :101], step[74])
        assert np.array_equal(frame[:75, 101], step[:, 100])
    assert (tmp_path / "a.mp4").read_bytes().endswith(b"end")
    assert [path.name for path in tmp_path.iterdir()] == ["a.mp4"]


def test_a_film_that_is_cancelled_or_fails_leaves_nothing(tmp_path, monkeypatch):
    Ffmpeg(monkeypatch)
    frames = (scene(step) for step in range(9))
    with pytest.raises(StopError):
        write_animation(frames, tmp_path / "a.mp4", progress=stop_at(2))
    assert list(tmp_path.iterdir()) == []
    Ffmpeg(monkeypatch, fail=True)
    with pytest.raises(ValueError, match=r"The encoder of \.mp4 files does not work here \(broken pipe\)"):
        write_animation([scene(0)], tmp_path / "a.mp4")
    assert list(tmp_path.iterdir()) == []


def test_without_the_encoder_a_sentence_says_what_to_install_and_what_to_take_instead(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    for action in (
        lambda: check_animation(tmp_path / "a.mp4"),
        lambda: write_animation([scene(0)], tmp_path / "a.mp4"),
    ):
        with pytest.raises(ValueError, match=r"unlike \.gif and APNG .* run pip install imageio-ffmpeg\."):
            action()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_an_animation_carries_a_comment_and_the_same_frames(tmp_path, suffix):
    steps, comment = [scene(step) for step in range(3)], "found by " * 80
    write_animation(steps, tmp_path / f"a{suffix}", comment=comment)
    with PIL.Image.open(tmp_path / f"a{suffix}") as picture:
        told = picture.info.get("Description") or picture.info["comment"].decode("ascii")
    assert told == comment
    assert np.array_equal(frames_of(tmp_path / f"a{suffix}")[0], steps)


def test_a_film_and_a_picture_carry_a_comment(tmp_path, monkeypatch):
    encoder = Ffmpeg(monkeypatch)
    write_animation([scene(0)], tmp_path / "a.mp4", 24, comment="by CPM")
    assert encoder.given["output_params"][-2:] == ["-metadata", "comment=by CPM"]
    write_picture(scene(0), tmp_path / "a.png", "by CPM")
    with PIL.Image.open(tmp_path / "a.png") as picture:
        assert picture.info["Description"] == "by CPM"
