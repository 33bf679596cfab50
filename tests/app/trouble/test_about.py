"""Help > About says what a report of an error needs, and copies it."""

from __future__ import annotations

import platform

import numpy as np
import pytest
from PySide6.QtCore import Qt, qVersion
from PySide6.QtWidgets import QApplication, QMessageBox, QPushButton

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


def test_the_button_copies_all_of_it_as_plain_text(about, qtbot) -> None:
    (copy,) = (button for button in about.findChildren(QPushButton) if "Copy" in button.text())
    qtbot.mouseClick(copy, Qt.MouseButton.LeftButton)
    copied = QApplication.clipboard().text()
    for told in (f"CPM: {cpm_core.__version__}", "MIT license", "Jalba", f"NumPy: {np.__version__}", qVersion()):
        assert told in copied
    assert "<" not in copied
