"""Surfaces, labels, center lines and points of files in a volume: dropped or chosen, as start, objects or truth."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cpm_app.model.document import objects
from cpm_app.model.export import ExportFile, ExportOrder
from cpm_app.views.features.exchange import ImportFeature
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QFileDialog

from cpm_core import Result, centerlines, export
from cpm_core.contours.surface import surface_from_labels
from cpm_core.formats import find_format_suffix
from cpm_core.image.surface import voxelize_surface
from cpm_core.shapes import Points, Stroke
from tests.app.conftest import Hand
from tests.app.exporting import asked, check, order
from tests.app.session.test_saving import answering, drop
from tests.app.views.volume.conftest import SHAPE, ball, open_file
from tests.core.formats.images.made import write_series
from tests.core.formats.masks.test_dicom_seg import HEADER, HEIGHTS, LABELS

pytestmark = pytest.mark.shared_window

CTRL, SHIFT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier
INSIDE = ball() > 110.0
SMALL = np.zeros(SHAPE, bool)
SMALL[2:6, 2:6, 2:6] = True
SURFACE = surface_from_labels((INSIDE | SMALL).astype(np.int32), (1.0, 1.0, 1.0), None)
RESULT = Result(np.empty((0, 3)), (), SURFACE, 1, True, "", SHAPE, (1.0, 1.0, 1.0), None, "ball")


@pytest.fixture
def volume(window: MainWindow, hand: Hand, tmp_path: Path) -> MainWindow:
    """A window on the ball."""
    np.save(tmp_path / "ball.npy", ball().astype(np.uint8))
    open_file(window, hand, tmp_path / "ball.npy")
    return window


@pytest.mark.parametrize("suffix", [".ply", ".stl"])
def test_a_dropped_surface_is_a_start_that_leads_to_it(volume, hand, tmp_path, suffix) -> None:
    export(RESULT, tmp_path / f"a{suffix}")
    with answering("Start"):
        drop(volume, tmp_path / f"a{suffix}")
        hand.wait(lambda: bool(volume.session.document.shapes))
    (points,) = volume.session.document.shapes
    assert isinstance(points, Points)
    off = np.linalg.norm(points.seeds()[:, None] - SURFACE.vertices, axis=2).min(axis=1)
    assert off.max() < 0.01
    assert len(points.positions) > 100
    volume.activateWindow()  # the question was the active one
    hand.wait(volume.isActiveWindow)
    hand.key(Qt.Key.Key_Z, CTRL)
    assert volume.session.document.shapes == ()
    hand.key(Qt.Key.Key_Z, CTRL | SHIFT)
    assert volume.session.document.shapes == (points,)
    hand.key(Qt.Key.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: volume.session.idle)
    surface = volume.session.scene.reconstruction.result.surface
    assert surface.volume == pytest.approx(INSIDE.sum(), rel=0.05)


def test_a_dropped_surface_gives_an_object_for_each_body(volume, hand, tmp_path) -> None:
    export(RESULT, tmp_path / "a.obj")
    with answering("Objects"):
        drop(volume, tmp_path / "a.obj")
        hand.wait(lambda: bool(volume.session.document.objects.items))
    items = volume.session.document.objects.items
    assert sorted(int(voxelize_surface(item.region.surface, SHAPE).sum()) for item in items) == [
        int(SMALL.sum()),
        int(INSIDE.sum()),
    ]
    for item in items:
        plane, row, col = map(int, item.inside[0])
        assert voxelize_surface(item.region.surface, SHAPE)[plane, row, col]
    volume.activateWindow()  # the question was the active one
    hand.wait(volume.isActiveWindow)
    hand.key(Qt.Key.Key_Z, CTRL)
    assert not volume.session.document.objects.items


def test_a_dropped_surface_is_the_truth(volume, hand, tmp_path) -> None:
    export(RESULT, tmp_path / "a.vtk")
    with answering("Ground truth"):
        drop(volume, tmp_path / "a.vtk")
        hand.wait(lambda: volume.session.scene.truth is not None)
    np.testing.assert_array_equal(volume.session.scene.truth.labels > 0, INSIDE | SMALL)


def test_labels_that_are_chosen_give_an_object_for_each_number(volume, hand, tmp_path, monkeypatch) -> None:
    np.save(tmp_path / "labels.npy", (2 * INSIDE + 5 * SMALL).astype(np.uint8))
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_: (str(tmp_path / "labels.npy"), ""))
    with answering("Objects"):
        volume.actions_by_name["import_contours"].trigger()
        hand.wait(lambda: len(volume.session.document.objects.items) == 2)
    assert volume.actions_by_name["import_contours"].text() == "&Import surface…"


@pytest.mark.parametrize("name", ["a_objects.nii.gz", "a_objects.seg.nrrd"])
def test_objects_that_are_exported_and_imported_are_the_same(volume, hand, tmp_path, monkeypatch, name) -> None:
    session = volume.session
    np.save(tmp_path / "labels.npy", (4 * INSIDE + 9 * SMALL).astype(np.uint8))
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_: (str(tmp_path / "labels.npy"), ""))
    with answering("Objects"):
        volume.actions_by_name["import_contours"].trigger()
        hand.wait(lambda: len(session.document.objects.items) == 2)
    assert [item.number for item in session.document.objects.items] == [4, 9]
    session.edit("name", lambda document: objects.rename_objects(document, [4], "Niere"))
    session.edit("color", lambda document: objects.update_objects(document, [9], color="#102030", name="Zyste"))
    before = session.document.objects.items
    what = ExportFile(tmp_path / name, "objects", find_format_suffix(name))
    session.export_files(ExportOrder((what,)))
    hand.wait(lambda: (tmp_path / name).exists() and session.idle)
    session.edit("delete", lambda document: objects.delete_objects(document, [4, 9]))
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_: (str(tmp_path / name), ""))
    with answering("Objects"):
        if name.endswith(".seg.nrrd"):
            drop(volume, tmp_path / name)
        else:
            volume.actions_by_name["import_contours"].trigger()
        hand.wait(lambda: len(session.document.objects.items) == 2)
    after = session.document.objects
    assert [(item.number, item.name) for item in after.items] == [(4, "Niere"), (9, "Zyste")]
    assert [item.color for item in after.items] == [after.classes[0].color, "#102030"]
    for one, other in zip(before, after.items, strict=True):
        np.testing.assert_array_equal(one.region.paste(SHAPE), other.region.paste(SHAPE))
    with answering("Objects"):  # once more: numbers that are taken are not given twice
        volume.actions_by_name["import_contours"].trigger()
        hand.wait(lambda: len(session.document.objects.items) == 4)


def test_center_lines_and_points_are_a_start(volume, hand, tmp_path) -> None:
    rod = np.zeros(SHAPE, bool)
    rod[9:14, 12:17, 3:29] = True
    export(centerlines(rod), tmp_path / "a.swc")
    with answering("Start"):
        drop(volume, tmp_path / "a.swc")
        hand.wait(lambda: bool(volume.session.document.shapes))
    assert all(isinstance(shape, Stroke) for shape in volume.session.document.shapes)
    assert np.abs(volume.session.document.shapes[0].seeds()[:, :2] - (11.0, 14.0)).max() < 1.5
    export(replace(RESULT, particles=np.array([(3.0, 4.0, 5.0)])), tmp_path / "a.points.csv")
    drop(volume, tmp_path / "a.points.csv")
    hand.wait(lambda: volume.session.document.shapes[-1] == Points(((3.0, 4.0, 5.0),)))


def test_what_lies_in_the_other_kind_of_image_is_refused(volume, hand, tmp_path) -> None:
    (tmp_path / "a.geojson").write_text('{"type": "FeatureCollection", "features": []}')
    drop(volume, tmp_path / "a.geojson")
    hand.wait(lambda: "but a volume is open" in volume.canvas_area.messages.text)
    QApplication.clipboard().setText("<svg/>")
    hand.key(Qt.Key.Key_V, CTRL)
    hand.wait(lambda: "clipboard has contours for an image" in volume.canvas_area.messages.text)


def test_objects_in_a_series_are_offered_as_dicom_segments_and_come_back(window, hand, tmp_path) -> None:
    pytest.importorskip("highdicom")
    series = write_series(tmp_path / "series", HEIGHTS, **HEADER)
    window.session.open_file(series, as_volume=True)
    hand.wait(lambda: window.session.scene.slices is not None and window.session.idle)
    np.save(tmp_path / "labels.npy", np.where(LABELS, 4, 0).astype(np.uint8))
    with answering("Objects"):
        window.get_feature(ImportFeature).import_file(tmp_path / "labels.npy")
        hand.wait(lambda: bool(window.session.document.objects.items))
    dialog = asked(hand.qtbot, window)
    check(hand.qtbot, dialog, "objects:.seg.dcm")
    (path,) = order(hand.qtbot, window, dialog, tmp_path)
    assert path.name == "series_objects.seg.dcm"
    with answering("Objects"):
        drop(window, path)
        hand.wait(lambda: len(window.session.document.objects.items) == 4)
    masks = [item.region.paste(LABELS.shape) for item in window.session.document.objects.items]
    assert [(masks[0] == mask).all() + (masks[1] == mask).all() for mask in masks[2:]] == [1, 1]
