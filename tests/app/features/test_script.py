"""The workflow as a script: the program and the command line find the contours of the window, to the bit."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tifffile
from PIL import Image as Picture
from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication

from app.model.document import edits
from app.model.document.document import Document, ImageReference
from app.model.document.samples import samples
from app.model.document.saving import to_file
from app.model.export.script import script_of
from app.views.features.file.script import ScriptFeature
from app.views.main_window import MainWindow
from cpm_core import PRESETS, Parameters, cli, load_contours, load_image, load_surface, load_volume
from cpm_core.contours.hand_edits import HandEdit
from cpm_core.formats.contours.pages.stack_json import load_stack_result
from cpm_core.formats.sessions.session_file import save_session
from cpm_core.medial_axis.outlines import Outlined
from cpm_core.shapes import (
    Barrier,
    Charge,
    Circle,
    Ellipse,
    Everywhere,
    Grid,
    Points,
    Polygon,
    Region,
    Stroke,
    Threshold,
)
from tests.app.conftest import Hand, disc
from tests.app.pages.test_pages_window import settled
from tests.app.volumes.conftest import ball, open_file

pytestmark = pytest.mark.shared_window


@pytest.fixture
def image(tmp_path, monkeypatch) -> Path:
    """A small image, in a folder whose name needs care; files are written there."""
    folder = tmp_path / "it's a folder"
    folder.mkdir()
    monkeypatch.chdir(folder)
    file = folder / 'a "disc".png'
    Picture.fromarray(disc().astype("uint8")).save(file)
    return file


def document_on(image: Path, *shapes, parameters=PRESETS["shape"], **given) -> Document:
    reference = ImageReference.of(image, load_image(image))
    fresh = Document(reference, tuple(shapes), **given)
    return replace(fresh, parameters=fresh.fitting(parameters))


def of_python(document: Document, image: Path):
    """The contours that the program finds, which writes them into the folder."""
    script = script_of(document, image.with_suffix(".cpm"))
    exec(compile(script.python, "script.py", "exec"), {})
    return load_contours(image.parent / f"{image.stem}_contours.svg")


def of_command(document: Document, image: Path):
    """The contours that the command line finds."""
    target = image.parent / f"{image.stem}_contours.svg"
    target.unlink(missing_ok=True)
    assert cli.main(shlex.split(script_of(document, image.with_suffix(".cpm")).command)[1:]) == 0
    return load_contours(target)


def ran(program: str) -> None:
    """Run a program in a process of its own, in the present folder."""
    Path("script.py").write_text(program, encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": str(Path(cli.__file__).parents[2])}
    done = subprocess.run([sys.executable, "script.py"], env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def assert_same(some, others) -> None:
    assert len(some) == len(others) > 0
    for one, other in zip(some, others, strict=True):
        assert one.closed == other.closed
        assert np.array_equal(one.points, other.points)


CIRCLE = Circle((30.5, 31.0), 9.25)
DRAWN = {
    "circle": (CIRCLE,),
    "places": (
        CIRCLE,
        Region(((4.0, 4.0), (60.0, 4.0), (60.0, 60.0), (4.0, 60.0))),
        Barrier(((0.0, 31.0), (20.0, 31.0))),
    ),
    "stroke": (CIRCLE, Stroke(((28.0, 28.0), (36.0, 37.5)))),
    "everywhere": (Everywhere("gradient"),),
    "other order": (Everywhere("centers"), CIRCLE),
    "charge": (CIRCLE, Charge((10.0, 12.0), -1.5)),
    "ellipse": (Ellipse((32.0, 32.0), (6.0, 9.0), 0.25),),
    "all": (
        Polygon(((26.0, 26.0), (38.0, 26.0), (32.0, 40.0))),
        Grid(((20.0, 20.0), (44.0, 20.0), (44.0, 44.0)), 6.0),
        Points(((31.0, 33.0),)),
        Threshold(((10.0, 10.0), (50.0, 10.0), (50.0, 50.0), (10.0, 50.0))),
    ),
}


@pytest.mark.parametrize("shapes", DRAWN.values(), ids=DRAWN)
def test_program_and_command_find_the_same_contours(image, capsys, shapes) -> None:
    document = document_on(image, *shapes, parameters=replace(PRESETS["shape"], beta=0.9, smoothing=1.25))
    if script_of(document, image.with_suffix(".cpm")).reads_session:
        save_session(to_file(document, {}), image.with_suffix(".cpm"))
    assert_same(of_python(document, image), of_command(document, image))


def test_what_is_simple_is_written_out(image) -> None:
    script = script_of(document_on(image, CIRCLE, parameters=Parameters(beta=0.9)), image.with_suffix(".cpm"))
    assert "Circle(center=(30.5, 31.0), radius=9.25)" in script.python
    assert "    beta=0.9,\n" in script.python
    assert "--circle 30.5,31.0,9.25 --beta 0.9" in script.command
    assert not script.reads_session


def test_edits_by_hand_are_read_from_the_session(image, capsys) -> None:
    edit = HandEdit(added=((10.0, 10.0), (10.0, 20.0), (20.0, 20.0)), closed=True)
    document = document_on(image, CIRCLE, hand_edits=(edit,))
    script = script_of(document, image.with_suffix(".cpm"))
    assert script.reads_session
    assert "Circle" not in script.python
    save_session(to_file(document, {}), image.with_suffix(".cpm"))
    assert_same(of_python(document, image), of_command(document, image))
    assert len(of_command(document, image)) == 2


@pytest.mark.parametrize("sample", [s for s in samples() if s.path.suffix == ".png"], ids=lambda s: s.path.stem)
def test_every_sample_has_a_script_without_a_session(sample, tmp_path) -> None:
    script = script_of(
        document_on(sample.path, *sample.shapes, parameters=sample.parameters, mode=sample.mode), tmp_path
    )
    compile(script.python, "script.py", "exec")
    assert script.command.startswith("cpm ")
    assert not script.reads_session


def test_the_skeleton_is_that_of_the_command_line(image, capsys) -> None:
    document = document_on(image, parameters=PRESETS["noisy"], mode="skeleton")
    script = script_of(document, image.with_suffix(".cpm"))
    exec(compile(script.python, "script.py", "exec"), {})
    written = (image.parent / f"{image.stem}_skeleton.svg").read_text()
    assert cli.main(shlex.split(script.command)[1:]) == 0
    assert (image.parent / f"{image.stem}_skeleton.svg").read_text() == written


def test_the_skeleton_of_chosen_objects_is_that_of_their_outlines(image, capsys) -> None:
    square = ((8.0, 8.0), (8.0, 56.0), (20.0, 56.0), (20.0, 8.0))
    document = document_on(image, parameters=PRESETS["noisy"], mode="skeleton", outlined=Outlined(contours=(square,)))
    script = script_of(document, image.with_suffix(".cpm"))
    assert script.command == ""
    assert "chosen objects" in script.note
    exec(compile(script.python, "script.py", "exec"), {})
    found = load_contours(image.parent / f"{image.stem}_skeleton.svg")
    middle = max(found, key=lambda branch: np.ptp(branch.points[:, 1]))
    assert np.abs(middle.points[:, 0] - 14.0).max() < 0.1
    assert np.ptp(middle.points[:, 1]) > 30.0


def test_the_script_of_a_volume_finds_its_surface(window, hand, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    np.save("ball.npy", ball().astype(np.uint8))
    open_file(window, hand, tmp_path / "ball.npy")
    hand.drag((14, 16), (14, 20))
    hand.key(Qt.Key.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: window.session.idle)
    shown = window.session.scene.reconstruction.result.surface
    window.feature(ScriptFeature).open()
    dialog = window.feature(ScriptFeature).dialog
    assert dialog is not None
    for form in ("python", "command"):
        if form == "python":
            ran(dialog.python.toPlainText())
        else:
            assert cli.main(shlex.split(dialog.command.toPlainText())[1:]) == 0
        found = load_surface("ball_surface.ply", load_volume("ball.npy"))
        np.testing.assert_array_equal(found.faces, shown.faces)
        assert np.abs(found.vertices - shown.vertices).max() < 0.01
        Path("ball_surface.ply").unlink()
    dialog.close()


@pytest.mark.parametrize("own", [False, True], ids=["one start", "starts of their own"])
def test_the_script_of_a_stack_finds_the_contours_of_all_pages(
    window, hand, tmp_path, monkeypatch, own, capsys
) -> None:
    monkeypatch.chdir(tmp_path)
    pages = np.array([np.roll(disc(9.0), by - 14, axis=1) for by in (0, 4, 8, 24)], np.uint8)
    tifffile.imwrite("cells.tif", pages, imagej=True, metadata={"axes": "TYX"})
    open_file(window, hand, tmp_path / "cells.tif")
    window.session.begin_document(edits.set_parameters(window.session.document, Parameters()))
    window.session.edit("draw", lambda document: edits.add_shape(document, Circle((30.0, 20.0), 5.0)))
    stack = window.workspace.pages
    stack.run()
    settled(window, hand)
    if own:
        stack.open(4)
        hand.wait(lambda: stack.number == 4)
        settled(window, hand)
        window.session.edit("draw", lambda document: edits.add_shape(document, Circle((32.0, 42.0), 4.0)))
        stack.run()
        settled(window, hand)
    window.feature(ScriptFeature).open()
    dialog = window.feature(ScriptFeature).dialog
    assert dialog is not None
    ran(dialog.python.toPlainText())
    wanted = [(page.number, [one.points.round(3).tolist() for one in page.contours]) for page in stack.result.pages]
    assert [page for page, contours in wanted if contours] == [1, 2, 3, 4]
    assert told_in(Path("cells_pages.json")) == wanted
    assert bool(dialog.command.toPlainText()) is not own
    if not own:
        Path("cells_pages.json").unlink()
        assert cli.main(shlex.split(dialog.command.toPlainText())[1:]) == 0
        assert told_in(Path("cells_pages.json")) == wanted
    dialog.close()


def told_in(path: Path) -> list[tuple[int, list[list[list[float]]]]]:
    """Page and vertices of the contours of a file."""
    found = load_stack_result(path).pages
    return [(page.number, [one.points.round(3).tolist() for one in page.contours]) for page in found]


def test_the_window_shows_the_script_of_its_own_contours(ready: MainWindow, hand: Hand, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    hand.key(Qt.Key.Key_Space)
    hand.wait(lambda: ready.session.status.phase == "finished")
    hand.wait(lambda: ready.session.idle and ready.session.scene.contours.result is not None)
    ready.feature(ScriptFeature).open()
    dialog = ready.feature(ScriptFeature).dialog
    assert dialog is not None
    hand.qtbot.waitExposed(dialog)
    hand.qtbot.mouseClick(dialog.copy, Qt.MouseButton.LeftButton)
    copied = QGuiApplication.clipboard().text()
    assert copied == dialog.python.toPlainText()
    dialog.tabs.setCurrentWidget(dialog.command)
    assert dialog.text.startswith("cpm run ")
    dialog.close()
    names: dict[str, Any] = {}
    exec(compile(copied, "script.py", "exec"), names)
    shown = ready.session.scene.contours.result
    assert shown is not None
    assert_same(names["result"].contours, shown.contours)
