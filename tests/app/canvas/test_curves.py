"""Curves: what is not in sight is not drawn, and that is never seen."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtCore import Qt

from app.views.canvas.items.curves import Curves, boxes

paths = st.lists(
    st.lists(st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)), min_size=1, max_size=9).map(np.array), max_size=6
)


@given(paths)
def test_boxes_are_the_least_and_largest_coordinates_of_each_path(drawn) -> None:
    low, high = boxes(drawn)
    assert low.T.tolist() == [path.min(axis=0).tolist() for path in drawn]
    assert high.T.tolist() == [path.max(axis=0).tolist() for path in drawn]


@pytest.mark.parametrize("factor", [0.4, 1.0, 1.3, 3.0, 14.0])
def test_what_is_left_out_is_out_of_sight(ready, hand, monkeypatch, factor) -> None:
    hand.key(Qt.Key.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: ready.session.idle and hand.canvas.layers.contours.counts == (1, 0))
    ready.canvas_area.hint.hide()
    drawn: list[int] = []
    in_sight = Curves._visible

    def counted(curves, painter, zoom):
        drawn.append(len(in_sight(curves, painter, zoom)))
        return in_sight(curves, painter, zoom)

    monkeypatch.setattr(Curves, "_visible", counted)
    hand.canvas.zoom(factor, hand.canvas.point((32.0, 50.0)))
    seen = hand.canvas.grab().toImage()
    few = sum(drawn)
    monkeypatch.setattr(Curves, "_visible", lambda curves, painter, zoom: list(range(len(curves._pieces))))
    for item in hand.canvas.layers.contours._lines:
        item.update()
    assert hand.canvas.grab().toImage() == seen
    monkeypatch.setattr(Curves, "_visible", counted)
    if factor > 10.0:
        whole = sum(len(item._pieces) for item in hand.canvas.layers.contours._lines)
        assert 0 < few < whole * len(drawn)
