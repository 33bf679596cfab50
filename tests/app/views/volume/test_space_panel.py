"""The view in space follows mouse, keys and controls, and never shows less than it was asked for."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from cpm_app.model.display.display_image import IntensityWindow
from cpm_app.model.space.triangles import SurfaceMesh
from cpm_app.model.space.view_in_space import ShownParticles, ViewInSpace
from cpm_app.model.space.voxels import ShadedVolume
from cpm_app.model.volume.slices import Slices
from cpm_app.session.features.workspace import Workspace
from cpm_app.views.volume.space_panel import SpacePanel
from PySide6.QtCore import QCoreApplication, QEvent, QPoint, Qt
from PySide6.QtGui import QColor, QWheelEvent
from pytestqt.qtbot import QtBot

from cpm_core.image.image import Image
from cpm_core.image.surface import Surface

LEFT = Qt.MouseButton.LeftButton
NONE, SHIFT, CTRL = (
    Qt.KeyboardModifier.NoModifier,
    Qt.KeyboardModifier.ShiftModifier,
    Qt.KeyboardModifier.ControlModifier,
)
SPACING = (2.0, 1.0, 1.0)

CUBE = Surface(
    np.array([[p, r, c] for p in (5.0, 15.0) for r in (10.0, 30.0) for c in (10.0, 30.0)]),
    np.array(
        [
            [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
            [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
        ]
    ),
    SPACING,
)  # fmt: skip


def contents(**more: object) -> ViewInSpace:
    voxels = np.zeros((21, 41, 41), np.uint8)
    voxels[8:13, 15:26, 15:26] = 255
    return of(voxels, SPACING, "µm", **more)


def of(voxels: np.ndarray, spacing: tuple[float, ...], unit: str | None, **more: object) -> ViewInSpace:
    image = Image(voxels.astype(float), spacing, unit)
    return ViewInSpace(
        image, ShadedVolume(image.values, IntensityWindow(0.0, 255.0)), Slices.through_middle(image), **more
    )


@pytest.fixture
def panel(qtbot: QtBot, workspace: Workspace) -> Iterator[SpacePanel]:
    made = SpacePanel(workspace.session)
    made.view.resize(700, 380)
    for part in (made, made.view):
        part.show()
        qtbot.waitExposed(part)
    made.show_contents(contents(mesh=SurfaceMesh(CUBE)))
    settle(qtbot, made)
    yield made
    settle(qtbot, made)
    for part in (made, made.view):
        part.close()
        part.deleteLater()
    QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)


def settle(qtbot: QtBot, panel: SpacePanel) -> None:
    """Wait for the whole picture; the first one compiles the loops."""
    qtbot.waitUntil(lambda: panel.view.is_idle, timeout=60_000)


def center(panel: SpacePanel) -> QPoint:
    return panel.view.rect().center()


def colors(panel: SpacePanel) -> set[str]:
    image = panel.view.grab().toImage()
    return {QColor(image.pixel(x, y)).name() for x in range(0, image.width(), 4) for y in range(0, image.height(), 4)}


def greens(panel: SpacePanel) -> list[str]:
    return [name for name in colors(panel) if QColor(name).green() > 150 and QColor(name).red() < 50]


def drag(qtbot: QtBot, panel: SpacePanel, way: QPoint, keys: Qt.KeyboardModifier = NONE) -> None:
    view, begin = panel.view, center(panel)
    qtbot.mousePress(view, LEFT, keys, begin)
    for part in (0.5, 1.0):
        qtbot.mouseMove(view, begin + part * way)
    qtbot.mouseRelease(view, LEFT, keys, begin + way)
    settle(qtbot, panel)


def test_dragging_turns_moves_and_rolls(qtbot, panel) -> None:
    before = panel.view.camera
    drag(qtbot, panel, QPoint(60, 0))
    turned = panel.view.camera
    assert turned.axes[1] == pytest.approx(before.axes[1])
    assert turned.axes[0] @ before.axes[0] < 0.99
    assert turned.center == pytest.approx(before.center)
    drag(qtbot, panel, QPoint(0, 30), keys=SHIFT)
    moved = panel.view.camera
    assert moved.axes == pytest.approx(turned.axes)
    assert (turned.center - moved.center) @ turned.axes[1] * moved.scale > 10
    drag(qtbot, panel, QPoint(40, 0), keys=CTRL)
    assert panel.view.camera.axes[2] == pytest.approx(moved.axes[2])
    assert panel.view.camera.axes[0] @ moved.axes[0] < 0.99
    qtbot.mouseDClick(panel.view, LEFT, NONE, center(panel))
    assert panel.view.camera.axes == pytest.approx(before.axes)
    assert panel.view.camera.center == pytest.approx(before.center)


def test_the_wheel_enlarges_what_is_under_the_pointer(qtbot, panel) -> None:
    view, before = panel.view, panel.view.camera
    at = center(panel) + QPoint(80, 40)
    event = QWheelEvent(
        at.toPointF(), view.mapToGlobal(at).toPointF(), QPoint(), QPoint(0, 120), Qt.MouseButton.NoButton, NONE,
        Qt.ScrollPhase.NoScrollPhase, False,
    )  # fmt: skip
    QCoreApplication.sendEvent(view, event)
    after = view.camera
    assert after.scale > 1.1 * before.scale
    right, down = 80.0, 40.0
    under = [
        camera.center + (right * camera.axes[0] + down * camera.axes[1]) / camera.scale for camera in (before, after)
    ]
    assert under[0] == pytest.approx(under[1], abs=0.5)


def test_keys_turn_enlarge_and_look_along_each_axis(qtbot, panel) -> None:
    view, first = panel.view, panel.view.camera
    view.setFocus()
    for axis, key in enumerate((Qt.Key.Key_1, Qt.Key.Key_2, Qt.Key.Key_3)):
        qtbot.keyClick(view, key)
        assert abs(view.camera.axes[2, axis]) == pytest.approx(1.0)
    qtbot.keyClick(view, Qt.Key.Key_Plus)
    assert view.camera.scale > first.scale
    qtbot.keyClick(view, Qt.Key.Key_Left)
    assert abs(view.camera.axes[2, 2]) < 0.999
    qtbot.keyClick(view, Qt.Key.Key_Home)
    assert view.camera.axes == pytest.approx(first.axes)


def test_a_click_picks_the_place_that_is_seen(qtbot, panel) -> None:
    panel.view.setFocus()
    qtbot.keyClick(panel.view, Qt.Key.Key_1)
    settle(qtbot, panel)
    with qtbot.waitSignal(panel.view.picked) as seen:
        qtbot.mouseClick(panel.view, LEFT, NONE, center(panel))
    assert seen.args[0] == pytest.approx((5.0, 20.0, 20.0), abs=0.6)
    with qtbot.assertNotEmitted(panel.view.picked):
        qtbot.mouseClick(panel.view, LEFT, NONE, QPoint(3, 3))


def test_controls_show_and_hide_each_part(qtbot, panel) -> None:
    places = np.array([[10.0, 20.0, c] for c in range(41)])
    shown = contents(mesh=SurfaceMesh(CUBE), particles=ShownParticles(places, np.full((41, 3), (0, 255, 0), np.uint8)))
    panel.show_contents(shown)
    parts = panel.bar.checks
    for name, check in parts.items():
        before = panel.bar.shown
        qtbot.mouseClick(check, LEFT, NONE, QPoint(8, check.height() // 2))
        assert getattr(panel.bar.shown, name) != getattr(before, name)
    for name, check in parts.items():
        check.setChecked(name == "particles")
    settle(qtbot, panel)
    assert greens(panel)
    parts["particles"].setChecked(False)
    settle(qtbot, panel)
    assert not greens(panel)
    parts["projection"].setChecked(True)
    settle(qtbot, panel)
    assert "#ffffff" in colors(panel)


def test_slices_and_brightest_voxels_replace_one_another(qtbot, panel) -> None:
    panel.show_contents(contents())
    parts = panel.bar.checks
    for name, other in (("slices", "projection"), ("projection", "slices"), ("slices", "projection")):
        qtbot.mouseClick(parts[name], LEFT, NONE, QPoint(8, parts[name].height() // 2))
        assert (parts[name].isChecked(), parts[other].isChecked()) == (True, False)
        assert (getattr(panel.bar.shown, name), getattr(panel.bar.shown, other)) == (True, False)
