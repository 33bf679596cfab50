"""Help > About says what a report of an error needs, and copies it."""

from __future__ import annotations

import platform

import numpy as np
import pytest
from PySide6.QtCore import qVersion
from PySide6.QtWidgets import QMessageBox

import cpm_core

pytestmark = pytest.mark.shared_window


@pytest.fixture
def about(window, qtbot) -> QMessageBox:
    window.actions_by_name["about"].trigger()
    (made,) = window.findChildren(QMessageBox)
    qtbot.waitExposed(made)
    yield made
    made.close()


@pytest.mark.parametrize(
    "told",
    [cpm_core.__version__, "MIT license", "Jalba", platform.python_version(), np.__version__, qVersion()],
)
def test_about_tells_version_license_paper_and_libraries(about, told) -> None:
    assert told in about.text() + about.informativeText()
