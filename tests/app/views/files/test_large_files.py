"""A file of any size holds up neither another image nor the end of the program."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from cpm_app.session.features.workspace import Workspace
from cpm_app.session.tasks import opening

from cpm_core.formats import load_image

pytestmark = pytest.mark.shared_window

SHAPE = (5120, 1440, 1440)
"""Pages, rows and columns of a stack of 20 GB; all pages but the middle one are empty, and take no room on the disk."""


@pytest.fixture
def huge(tmp_path: Path) -> Path:
    path = tmp_path / "huge.npy"
    with path.open("wb") as stream:
        np.lib.format.write_array_header_1_0(stream, {"descr": "<u2", "fortran_order": False, "shape": SHAPE})
        begin = stream.tell()
        page = np.tri(*SHAPE[1:], dtype="<u2")
        stream.seek(SHAPE[0] // 2 * page.nbytes, os.SEEK_CUR)
        stream.write(page.tobytes())
    os.truncate(path, begin + 2 * int(np.prod(SHAPE)))
    return path


@pytest.fixture
def patient(qapp, huge, image_file, compiled_loops, monkeypatch):
    """A session for which the huge file comes from a drive that never ends to deliver it."""

    def load(path: Path, check_cancelled: Callable[[], None], **_: object):
        while path == huge:
            time.sleep(0.01)
            check_cancelled()
        return load_image(image_file, check_cancelled=check_cancelled)

    monkeypatch.setattr(opening, "load_image", load)
    monkeypatch.setattr(opening, "load_volume", load)
    made = Workspace()
    yield made
    made.session.close()
    made.session.deleteLater()


def test_a_page_of_a_huge_stack_is_opened_at_once(window, qtbot, huge) -> None:
    window.session.open_file(huge)
    qtbot.waitUntil(lambda: window.session.document.image.name == huge.name, timeout=20_000)
    assert window.session.document.image.shape == SHAPE[1:]
    assert window.session.document.image.sha256.startswith("sampled:")


def test_another_image_can_be_opened_while_a_huge_file_is_read(patient, qtbot, huge, image_file) -> None:
    session = patient.session
    session.open_file(huge)
    qtbot.wait(50)
    session.open_file(image_file)
    qtbot.waitUntil(lambda: session.document.image is not None, timeout=20_000)
    assert session.document.image.name == image_file.name
    qtbot.waitUntil(lambda: session.idle, timeout=20_000)


def test_closing_does_not_wait_for_a_huge_file(patient, qtbot, huge) -> None:
    patient.session.open_file(huge)
    qtbot.wait(50)
    patient.session.close()
    assert patient.session.tasks.idle
