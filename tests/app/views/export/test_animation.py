"""Animations: every frame shows the particles of its step, and cancellation leaves no file behind."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import PIL.Image
import pytest
from cpm_app.session.tasks.tasks import BackgroundTask
from cpm_app.views.export.frames import AnimationPlan, sample_steps
from cpm_app.views.features.animation import AnimationFeature
from cpm_app.views.features.run import TasksFeature, TimelineFeature
from cpm_app.views.theme import theme
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor

from tests.app.exporting import asked, check, order

pytestmark = pytest.mark.shared_window

KEY = Qt.Key
LEFT = Qt.MouseButton.LeftButton
SIZE = (160, 160)


def feature(window) -> AnimationFeature:
    return window.get_feature(AnimationFeature)


def write(window, hand, path: Path, steps: tuple[int, ...]) -> None:
    task = feature(window).export_animation(1, AnimationPlan(steps, SIZE, 10), path)
    assert task is not None
    hand.wait(lambda: task.is_over and window.session.idle)


def picture(path: Path) -> np.ndarray:
    with PIL.Image.open(path) as opened:
        return np.array(opened.convert("RGB"))


def of_color(pixels: np.ndarray, color: str) -> int:
    """Number of pixels near a color; small discs are blended with the image below."""
    wanted = np.array(QColor(color).getRgb()[:3])
    return int((np.abs(pixels[..., :3].astype(int) - wanted).max(axis=-1) < 60).sum())


@pytest.mark.parametrize("suffix", [".gif", ".png"])
def test_an_animation_has_a_frame_for_each_step_with_its_particles(rested, hand, tmp_path, suffix) -> None:
    path = tmp_path / f"run{suffix}"
    steps = (1, 11, 21, 31, 41)
    before = (rested.session.status.step, rested.canvas_area.canvas.layers.particles.count)
    write(rested, hand, path, steps)
    with PIL.Image.open(path) as animation:
        assert (animation.n_frames, animation.size) == (len(steps), SIZE)
        frames = []
        for index in range(animation.n_frames):
            animation.seek(index)
            frames.append(np.array(animation.convert("RGB")))
    for frame in frames:
        assert of_color(frame, theme.MOVING_COLOR) + of_color(frame, theme.RESTING_COLOR) > 20
    # a ring of particles grows from radius 10 toward the rim of the disc
    assert all(not np.array_equal(one, other) for one, other in pairwise(frames))
    assert (rested.session.status.step, rested.canvas_area.canvas.layers.particles.count) == before
    assert rested.session.status.phase == "finished"
    assert list(tmp_path.glob("*run*")) == [path]


def test_frames_show_where_the_particles_of_their_step_are(rested, hand, tmp_path) -> None:
    path = tmp_path / "one.png"
    write(rested, hand, path, (6,))
    pixels = picture(path)
    navigation = rested.get_feature(TimelineFeature).navigation
    navigation.go_to(1, 6)
    hand.wait(lambda: rested.session.status.step == 6 and rested.session.idle)
    position = rested.canvas_area.canvas.layers.particles.position
    row, col = np.round((position + 0.5) * SIZE[0] / 64).astype(int).T
    assert len(position) > 10
    for at in zip(row, col, strict=True):
        around = pixels[at[0] - 3 : at[0] + 4, at[1] - 3 : at[1] + 4]
        assert of_color(around, theme.MOVING_COLOR) + of_color(around, theme.RESTING_COLOR) > 0


def test_cancellation_leaves_no_partial_file(rested, hand, tmp_path, monkeypatch) -> None:
    path = tmp_path / "run.gif"
    last = rested.session.status.step
    bar = rested.get_feature(TasksFeature).bar
    seen: list[int] = []
    advance = BackgroundTask.advance

    def give_up_after_three(task: BackgroundTask, fraction: float) -> None:
        seen.append(1)
        if len(seen) == 3:
            task.cancel()
        advance(task, fraction)

    monkeypatch.setattr(BackgroundTask, "advance", give_up_after_three)
    plan = AnimationPlan(sample_steps(0, last, 1), SIZE, 10)
    task = feature(rested).export_animation(1, plan, path)
    hand.wait(lambda: task.is_over and rested.session.idle)
    assert task.is_cancelled
    assert len(seen) == 3
    assert not bar.isVisible()
    assert [file.name for file in tmp_path.iterdir() if "run" in file.name] == []
    hand.wait(lambda: not feature(rested)._renderers)
    assert rested.session.status.step == last


def test_the_dialog_leads_to_a_file(rested, hand, tmp_path) -> None:
    dialog = asked(hand.qtbot, rested)
    check(hand.qtbot, dialog, "run:.gif")
    for field, keys in ((dialog.first, "2"), (dialog.last, "12"), (dialog.stride, "5"), (dialog.width_field, "100")):
        field.setFocus()
        field.selectAll()
        hand.qtbot.keyClicks(field, keys)
        hand.qtbot.keyClick(field, KEY.Key_Tab)
    assert dialog.animation_plan == AnimationPlan((2, 7, 12), (100, 100), 15)
    assert dialog._size.text() == "3 frames of 100 × 100 px"
    (written_to,) = order(hand.qtbot, rested, dialog, tmp_path)
    with PIL.Image.open(written_to) as animation:
        assert animation.n_frames == 3
    hand.wait(lambda: rested.session.idle)
    assert "_run.gif" in rested.canvas_area.messages.text


def test_frames_show_the_visible_part(rested, hand, tmp_path) -> None:
    rested.canvas_area.canvas.zoom_by(4.0)
    dialog = asked(hand.qtbot, rested)
    check(hand.qtbot, dialog, "run:.png")
    dialog.width_field.setValue(120)
    zoomed = dialog.animation_plan
    dialog.reject()
    path = tmp_path / "zoomed.png"
    task = feature(rested).export_animation(1, replace(zoomed, steps=(1,)), path)
    hand.wait(lambda: task.is_over and rested.session.idle)
    pixels = picture(path)
    assert pixels.shape[:2][::-1] == zoomed.size
    middle = pixels[pixels.shape[0] // 2, pixels.shape[1] // 2]
    assert middle.min() > 150  # the inside of the disc fills it
    assert np.median(pixels) > 150
