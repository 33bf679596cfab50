"""Objects that runs of all pages propose: the same in window, command line and library, each under one number."""

from __future__ import annotations

import numpy as np
import pytest
import tifffile
from cpm_app.model.document import edits
from cpm_app.session.features.outcome import describe_outcome
from cpm_app.views.features.volumes import PagesFeature
from PySide6.QtCore import Qt

import cpm_core as cpm
from cpm_core.cli import main
from cpm_core.shapes import Everywhere
from tests.app.session.features.test_followed_objects import DIVIDING, page, settled
from tests.app.session.features.test_followed_objects import stack as stack  # a fixture

pytestmark = pytest.mark.shared_window

PAGES = [(*disks, (48, 46, 8)) for disks in DIVIDING]


def run_all(window, hand) -> None:
    window.session.edit("start", lambda document: edits.add_shape(document, Everywhere("grid")))
    hand.qtbot.mouseClick(window.get_feature(PagesFeature).bar.run, Qt.MouseButton.LeftButton)
    settled(window, hand)
    hand.wait(lambda: not window.workspace.pages.running)
    settled(window, hand)


def number_at(labels, disk) -> int:
    return int(labels[round(disk[0]), round(disk[1])])


def test_window_command_line_and_library_propose_the_same_objects_under_the_same_numbers(stack, hand, tmp_path):
    window = stack(PAGES)
    run_all(window, hand)
    assert "4 of 4 pages were run" in window.canvas_area.messages.text
    selection, path = window.workspace.object_selection, tmp_path / "cells.tif"
    seen = []
    for at in range(1, 5):
        if at > 1:
            hand.key(Qt.Key.Key_PageDown)
            hand.wait(lambda at=at: window.workspace.pages.number == at)
            settled(window, hand)
        hand.wait(lambda: bool(selection.proposals))
        assert describe_outcome(window.workspace).startswith(f"{len(selection.proposals)} objects found")
        seen.append({each.number for each in selection.proposals})
        hand.canvas.setFocus()
        hand.key(Qt.Key.Key_Return)
        settled(window, hand)
        assert {item.number for item in window.session.document.objects.items} == seen[-1]
    given = ("run", str(path), "--pages", "all", "--objects", "--follow", "--export", str(tmp_path / "a.tif"))
    parameters = window.session.document.parameters
    assert main([*given, "--preset", "shape", "--reach", str(parameters.reach)]) == 0
    labels = tifffile.imread(tmp_path / "a.tif")
    grid = cpm.uniform_grid((64, 64))
    found = list(cpm.follow_pages(cpm.load_pages(path), grid, parameters, objects=True))
    for number, (numbers, one, disks) in enumerate(zip(seen, found, PAGES, strict=True)):
        assert numbers == {contour.number for contour in one.contours}
        assert numbers == {number_at(labels[number], each) for each in disks}
    assert [len(numbers) for numbers in seen] == [2, 2, 3, 3]
    assert [(event.kind, event.page) for one in found for event in one.events] == [("splits", 3)]
