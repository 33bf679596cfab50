"""The first file of a newcomer opens, whatever it is, and what cannot be opened is refused in one sentence."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import nibabel
import nrrd
import numpy as np
import pytest
import tifffile
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import QEvent, QObject

from tests.app.conftest import Hand
from tests.app.reading import treat_as_saved
from tests.core.formats.images.made import write_series

pytestmark = pytest.mark.shared_window

BALL = (200.0 * (np.linalg.norm(np.indices((12, 20, 24)).T - (6, 10, 12), axis=-1).T < 5)).astype(np.uint8)


def nifti(folder: Path) -> Path:
    nibabel.save(nibabel.Nifti1Image(BALL.T, np.diag([0.5, 0.5, 1.0, 1.0])), folder / "a.nii.gz")
    return folder / "a.nii.gz"


def nearly_raw(folder: Path) -> Path:
    header = {"space": "left-posterior-superior", "space directions": np.eye(3), "kinds": ["domain"] * 3}
    nrrd.write(str(folder / "a.nrrd"), BALL.T, header)
    return folder / "a.nrrd"


def ome(folder: Path) -> Path:
    two = np.stack([BALL, BALL[::-1]])
    sizes = {"axes": "CZYX", "PhysicalSizeX": 0.5, "PhysicalSizeY": 0.5, "PhysicalSizeZ": 1.0}
    tifffile.imwrite(folder / "a.ome.tif", two, ome=True, photometric="minisblack", metadata=sizes)
    return folder / "a.ome.tif"


def dicom(folder: Path) -> Path:
    write_series(folder / "series", range(10))
    return folder / "series"


@pytest.mark.parametrize("write", [nifti, nearly_raw, ome, dicom])
def test_files_of_volumes_open_as_volumes(window: MainWindow, hand: Hand, tmp_path, write: Callable) -> None:
    path = write(tmp_path)
    window.open_image(path)
    hand.wait(lambda: window.session.document.image.name == path.name and window.session.idle)
    assert window.session.image.ndim == 3
    assert window.session.scene.slices is not None


@pytest.mark.parametrize("write", [nifti, nearly_raw, ome])
def test_files_that_are_cut_short_are_refused_by_their_name(window, hand, tmp_path, write: Callable) -> None:
    before, path = window.session.image, write(tmp_path)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 3])
    window.open_image(path)
    hand.wait(lambda: window.canvas_area.messages.text.startswith(f"{path.name} "))
    assert window.canvas_area.messages.text.count(". ") == 0, "one sentence"
    assert window.session.image is before


class Marks(QObject):
    """Whether the title of a window has been marked as unsaved, each time that this has been set."""

    def __init__(self) -> None:
        super().__init__()
        self.seen: list[bool] = []

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802  # Qt's name
        if event.type() == QEvent.Type.ModifiedChange:
            self.seen.append(watched.isWindowModified())
        return False


def test_the_title_has_no_mark_of_unsaved_work_while_a_file_opens(window, hand, tmp_path) -> None:
    marks = Marks()
    treat_as_saved(window)
    window.installEventFilter(marks)
    window.open_image(nifti(tmp_path))
    hand.wait(lambda: window.session.document.image.name == "a.nii.gz" and window.session.idle)
    window.removeEventFilter(marks)
    assert marks.seen and not any(marks.seen) and "a.nii.gz" in window.windowTitle()
