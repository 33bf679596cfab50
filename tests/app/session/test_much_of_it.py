"""Neither a million letters nor twenty thousand corners keep the window waiting."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from cpm_app.model.document import edits
from cpm_app.model.text.language import MAX_SHOWN_LETTERS

from cpm_core.shapes import Barrier, Polygon, PolygonRegion
from tests.app.session.test_never_blocks import Watch

pytestmark = pytest.mark.shared_window

LONG = "a" * 1_000_000
CORNERS = 20_000
MOST_CALLS = 4 * CORNERS
"""Calls of Python in one gesture: few for each corner; the checks of the lines took 16 for each."""


def around(corners: int = CORNERS) -> tuple[tuple[float, float], ...]:
    angle = np.linspace(0.0, 2.0 * np.pi, corners, endpoint=False)
    radius = 26.0 + 2.0 * np.sin(40.0 * angle)
    return tuple(zip((32.0 + radius * np.sin(angle)).tolist(), (32.0 + radius * np.cos(angle)).tolist(), strict=True))


HOSTILE = {
    "path": {"image": {"path": LONG}},
    "name": {"image": {"path": "a.png"}, "objects": {"items": [{"number": 1, "clicks": [], "name": LONG}]}},
    "class": {"image": {"path": "a.png"}, "objects": {"classes": [{"name": LONG, "color": "#ffffff"}]}},
    "mode": {"image": {"path": "a.png"}, "mode": LONG},
    "view": {"image": {"path": "disc.npy"}, "view": {LONG: LONG, "layers": LONG}},
    "unknown": {"image": {"path": "disc.npy"}, LONG: LONG},
    "parameter": {"image": {"path": "disc.npy"}, "parameters": {LONG: 1}},
    "channel": {"image": {"path": "disc.npy"}, "parameters": {"channel": LONG}},
}


@pytest.mark.parametrize("content", HOSTILE.values(), ids=HOSTILE)
def test_a_session_with_a_million_letters_shows_only_few_of_them(ready, hand, tmp_path, content) -> None:
    path, opened = tmp_path / "long.cpm", ready.session.store.image_generation
    path.write_text(json.dumps({"cpm-session": 3, **content}))
    ready.session.open_file(path)
    shown = ready.canvas_area.messages
    hand.wait(lambda: bool(shown.text) or ready.session.store.image_generation > opened)
    assert len(shown.text) <= MAX_SHOWN_LETTERS


@pytest.mark.parametrize("kind", [Barrier, PolygonRegion, Polygon])
def test_a_gesture_on_a_line_of_many_corners_takes_few_calls(window, hand, kind) -> None:
    session, shape = window.session, kind(around())
    corner = shape.points[0]
    window.canvas_area.use_tool("select")
    gestures = {
        "drawing": lambda: session.edit("draw", lambda document: edits.add_shape(document, shape)),
        "pointing": lambda: hand.move(32.0, 32.0),
        "selecting": lambda: hand.press(*corner),
        "dragging": lambda: hand.move(corner[0] + 1.0, corner[1] + 1.0),
        "letting go": lambda: hand.release(corner[0] + 1.0, corner[1] + 1.0),
        "undoing": session.undo,
        "redoing": session.redo,
        "deleting": lambda: (session.select_shape(0), session.delete_selected_shape()),
    }
    for name, gesture in gestures.items():
        with Watch() as watch:
            gesture()
        assert watch.most <= MOST_CALLS, name
    assert session.document.shapes == ()


def test_a_file_whose_name_is_too_long_is_refused_in_one_sentence(ready, hand, tmp_path) -> None:
    ready.session.open_file(Path(tmp_path / (LONG + ".png")))
    hand.wait(lambda: bool(ready.canvas_area.messages.text))
    assert len(ready.canvas_area.messages.text) <= MAX_SHOWN_LETTERS
