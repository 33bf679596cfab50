"""The guide: its pages name existing actions and samples, its links work, and its claims hold."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import PIL.Image
import pytest
from cpm_app.model.document.samples import find_sample_named
from cpm_app.model.text.assets import find_asset, read_guide_page
from cpm_app.views.features.help import HelpFeature
from cpm_app.views.window.guide import GUIDE_PAGES, KEYS_PAGE, Guide
from PySide6.QtCore import Qt, QUrl
from PySide6.QtGui import QKeySequence

pytestmark = pytest.mark.shared_window

TEXTS = {name: [block.text for block in read_guide_page(name)] for name in GUIDE_PAGES}
NAMED = sorted({name for texts in TEXTS.values() for text in texts for name in re.findall(r"\{(\w+)\}", text)})
LINKS = sorted({link for texts in TEXTS.values() for text in texts for link in re.findall(r"href='([^']+)'", text)})


COMING_FROM = (Path(__file__).parents[4] / "docs" / "coming_from.md").read_text(encoding="utf-8")


@pytest.fixture
def guide(window, hand) -> Guide:
    hand.key(Qt.Key.Key_F1)
    return window.get_feature(HelpFeature).guide


def test_every_action_that_is_named_exists(window, guide) -> None:
    for name in NAMED:
        assert name in window.shortcuts.describe_actions()
    for name in GUIDE_PAGES:
        guide.turn_to(name)
        assert "{" not in guide.text.toPlainText()
        assert TEXTS[name][0] in guide.text.toPlainText()


def test_the_page_for_users_of_other_programs_names_menus_and_keys_as_they_are(window) -> None:
    def entries(menu):
        return {action.text().replace("&", ""): action for action in menu.actions()}

    menus = {title: entries(action.menu()) for title, action in entries(window.menuBar()).items()}
    actions, _ = COMING_FROM.split("## Files")
    ours = " ".join(row.split("|")[2] for row in actions.splitlines() if row.startswith("| "))
    named = re.findall(r"\*(\w+)\*, \*([^*]+)\*(?: \(`([^`]+)`\))?", ours)
    assert len(named) > 20
    for menu, entry, key in named:
        assert not key or QKeySequence(key) in menus[menu][entry].shortcuts(), entry
        assert entry in menus[menu]


def test_every_link_has_a_target_and_every_picture_exists(window, guide) -> None:
    for link in LINKS:
        kind, _, name = link.partition(":")
        assert kind in ("page", "sample")
        assert name in GUIDE_PAGES if kind == "page" else find_sample_named(name) is not None
    for page in GUIDE_PAGES:
        for block in read_guide_page(page):
            if block.picture:
                with PIL.Image.open(find_asset(f"guide/{block.picture}")) as picture:
                    assert np.asarray(picture).std() > 5


def test_a_link_opens_a_sample_and_another_a_page(window, hand, guide) -> None:
    guide.text.anchorClicked.emit(QUrl("page:nuclei"))
    assert guide.page == "nuclei"
    guide.text.anchorClicked.emit(QUrl("sample:nuclei.png"))
    hand.wait(lambda: window.session.document.image.name == "nuclei.png")
    assert window.session.document.mode == "automatic"


def test_the_guide_is_one_window_that_can_be_closed_and_opened_again(window, hand, guide) -> None:
    hand.key(Qt.Key.Key_F1)
    assert window.get_feature(HelpFeature).guide is guide
    guide.close()
    hand.wait(lambda: window.get_feature(HelpFeature).guide is None)
    window.get_feature(HelpFeature).show_guide(KEYS_PAGE)
    assert window.get_feature(HelpFeature).guide.page == KEYS_PAGE


def test_the_narrow_place_of_the_artery_stands_out_in_its_skeleton(window, hand) -> None:
    session = window.session
    window.open_image(str(find_sample_named("artery.png").path))
    hand.wait(lambda: session.document.image.name == "artery.png" and session.idle)
    window.actions_by_name["mode_skeleton"].trigger()
    hand.key(Qt.Key.Key_Space)
    hand.wait(lambda: session.scene.skeleton is not None)
    found = session.scene.skeleton
    places = np.concatenate([contour.path[: len(radii)] for contour, radii in zip(found.contours, found.radii,
                                                                                  strict=True)])  # fmt: skip
    radii = np.concatenate(found.radii)

    def width(row: float, col: float) -> float:
        return 2.0 * float(radii[np.argmin(np.hypot(*(places - (row, col)).T))])

    narrow = min(width(row, col) for row, col in zip(range(210, 245, 3), range(190, 206, 1), strict=False))
    assert narrow < 0.7 * width(150, 137)
    assert narrow < 0.7 * width(290, 215)
