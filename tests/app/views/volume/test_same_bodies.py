"""One answer to what is there in a volume: every way shows the bodies that the run proposes, the same to the voxel."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pytest
from cpm_app.session.storage.session_file import DocumentFile
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication

import cpm_core as cpm
from cpm_core import cli
from cpm_core.objects import compute_iou
from tests.app.conftest import Hand
from tests.app.views.volume.conftest import open_file

pytestmark = pytest.mark.shared_window

COLUMNS = 9.0, 18.0, 34.0
"""Of the middles of three balls, of which two touch."""


@pytest.fixture
def volume_file(tmp_path: Path) -> Path:
    places = np.moveaxis(np.indices((20, 22, 44)), 0, -1)
    away = np.min([np.linalg.norm(places - (9.0, 10.0, col), axis=-1) for col in COLUMNS], axis=0)
    path = tmp_path / "touching.npy"
    np.save(path, (20.0 + 180.0 * np.clip(6.0 - away, 0.0, 1.0)).astype(np.uint8))
    return path


def masks(found) -> list[bytes]:
    return [one.mask.tobytes() for one in found]


def test_every_way_shows_the_bodies_that_a_run_in_a_volume_proposes_and_enter_accepts_them(
    volume, hand: Hand, volume_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(hand, "patience", 120_000)
    volume.actions_by_name["mode_automatic"].trigger()
    hand.key(Qt.Key.Key_Space)
    hand.wait_for_phase("finished")
    selection = volume.workspace.object_selection
    hand.wait(lambda: selection.idle and len(selection.proposals) == 3)
    offered = [each.selection for each in selection.proposals]
    session = tmp_path / "window.cpm"
    assert DocumentFile(volume.session, dict).save_and_wait(session)

    result = cpm.run(volume_file, session)
    assert masks(result.objects) == masks(offered)
    assert [one.confidence for one in result.objects] == [one.confidence for one in offered]
    assert cli.main(["run", "--session", str(session), "--objects", "--export", str(tmp_path / "run.tif")]) == 0
    labels = cpm.load_volume(tmp_path / "run.tif").values
    assert masks(result.objects) == [(labels == number).tobytes() for number in (1, 2, 3)]

    legend, panel = volume.canvas_area.strip.legend, volume.panels["objects"]
    hand.key(Qt.Key.Key_W)
    hand.wait(panel.isVisible)
    legend.update_now()
    panel.show_selected()
    assert volume.canvas_area.hint.text().startswith("3 proposals. ")
    assert panel.summary.text() == "3 proposals"
    assert {entry.text: entry.count for entry in legend.entries}["proposals"] == 3
    assert "contours" not in {entry.text for entry in legend.entries}
    hand.key(Qt.Key.Key_Return)
    hand.wait(lambda: selection.idle and not selection.proposals)
    items = volume.session.document.objects.items
    assert [item.region.paste(offered[0].shape).tobytes() for item in items] == masks(offered)
    assert [item.confidence for item in items] == pytest.approx([one.confidence for one in offered], abs=1e-3)

    volume.workspace.slices.go_through((9.0, 10.0, COLUMNS[0]))
    volume.workspace.slices.set_axis(2)
    legend.update_now()
    assert {entry.text: entry.count for entry in legend.entries}["objects"] == 3
    panel.show_selected()
    assert panel.summary.text() == "3 objects"

    status = volume.session.status
    volume.workspace.object_list.select_objects([items[0].number])
    volume.actions_by_name["freeze_object"].trigger()
    hand.wait(lambda: volume.session.idle)
    assert volume.session.document.objects.items[0].frozen
    assert (volume.session.status.phase, volume.session.status.step) == ("finished", status.step)


def test_a_click_in_one_of_bodies_that_touch_selects_what_the_run_proposes_there(volume_file: Path) -> None:
    image = cpm.load_volume(volume_file)
    result = cpm.segment(image, cpm.seeds_everywhere(image), cpm.PRESETS["volume"])
    bodies = cpm.partition(result)
    for column in COLUMNS:
        proposed = next(one for one in result.objects if one.mask[9, 10, int(column)])
        assert (bodies.select([(9, 10, column)]).mask == proposed.mask).all()
    one, other, apart = ((9.0, 10.0, column) for column in COLUMNS)
    whole = bodies.select([one, other])
    assert (bodies.select([other], previous=bodies.select([one])).mask == whole.mask).all()
    assert (bodies.select([one, other], [other]).mask == bodies.select([one]).mask).all()
    assert bodies.find_candidates([one])[-1].mask[9, 10, int(COLUMNS[1])]
    assert not whole.mask[9, 10, int(apart[2])]


@pytest.mark.parametrize("columns", [COLUMNS[2:], pytest.param(COLUMNS[:0:-1], marks=pytest.mark.long)])
def test_bodies_that_were_clicked_are_found_again_by_the_script_and_by_the_command(
    volume, hand: Hand, tmp_path: Path, columns: tuple[float, ...]
) -> None:
    selection, shown = volume.workspace.object_selection, []
    hand.canvas.setFocus()
    hand.key(Qt.Key.Key_W)
    hand.wait(lambda: selection.ready and selection.idle)
    volume.workspace.slices.go_through((9.0, 10.0, COLUMNS[2]))
    for column in columns:
        hand.click(10.0, column)
        hand.wait(lambda: selection.idle and selection.answered)
        shown.append(selection.proposals[0].selection)
        hand.key(Qt.Key.Key_Return)
        hand.wait(lambda: selection.idle and len(volume.session.document.objects.items) == len(shown))
    clipboard, texts = QApplication.clipboard(), []
    for action in ("copy_python", "copy_command"):
        clipboard.clear()
        volume.actions_by_name[action].trigger()
        hand.wait(lambda: bool(clipboard.text()))
        texts.append(clipboard.text())
    script, command = texts
    found: dict[str, object] = {}
    exec(script, found)
    assert masks(found["objects"]) == masks(shown)
    words = shlex.split(command)
    assert words[-2:] == ["--export", "touching_objects.tif"]
    assert cli.main([*words[1:-1], str(tmp_path / "command.tif")]) == 0
    cpm.export(cpm.objects_result(shown), tmp_path / "window.tif")
    labels = [cpm.load_volume(tmp_path / name).values for name in ("command.tif", "window.tif")]
    np.testing.assert_array_equal(*labels)
    assert labels[0].max() == len(columns)


def test_a_click_in_or_beside_an_organ_selects_the_same_in_every_way_and_what_a_run_proposes(
    window, hand: Hand, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(hand, "patience", 120_000)
    places = np.moveaxis(np.indices((34, 38, 40)), 0, -1) - np.array([17.0, 19.0, 20.0])
    body, at = np.linalg.norm(places, axis=-1) < 14.0, np.array([1.0, -4.0, 4.0])
    organ = np.linalg.norm((places - at) / (1.0, 1.2, 0.9), axis=-1) < 4.5
    truths = organ, body & ~organ
    values = np.random.default_rng(1).normal(np.select([organ, body], [130.0, 90.0], 20.0), 6.0)
    path, written = tmp_path / "organ.npy", tmp_path / "selected.tif"
    np.save(path, values.clip(0.0, 255.0).astype(np.uint8))
    open_file(window, hand, path)
    selection, image = window.workspace.object_selection, cpm.load_volume(path)
    window.workspace.slices.go_through((18.0, 15.0, 24.0))
    hand.canvas.setFocus()
    hand.key(Qt.Key.Key_W)
    hand.wait(lambda: selection.ready and selection.idle)

    def select(bodies, *options: str) -> list[np.ndarray]:
        """Select the organ, and the body beside it, by clicks in the window, in the library and by the command."""
        found = []
        for row, col in (15.0, 24.0), (27.0, 20.0):
            hand.click(row, col)
            clicks = window.session.document.objects.clicks
            hand.wait(lambda: selection.idle and [each.clicks for each in selection.proposals[:1]] == [clicks])  # noqa: B023
            found.append(selection.proposals[0].selection.mask)
            np.testing.assert_array_equal(bodies.select([(18.0, row, col)]).mask, found[-1])
            words = ["run", str(path), *options, "--object", f"18,{row:g},{col:g}", "--export", str(written)]
            assert cli.main(words) == 0
            np.testing.assert_array_equal(cpm.load_volume(written).values > 0, found[-1])
            hand.key(Qt.Key.Key_Escape)
            hand.wait(lambda: selection.idle and not window.session.document.objects.clicks)
        return found

    before = select(cpm.partition(image), "--volume")
    window.actions_by_name["mode_automatic"].trigger()
    hand.key(Qt.Key.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: selection.idle and len(selection.proposals) == 2)
    proposed = sorted((each.selection.mask for each in selection.proposals), key=np.count_nonzero)
    session = tmp_path / "window.cpm"
    assert DocumentFile(window.session, dict).save_and_wait(session)
    result = cpm.run(path, session)
    assert {one.mask.tobytes() for one in result.objects} == {mask.tobytes() for mask in proposed}
    hand.key(Qt.Key.Key_X)  # a click on a proposal would take it
    hand.wait(lambda: selection.idle and not selection.proposals)
    after = select(cpm.partition(result), "--session", str(session))
    for truth, one, other, offered in zip(truths, before, after, proposed, strict=True):
        np.testing.assert_array_equal(other, offered)
        assert compute_iou(one, other) > 0.96
        assert min(compute_iou(one, truth), compute_iou(other, truth)) > 0.93
