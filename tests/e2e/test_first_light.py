"""From the start of the window to the exported files, as a new user works."""

from __future__ import annotations

import re

import numpy as np
import pytest
from cpm_app.model.document.samples import load_samples
from cpm_app.views.application import make_application
from cpm_app.views.features.files import StartFeature
from cpm_app.views.main_window import open_window
from PIL import Image as Picture
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor

from cpm_core.formats import ProjectImage, update_project
from tests.app.exporting import export
from tests.app.reading import contour_counts
from tests.e2e.conftest import PATIENCE


def test_the_first_press_of_run_recovers_the_u_and_export_writes_it(window, qtbot, tmp_path, monkeypatch) -> None:
    session = window.session
    assert session.document.image.name == "u_shape.png"
    assert window.panels["run"].status.state == "Ready"
    values = window.session.image.values
    qtbot.keyClick(window.canvas_area.canvas, Qt.Key.Key_Space)
    qtbot.waitUntil(lambda: session.status.phase == "finished", timeout=PATIENCE)
    qtbot.waitUntil(lambda: session.idle, timeout=PATIENCE)
    assert contour_counts(window.canvas_area.canvas.layers.contours) == (1, 0)
    paths = export(qtbot, window, tmp_path, "contours:.svg", "contours:.csv", "contours:.png")
    assert {"3 files", "1 contour"} <= set(re.findall(r"\d files|\d contour", window.canvas_area.messages.text))
    mask = np.asarray(Picture.open(paths[0]))
    assert mask.shape == values.shape
    inside, bright = mask > 0, values > 0.5 * (values.min() + values.max())
    # The mask is the bright U up to the pixels that its rim runs through.
    assert (inside != bright).sum() < 0.03 * bright.sum()


def test_the_proposal_is_drawn_in_its_color_and_its_contour_and_the_image_in_gray(window, qtbot) -> None:
    canvas = window.canvas_area.canvas
    qtbot.keyClick(canvas, Qt.Key.Key_Space)
    qtbot.waitUntil(lambda: window.session.status.phase == "finished", timeout=PATIENCE)
    qtbot.waitUntil(lambda: window.session.idle, timeout=PATIENCE)
    selection = window.workspace.object_selection
    qtbot.waitUntil(lambda: bool(selection.proposals), timeout=PATIENCE)

    def color(row: float, col: float) -> QColor:
        return picture.pixelColor(canvas.map_from_image((row, col)).toPoint() * canvas.devicePixelRatioF())

    (found,) = window.session.scene.contours
    shares = []
    for _ in range(2):
        picture = canvas.grab().toImage()
        drawn = [color(row, col) for row, col in found.points[::10]]
        shares.append(np.mean([seen.saturation() > 60 for seen in drawn]))
        qtbot.keyClick(canvas, Qt.Key.Key_X)
        qtbot.waitUntil(lambda: not selection.proposals, timeout=PATIENCE)
    assert shares[0] - shares[1] > 0.3  # particles are seen through the thin line of the contour
    values = window.session.image.values
    row, col = 4, 4  # outside of the contour, whose inside is tinted
    shade = 255 * (values[row, col] - values.min()) / (values.max() - values.min())
    assert color(row, col).value() == pytest.approx(shade, abs=2)
    assert color(row, col).saturation() == 0


def test_no_particle_crosses_a_barrier_drawn_by_hand(window, qtbot) -> None:
    session, canvas = window.session, window.canvas_area.canvas
    rows: list[np.ndarray] = []
    session.store.scene_changed.connect(
        lambda: session.scene.snapshot and rows.append(session.scene.snapshot.position[:, 0])
    )
    across = 160.0
    left, right = (canvas.map_from_image((across, col)).toPoint() for col in (-4.0, 260.0))
    qtbot.keyClick(canvas, Qt.Key.Key_B)
    qtbot.mousePress(canvas.viewport(), Qt.MouseButton.LeftButton, pos=left)
    for share in (0.25, 0.5, 0.75, 1.0):
        qtbot.mouseMove(canvas.viewport(), left + (right - left) * share)
    qtbot.mouseRelease(canvas.viewport(), Qt.MouseButton.LeftButton, pos=right)
    circle, barrier = session.document.shapes
    assert [row for row, _ in barrier.points] == pytest.approx([across] * len(barrier.points), abs=0.5)
    assert circle.center[0] + circle.radius < across - 1.0
    qtbot.keyClick(canvas, Qt.Key.Key_Space)
    qtbot.waitUntil(lambda: session.status.phase == "finished", timeout=PATIENCE)
    qtbot.waitUntil(lambda: session.idle, timeout=PATIENCE)
    # Without the barrier the U is followed to its foot, far below.
    assert max(row.max() for row in rows) < across + 0.5
    assert rows[-1].max() > across - 10.0
    assert sum(contour_counts(canvas.layers.contours)) >= 1


def test_every_sample_opens_ready_and_runs(window, qtbot) -> None:
    for sample in load_samples():
        window.session.open_file(sample.path)
        qtbot.waitUntil(lambda: window.session.idle, timeout=PATIENCE)
        assert window.session.document.image.name == sample.path.name
        assert window.session.document.parameters == sample.parameters
        assert window.session.document.shapes == sample.shapes
        window.session.run()
        qtbot.waitUntil(lambda: window.session.status.step >= 5, timeout=PATIENCE)
        window.session.reset()


def test_the_window_starts_on_the_first_image_of_a_folder_that_is_not_done(qtbot, tmp_path) -> None:
    folder = tmp_path / "plates"
    folder.mkdir()
    for name in ("a.png", "b.png"):
        Picture.fromarray(np.eye(64, dtype=np.uint8) * 200).save(folder / name)
    update_project(folder, lambda project: project.with_image("a.png", ProjectImage("done")))
    make_application()
    window = open_window(str(folder))
    session = window.session
    qtbot.waitUntil(lambda: session.document.image is not None and session.idle, timeout=PATIENCE)
    assert session.document.image.name == "b.png"
    window.close()
    window.deleteLater()


def test_a_file_that_is_not_an_image_is_reported_on_the_start_screen_and_no_sample_opens(qtbot, tmp_path) -> None:
    path = tmp_path / "notes.txt"
    path.write_text("no picture")
    make_application()
    window = open_window(str(path))
    screen = window.get_feature(StartFeature).screen
    qtbot.waitUntil(screen.isVisible, timeout=PATIENCE)
    assert screen.error_label.text().startswith("notes.txt ")
    assert window.session.document.image is None
    window.close()
    window.deleteLater()
