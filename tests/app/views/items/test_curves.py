"""Curves: what is outside the visible part or has not changed is not painted, and the picture is the same."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
import pytest
from cpm_app.views.canvas.image_view import ImageView
from cpm_app.views.items import curves as drawing
from cpm_app.views.items.curves import Curves, Fills, bounding_boxes
from cpm_app.views.widgets.turns import Turns
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtCore import Qt

from tests.app.reading import contour_counts

pytestmark = pytest.mark.shared_window

paths = st.lists(
    st.lists(st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)), min_size=1, max_size=9).map(np.array), max_size=6
)


@given(paths)
def test_boxes_are_the_least_and_largest_coordinates_of_each_path(drawn) -> None:
    expected = [[*path.min(axis=0), *path.max(axis=0)] for path in drawn]
    assert bounding_boxes(drawn).T.tolist() == expected


def test_pieces_that_are_not_painted_are_not_visible(ready, hand, monkeypatch) -> None:
    hand.key(Qt.Key.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: ready.session.idle and contour_counts(hand.canvas.layers.contours) == (1, 0))
    ready.canvas_area.hint.hide()
    visible: list[np.ndarray] = []
    meeting = drawing.find_overlapping

    def noted(areas, area):
        visible.append(meeting(areas, area))
        return visible[-1]

    lines = [item for item, _ in hand.canvas.layers.contours._items if isinstance(item, Curves)]
    for factor in (0.4, 1.0, 1.3, 3.0, 14.0):
        visible.clear()
        hand.canvas.fit_image()
        monkeypatch.setattr(drawing, "find_overlapping", noted)
        for item in lines:
            item.update()
        hand.canvas.zoom_by(factor, hand.canvas.map_from_image((32.0, 50.0)))
        seen = hand.canvas.grab().toImage()
        monkeypatch.setattr(drawing, "find_overlapping", lambda areas, _: np.ones(areas.shape[1], bool))
        for item in lines:
            item.update()
        assert hand.canvas.grab().toImage() == seen
        if factor > 10.0:
            assert 0 < sum(mask.sum() for mask in visible) < sum(map(len, visible))


def view_with(qtbot, item: pg.GraphicsObject) -> ImageView:
    """A view of a square of 400 px with an item."""
    shown = ImageView()
    qtbot.addWidget(shown)
    shown.resize(400, 400)
    shown.view.setRange(xRange=(0.0, 400.0), yRange=(0.0, 400.0), padding=0.0)
    shown.view.addItem(item, ignoreBounds=True)
    item.set_image_shape((400, 400))
    shown.show()
    return shown


def rings(chance: np.random.Generator, count: int) -> list[np.ndarray]:
    angle = np.linspace(0.0, 2.0 * np.pi, 90)
    ring = np.stack([np.sin(angle), np.cos(angle)], axis=1)
    return [chance.uniform(5.0, 20.0) * ring + chance.uniform((0.0, 0.0), (400.0, 400.0)) for _ in range(count)]


@pytest.mark.parametrize("kind", ["curves", "fills"])
def test_a_picture_that_is_drawn_in_turns_is_that_drawn_at_once(qtbot, kind) -> None:
    def make() -> Curves | Fills:
        return Curves("#ffffff", 1.0) if kind == "curves" else Fills(1.0)

    def show(item: Curves | Fills, shown: list[np.ndarray], color: str) -> None:
        colors = [color if index % 3 else "#aa5500" for index in range(len(shown))]
        if isinstance(item, Curves):
            item.show_paths(shown, colors)
        else:
            item.show_areas([([ring], color, 0.3) for ring, color in zip(shown, colors, strict=True)])

    item, chance = make(), np.random.default_rng(5)
    view = view_with(qtbot, item)
    known = rings(chance, 250)
    for shown, color in (
        (known, "#00ff00"),
        (known[:200], "#00ff00"),
        (known[60:] + rings(chance, 9), "#00ff00"),
        (known[::-1], "#00ff00"),
        (known, "#0000ff"),
        (known[3:5], "#0000ff"),
    ):
        show(item, shown, color)
        turns = view.scene().findChild(Turns)
        qtbot.waitUntil(lambda turns=turns: turns.is_idle)
        qtbot.wait(30)
        again = make()
        other = view_with(qtbot, again)
        show(again, shown, color)
        assert view.grab().toImage() == other.grab().toImage()
        other.hide()


def test_a_change_of_one_curve_paints_only_those_near_it_again(qtbot) -> None:
    item = Curves("#ffffff", 1.0)
    view = view_with(qtbot, item)
    known = [np.array([(row, col), (row, col + 8.0)]) for row in range(5, 400, 20) for col in range(5, 400, 20)]
    item.show_paths(known)
    view.grab()
    painted: list[list[int]] = []
    seen = item.find_visible_parts
    item.find_visible_parts = lambda *given: painted.append(seen(*given)[0]) or seen(*given)
    item.show_paths([*known[:100], *known[101:]])
    qtbot.waitUntil(lambda: bool(painted))
    assert sum(map(len, painted)) < 9
