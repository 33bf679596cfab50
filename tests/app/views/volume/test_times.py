"""A volume in time, or of several channels, has a slider for them; each keeps its own work and the view stays."""

from __future__ import annotations

import nibabel
import numpy as np
import pytest
import tifffile
from cpm_app.views.features.files import OpenSaveFeature
from cpm_app.views.features.volumes import PagesFeature
from PySide6.QtCore import Qt

from cpm_core import load_volume
from cpm_core.shapes import Ruler, Sphere
from tests.app.views.volume.conftest import ball, open_file

pytestmark = pytest.mark.shared_window

KEY = Qt.Key


@pytest.fixture
def film(window, hand, tmp_path):
    """A window on a volume at three points in time, each brighter than the one before."""
    values = np.stack([ball(shape=(32, 28, 24)) + 10.0 * time for time in range(3)], axis=-1)
    path = tmp_path / "film.nii"
    nibabel.save(nibabel.Nifti1Image(values, np.eye(4)), path)  # type: ignore[no-untyped-call]
    open_file(window, hand, path)
    return window


def bar(window):
    return window.get_feature(PagesFeature).bar


def go_to(window, hand, number) -> None:
    """Type a number into the bar."""
    field = bar(window).number
    field.setFocus()
    field.selectAll()
    hand.qtbot.keyClicks(field, str(number))
    hand.qtbot.keyClick(field, KEY.Key_Return)
    pages = window.workspace.pages
    hand.wait(lambda: pages.number == number and window.session.idle and window.turns.is_idle)


def test_the_slider_shows_each_time_in_the_same_slices_and_each_keeps_its_work(film, hand, tmp_path) -> None:
    session, path = film.session, tmp_path / "film.nii"
    assert bar(film).isVisible() and bar(film)._title.text() == "Time" and bar(film).slider.maximum() == 3
    assert not bar(film).run.isVisible() and not film.actions_by_name["run_pages"].isVisible()
    film.workspace.slices.go_through((5, 9, 11))
    hand.canvas.setFocus()
    hand.key(KEY.Key_V)
    hand.drag((8, 8), (10, 10), (14, 16))
    go_to(film, hand, 3)
    np.testing.assert_array_equal(session.image.values, load_volume(path, time=3).values)
    assert session.scene.slices.voxel == (5, 9, 11)
    assert session.document.shapes == () and session.document.image.reading.time == 3
    hand.canvas.setFocus()
    hand.key(KEY.Key_C)
    hand.drag((12, 12), (12, 14), (12, 17))
    go_to(film, hand, 1)
    np.testing.assert_array_equal(session.image.values, load_volume(path).values)
    assert "Only the first" not in film.canvas_area.messages.text
    assert bar(film).slider.pageStep() == 1
    assert [type(shape) for shape in session.document.shapes] == [Ruler]
    hand.canvas.setFocus()
    hand.key(KEY.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert session.document.shapes == ()
    saved = tmp_path / "kept.cpm"
    film.get_feature(OpenSaveFeature).document_file.save_and_wait(saved)
    open_file(film, hand, tmp_path / "film.nii")
    film.open_image(str(saved))
    hand.wait(lambda: film.workspace.pages.documents.keys() == {1, 3} and session.idle)
    go_to(film, hand, 3)
    assert [type(shape) for shape in session.document.shapes] == [Sphere]


def test_page_keys_move_through_the_slices_of_a_volume_in_time(film, hand) -> None:
    before = film.session.scene.slices.current.index
    hand.canvas.setFocus()
    hand.key(KEY.Key_PageDown)
    assert film.session.scene.slices.current.index == before + 1 and film.workspace.pages.number == 1


def test_channels_of_a_volume_are_turned_alike(window, hand, tmp_path) -> None:
    path = tmp_path / "two.ome.tif"
    pages = np.stack([ball(), 255.0 - ball()], axis=1).astype(np.uint8)
    tifffile.imwrite(path, pages, metadata={"axes": "ZCYX", "PhysicalSizeZ": 1.0, "PhysicalSizeX": 1.0,
                     "PhysicalSizeY": 1.0, "PhysicalSizeZUnit": "um"}, photometric="minisblack")  # fmt: skip
    window.session.open_file(path, as_volume=True)
    hand.wait(lambda: window.session.document.image.name == path.name and window.session.idle)
    assert bar(window)._title.text() == "Channel" and bar(window).slider.maximum() == 2
    go_to(window, hand, 2)
    np.testing.assert_array_equal(window.session.image.values, pages[:, 1])
