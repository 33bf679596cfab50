"""Contours of other programs in the window: dropped or pasted, as start, objects or truth; pictures that are pasted."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cpm_app.model.document import objects
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import QMimeData, QStandardPaths, Qt
from PySide6.QtGui import QColor, QImage
from PySide6.QtWidgets import QApplication

from cpm_core import Contour
from cpm_core.formats import to_bytes
from cpm_core.shapes import Points, Polygon, Stroke
from tests.app.session.test_saving import answering, drop
from tests.core.formats.drawn import RESULT

pytestmark = pytest.mark.shared_window

CTRL = Qt.KeyboardModifier.ControlModifier
RING = Contour(np.array([(20.0, 20.0), (20.0, 44.0), (44.0, 44.0), (44.0, 20.0)]), True, name="cell", color="#e69f00")
HOLE = Contour(np.array([(28.0, 28.0), (28.0, 36.0), (36.0, 36.0), (36.0, 28.0)]), True, group=1, hole=True)
LINE = Contour(np.array([(5.0, 5.0), (10.0, 30.0)]), False)


def file_of(tmp_path: Path, *contours: Contour, suffix: str = ".geojson") -> Path:
    path = tmp_path / f"drawn{suffix}"
    path.write_bytes(
        to_bytes(replace(RESULT, contours=contours, shape=(64, 64), spacing=(1.0, 1.0), unit=None), suffix)
    )
    return path


def put(**kinds: str | bytes) -> None:
    """Put text or other data on the clipboard, by their kinds."""
    data = QMimeData()
    for kind, content in kinds.items():
        if isinstance(content, str):
            data.setText(content)
        else:
            data.setData(kind.replace("__", "+").replace("_", "/", 1), content)
    QApplication.clipboard().setMimeData(data)


@pytest.mark.parametrize("suffix", [".geojson", ".zip", ".svg", ".csv"])
def test_dropped_contours_are_a_start_when_they_are_said_to_be(window, hand, tmp_path, suffix) -> None:
    with answering("Start"):
        drop(window, file_of(tmp_path, RING, LINE, suffix=suffix))
        hand.wait(lambda: bool(window.session.document.shapes))
    polygon, stroke = window.session.document.shapes
    assert isinstance(polygon, Polygon)
    assert isinstance(stroke, Stroke)
    np.testing.assert_allclose(sorted(polygon.points), sorted(map(tuple, RING.points.tolist())), atol=0.01)
    window.session.undo()
    assert window.session.document.shapes == ()


def test_dropped_contours_are_objects_with_names_colors_and_holes(window, hand, tmp_path) -> None:
    with answering("Objects"):
        drop(window, file_of(tmp_path, replace(RING, group=1), HOLE, LINE, suffix=".json"))
        hand.wait(lambda: bool(window.session.document.objects.items))
    (item,) = window.session.document.objects.items
    assert (item.name, item.color, len(item.region.boundary)) == ("cell", "#e69f00", 2)
    assert item.region.size == 24.0 * 24.0 - 8.0 * 8.0


def test_objects_of_labelme_keep_their_classes(window, hand, tmp_path) -> None:
    session = window.session
    session.edit("name", lambda document: objects.name_class(document, 3, "bone"))
    found = [replace(RING, name="radius", category="bone"), replace(RING, points=RING.points + 10.0, name="skin")]
    with answering("Objects"):
        drop(window, file_of(tmp_path, *found, suffix=".labelme.json"))
        hand.wait(lambda: len(session.document.objects.items) == 2)
    assert [(item.name, item.category) for item in session.document.objects.items] == [("radius", 3), ("", 1)]
    assert [one.name for one in session.document.objects.classes[:3]] == ["skin", "", "bone"]


def test_dropped_contours_are_the_truth_that_the_run_is_compared_with(window, hand, tmp_path) -> None:
    with answering("Ground truth"):
        drop(window, file_of(tmp_path, RING))
        hand.wait(lambda: window.session.scene.truth is not None)
    assert window.session.scene.truth.labels.sum() == 25 * 25


@pytest.mark.parametrize("kind", ["image_svg__xml", "application_geo__json", "text"])
def test_copied_contours_are_pasted_back(window, hand, kind) -> None:
    suffix = ".geojson" if "geo" in kind else ".svg"
    content = to_bytes(replace(RESULT, contours=(RING,), shape=(64, 64)), suffix)
    put(**{kind: content.decode() if kind == "text" else content})
    with answering("Start"):
        hand.key(Qt.Key.Key_V, CTRL)
        hand.wait(lambda: bool(window.session.document.shapes))
    (polygon,) = window.session.document.shapes
    np.testing.assert_allclose(sorted(polygon.points), sorted(map(tuple, RING.points.tolist())), atol=0.01)


def test_a_pasted_picture_is_kept_in_a_file_and_opened(window, hand, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(QStandardPaths, "writableLocation", lambda kind: str(tmp_path))
    picture = QImage(48, 40, QImage.Format.Format_Grayscale8)
    picture.fill(QColor(30, 30, 30))
    picture.setPixelColor(20, 20, QColor(200, 200, 200))
    QApplication.clipboard().setImage(picture)
    hand.key(Qt.Key.Key_V, CTRL)
    hand.wait(lambda: window.session.document.image.name.startswith("pasted-"))
    hand.wait(lambda: window.session.idle)
    assert window.session.scene.image.shape == (40, 48)
    assert Path(window.session.document.image.path).parent == tmp_path / "cpm" / "pasted"


@pytest.mark.parametrize(("text", "told"), [("hello", "clipboard"), ("", "neither a picture")])
def test_what_cannot_be_pasted_is_told(window, hand, text, told) -> None:
    put(text=text)
    hand.key(Qt.Key.Key_V, CTRL)
    hand.wait(lambda: told in window.canvas_area.messages.text)
    assert window.session.document.shapes == ()


def test_a_table_of_points_needs_no_question(window: MainWindow, hand, tmp_path) -> None:
    (tmp_path / "seeds.csv").write_text("row,col\n10,12\n20,22.5\n", "utf-8")
    drop(window, tmp_path / "seeds.csv")
    hand.wait(lambda: bool(window.session.document.shapes))
    assert window.session.document.shapes == (Points(((10.0, 12.0), (20.0, 22.5))),)
