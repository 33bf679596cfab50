"""A file of any size holds up neither another image nor the end of the program."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import pytest

from app.session.core_functions import Core
from app.session.workspace import Workspace
from cpm_core.formats import load_image
from cpm_core.formats.fingerprint import fingerprint

pytestmark = pytest.mark.shared_window

HUGE = 200 << 30
"""Size of a file whose hash takes minutes [bytes]; it holds nothing, and takes no room on the disk."""


@pytest.fixture
def huge(tmp_path: Path) -> Path:
    path = tmp_path / "huge.npy"
    path.touch()
    os.truncate(path, HUGE)
    return path


@pytest.fixture
def patient(qapp, huge, image_file, compiled_loops):
    """A session that reads the huge file at once, so that only its hash takes long."""

    def load(path: Path, go_on=None):
        if path == huge:
            fingerprint(huge, go_on)
        return load_image(image_file, go_on)

    made = Workspace(replace(Core(), load_image=load))
    yield made
    made.close()
    made.session.deleteLater()


def test_another_image_can_be_opened_while_the_hash_of_a_huge_file_is_made(patient, qtbot, huge, image_file) -> None:
    session = patient.session
    session.open(huge)
    qtbot.wait(50)
    session.open(image_file)
    qtbot.waitUntil(lambda: session.document.image is not None, timeout=20_000)
    assert session.document.image.name == image_file.name
    qtbot.waitUntil(lambda: session.idle, timeout=20_000)


def test_closing_does_not_wait_for_the_hash_of_a_huge_file(patient, qtbot, huge) -> None:
    patient.session.open(huge)
    qtbot.wait(50)
    patient.session.close()
    assert patient.session.tasks.idle
