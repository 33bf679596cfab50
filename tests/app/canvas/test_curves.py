"""Curves: pieces outside the visible part are not painted, and the picture is the same."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtCore import Qt

from app.views.canvas.items.curves import Curves, boxes

pytestmark = pytest.mark.shared_window

paths = st.lists(
    st.lists(st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)), min_size=1, max_size=9).map(np.array), max_size=6
)


@given(paths)
def test_boxes_are_the_least_and_largest_coordinates_of_each_path(drawn) -> None:
    low, high = boxes(drawn)
    assert low.T.tolist() == [path.min(axis=0).tolist() for path in drawn]
    assert high.T.tolist() == [path.max(axis=0).tolist() for path in drawn]


def test_pieces_that_are_not_painted_are_not_visible(ready, hand, monkeypatch) -> None:
    hand.key(Qt.Key.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: ready.session.idle and hand.canvas.layers.contours.counts == (1, 0))
    ready.canvas_area.hint.hide()
    drawn: list[int] = []
    visible = Curves._visible

    def counted(curves, painter, zoom):
        drawn.append(len(visible(curves, painter, zoom)))
        return visible(curves, painter, zoom)

    lines = [item for item, _ in hand.canvas.layers.contours._items if isinstance(item, Curves)]
    for factor in (0.4, 1.0, 1.3, 3.0, 14.0):
        drawn.clear()
        hand.canvas.fit()
        monkeypatch.setattr(Curves, "_visible", counted)
        for item in lines:
            item.update()
        hand.canvas.zoom(factor, hand.canvas.point((32.0, 50.0)))
        seen = hand.canvas.grab().toImage()
        few = sum(drawn)
        monkeypatch.setattr(Curves, "_visible", lambda curves, painter, zoom: list(range(len(curves._pieces))))
        for item in lines:
            item.update()
        assert hand.canvas.grab().toImage() == seen
        if factor > 10.0:
            whole = sum(len(item._pieces) for item in lines)
            assert 0 < few < whole * len(drawn)
