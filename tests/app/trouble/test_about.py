"""Help > About says what a report of an error needs, and copies it."""

from __future__ import annotations

import platform

import numpy as np
import pytest
from PySide6.QtCore import Qt, qVersion
from PySide6.QtWidgets import QApplication

import cpm_core
from app.views.help.about import About

pytestmark = pytest.mark.shared_window


@pytest.fixture
def about(window, qtbot) -> About:
    window.actions_by_name["about"].trigger()
    (made,) = window.findChildren(About)
    qtbot.waitExposed(made)
    yield made
    made.close()


@pytest.mark.parametrize(
    "told",
    [f"CPM {cpm_core.__version__}", "MIT license", "Jalba", platform.python_version(), np.__version__, qVersion()],
)
def test_about_tells_version_license_paper_and_libraries(about, told) -> None:
    assert told in about.text.text()


def test_the_button_copies_all_of_it_as_plain_text(about, qtbot) -> None:
    qtbot.mouseClick(about.copy, Qt.MouseButton.LeftButton)
    copied = QApplication.clipboard().text()
    for told in (f"CPM: {cpm_core.__version__}", "MIT license", "Jalba", f"NumPy: {np.__version__}", qVersion()):
        assert told in copied
    assert "<" not in copied
