"""The tool that splits: touching nuclei whose parts are known, by clicks, lines and keys."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from cpm_app.model.document import objects
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QCursor

from cpm_core.image.region import Region
from cpm_core.numerics import polyline
from cpm_core.objects.segmented import SegmentedObject
from tests.app.reading import accepted_items

pytestmark = pytest.mark.shared_window

KEY, CONTROL, SHIFT = Qt.Key, Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier
ROW, COL = np.indices((64, 64))
NUCLEI = ((26.0, 22.0), 13.0), ((38.0, 43.0), 12.0)
"""They touch over a few px, and one is darker."""


def nucleus(number: int) -> np.ndarray:
    """The pixels of a nucleus, of those in both the ones that are deeper in it."""
    depths = [radius - np.hypot(ROW - center[0], COL - center[1]) for center, radius in NUCLEI]
    return (depths[number] > 0) & (depths[number] >= depths[1 - number])


@pytest.fixture
def image_file(tmp_path):
    path = tmp_path / "nuclei.npy"
    np.save(path, np.where(nucleus(0), 200.0, np.where(nucleus(1), 110.0, 20.0)))
    return path


@pytest.fixture
def pair(window, hand):
    """One object around both nuclei, with a name, and the tool in use with the edges at hand."""
    both = SegmentedObject(1, (), Region((objects.round_line(around()),)), name="both")
    window.session.edit("both", lambda d: replace(d, objects=replace(d.objects, items=(both,))))
    hand.canvas.setFocus()
    hand.key(KEY.Key_K)
    hand.move(5, 5)
    hand.wait(lambda: window.workspace.outline_editing.edges is not None)
    return window


def around() -> np.ndarray:
    """The line around both, shape (K, 2)."""
    angles = np.linspace(0.0, 2.0 * math.pi, 200, endpoint=False)
    disks = [np.stack([c[0] + r * np.sin(angles), c[1] + r * np.cos(angles)], axis=1) for c, r in NUCLEI]
    outer = [d[~polyline.points_inside(o, d)] for d, o in (disks, disks[::-1])]
    parts = [np.roll(part, -1 - int(np.linalg.norm(np.diff(part, axis=0), axis=1).argmax()), axis=0) for part in outer]
    return np.concatenate(parts)


def check_halves(window) -> None:
    for item, number in zip(accepted_items(window), (0, 1), strict=True):
        found, true = item.region.paste((64, 64)), nucleus(number)
        assert (found & true).sum() / (found | true).sum() > 0.93
    assert [(item.number, item.name) for item in accepted_items(window)] == [(1, "both"), (2, "")]


def test_two_clicks_part_touching_nuclei_in_one_step_of_undo(pair, hand) -> None:
    hint = pair.canvas_area.strip.hint
    assert "Click one half" in hint.text()
    hand.click(24, 20)
    hand.move(39, 44)
    assert "the other half of both" in hint.text()
    draft = hand.canvas.layers.drawing._draft.path
    hand.wait(lambda: draft.getData()[0] is not None and len(draft.getData()[0]) > 1)
    hand.click(39, 44)
    check_halves(pair)
    assert pair.workspace.object_list.selected_numbers == {1, 2}
    assert pair.session.history.undo_name == "split both"
    hand.key(KEY.Key_Z, CONTROL)
    (item,) = accepted_items(pair)
    assert item.name == "both"


@pytest.mark.parametrize("line", [((43, 28), (21, 41)), ((20, 45), (32, 31), (44, 21))])
def test_a_line_across_parts_them_too(pair, hand, line) -> None:
    hand.drag(*line)
    check_halves(pair)
    assert sum(map(len, accepted_items(pair)[0].gaps)) < 8, "it follows the edge between them"


def test_keys_part_them(pair, hand) -> None:
    QCursor.setPos(pair.mapToGlobal(QPoint(2, 2)))
    crosshair = pair.canvas_area.crosshair
    hand.key(KEY.Key_Return)
    for place in ((24.0, 20.0), (39.0, 44.0)):
        crosshair.move_by(place[0] - crosshair.position[0], place[1] - crosshair.position[1])
        hand.key(KEY.Key_Return)
    check_halves(pair)


def test_a_frozen_object_stays_and_escape_forgets_the_first_half(pair, hand) -> None:
    hand.click(24, 20)
    hand.key(KEY.Key_Escape)
    hand.click(39, 44)
    assert len(accepted_items(pair)) == 1 and hand.canvas.dispatcher.tool.has_draft
    pair.workspace.object_list.select_objects((1,))
    pair.workspace.object_commands.toggle_state("frozen")
    hand.drag((40, 20), (22, 44))
    assert len(accepted_items(pair)) == 1 and "frozen" in pair.canvas_area.messages.text
    hand.click(3, 3)
    assert "no object here" in pair.canvas_area.messages.text


def test_both_halves_of_a_proposal_are_accepted(window, hand) -> None:
    selection = window.workspace.object_selection
    hand.canvas.setFocus()
    hand.key(KEY.Key_W)
    hand.wait(lambda: selection.ready and selection.idle)
    hand.click(24, 20)
    hand.wait(lambda: selection.idle and bool(selection.proposals))
    hand.click(39, 44)
    hand.wait(lambda: selection.idle and selection.proposals[0].selection.mask[39, 44])
    hand.key(KEY.Key_K)
    hand.move(5, 5)
    hand.wait(lambda: window.workspace.outline_editing.edges is not None)
    hand.drag((40, 20), (22, 44))
    assert len(accepted_items(window)) == 2 and not selection.selecting
    hand.key(KEY.Key_Z, CONTROL)
    assert accepted_items(window) == () and selection.selecting
