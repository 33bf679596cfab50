"""One answer to what is there in a volume: every way shows the bodies that the run proposes, the same to the voxel."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from cpm_app.session.features.outcome import describe_outcome
from cpm_app.session.storage.session_file import DocumentFile
from PySide6.QtCore import Qt

import cpm_core as cpm
from cpm_core import cli
from tests.app.conftest import Hand

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

    assert describe_outcome(volume.workspace).startswith("3 objects found")
    hand.key(Qt.Key.Key_Return)
    hand.wait(lambda: selection.idle and not selection.proposals)
    items = volume.session.document.objects.items
    assert [item.region.paste(offered[0].shape).tobytes() for item in items] == masks(offered)
    assert [item.confidence for item in items] == pytest.approx([one.confidence for one in offered], abs=1e-3)
