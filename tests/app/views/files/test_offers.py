"""Settings for the kind of an image, and earlier work on it, are offered in one line and never imposed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from cpm_app.model.document.modes import PRESET_OFFERS
from cpm_app.views.widgets.containers import OfferBar
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import Qt
from scipy.ndimage import gaussian_filter

from cpm_core import PRESETS
from cpm_core.formats.sessions.session_file import ImageFile, SessionFile, save_session
from cpm_core.shapes import Circle, Everywhere
from tests.app.acting import open_image

pytestmark = pytest.mark.shared_window


@pytest.fixture
def nuclei(tmp_path: Path) -> Path:
    """Bright spots on a dark background."""
    row, col = np.indices((96, 96))
    spots = sum(np.hypot(row - r, col - c) < 6 for r, c in ((20, 24), (60, 70), (70, 20), (24, 74)))
    path = tmp_path / "nuclei.npy"
    np.save(path, 8.0 + gaussian_filter(150.0 * np.asarray(spots), 1.5))
    return path


def bar(window: MainWindow) -> OfferBar:
    return window.offers


def press(hand, button) -> None:
    hand.qtbot.mouseClick(button, Qt.MouseButton.LeftButton)


def test_settings_for_the_kind_are_used_by_one_click_and_taken_back_by_one_key(window, hand, nuclei) -> None:
    assert not bar(window).text
    open_image(window, hand, nuclei)
    before = window.session.document
    assert before.parameters == PRESETS["shape"]
    assert bar(window).text == PRESET_OFFERS["fluorescence"]
    press(hand, bar(window).buttons[0])
    document = window.session.document
    assert (document.mode, document.shapes) == ("automatic", (Everywhere("grid"),))
    assert document.parameters == PRESETS["fluorescence"]
    assert not bar(window).text
    hand.key(Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert window.session.document == before


def test_bright_objects_on_a_dark_background_are_said_to_be_that_and_no_kind_of_image(window, hand, nuclei) -> None:
    open_image(window, hand, nuclei)  # as bones of a radiograph are
    assert bar(window).text.startswith("Bright objects on a dark background")
    assert "luorescence" not in bar(window).text


def test_the_canvas_has_the_keyboard_with_an_offer_above_it_and_a_run_withdraws_it(window, hand, nuclei) -> None:
    open_image(window, hand, nuclei)
    window.session.edit("draw", lambda document: document.__class__(document.image, (Circle((20.0, 24.0), 9.0),)))
    hand.key(Qt.Key.Key_Period)
    hand.wait(lambda: window.session.status.started)
    assert not bar(window).text


def test_earlier_work_on_an_image_is_offered_and_not_a_preset(window, hand, nuclei) -> None:
    save_session(SessionFile(ImageFile(str(nuclei)), shapes=(Circle((20.0, 20.0), 5.0),)), nuclei.with_suffix(".cpm"))
    open_image(window, hand, nuclei)
    assert "nuclei.cpm" in bar(window).text
    press(hand, bar(window).buttons[0])
    hand.wait(lambda: len(window.session.document.shapes) == 1)
    hand.wait(lambda: window.session.idle)
    assert not bar(window).text
