"""One answer to what is there: every way shows the objects that the run proposes, the same to the pixel.

Those of an image that is cut are compared in `tests/core/chunked`, those of a volume in `views/volume`.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import PIL.Image
import pytest
import skimage
from cpm_app.napari import finding
from cpm_app.session.storage.session_file import DocumentFile
from PySide6.QtCore import Qt

import cpm_core as cpm
from cpm_core import cli
from cpm_core.formats import load_session
from cpm_core.numerics.types import Index
from cpm_core.shapes import Circle
from tests.app.conftest import Hand

pytestmark = pytest.mark.shared_window

SAMPLES = Path(__file__).parents[2] / "assets" / "samples"
COINS = Path(skimage.__file__).parent / "data" / "coins.png"


@pytest.fixture
def image_file(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """A copy of an image that ships, as pictures of others may be read only."""
    path = tmp_path / Path(request.param).name
    path.write_bytes(Path(request.param).read_bytes())
    return path


def masks(found) -> list[bytes]:
    return [one.mask.tobytes() for one in found]


def written(path: Path) -> Index:
    with PIL.Image.open(path) as picture:
        return np.asarray(picture).astype(int)


@pytest.mark.parametrize(
    ("image_file", "start"),
    [
        (SAMPLES / "rings.png", "grid"),
        (SAMPLES / "u_shape.png", "circle"),
        pytest.param(SAMPLES / "nuclei.png", "grid", marks=pytest.mark.long),
        pytest.param(SAMPLES / "cells.png", "gradient", marks=pytest.mark.long),
        pytest.param(SAMPLES / "hand.png", "grid", marks=pytest.mark.long),
        pytest.param(COINS, "centers", marks=pytest.mark.long),
    ],
    indirect=["image_file"],
)
def test_every_way_shows_the_objects_that_the_run_proposes(
    window, hand: Hand, image_file: Path, start: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(hand, "patience", 120_000)
    selection = window.workspace.object_selection
    if start == "circle":
        circle = Circle((150.0, 75.0), 10.0)
        window.session.edit("draw", lambda document: replace(document, shapes=(circle,)))
    else:
        window.actions_by_name[f"start_{start}"].trigger()
    hand.key(Qt.Key.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: selection.idle and bool(selection.proposals))
    shown = masks(each.selection for each in selection.proposals)
    session = tmp_path / "window.cpm"
    assert DocumentFile(window.session, dict).save_and_wait(session)

    result = cpm.run(image_file, session)
    assert masks(result.objects) == shown
    assert masks(cpm.select_all(result)) == shown
    assert masks(cpm.notebook_view(result).objects) == shown

    labels = cpm.objects_result(result.objects, result.image).labels
    once, again = ["run", "--session", str(session)], ["batch", str(image_file), "--session"]
    assert cli.main([*once, "--objects", "--export", str(tmp_path / "run.tif")]) == 0
    folder = tmp_path / "found"
    assert cli.main([*again, str(session), "--output", str(folder), "--workers", "1", "--export", "masks"]) == 0
    work = finding.run_from_seeds(result.image, result.seeds, lambda: load_session(session).parameters)
    for found in (
        written(tmp_path / "run.tif"),
        written(folder / f"{image_file.stem}_objects.tif"),
        ended(work).labels,
    ):
        np.testing.assert_array_equal(found, labels)


def ended(work) -> cpm.Result:
    """Return the outcome of a computation for napari."""
    while True:
        try:
            next(work)
        except StopIteration as end:
            return end.value
