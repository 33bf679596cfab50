"""The underlined letters of a menu, told apart when it opens; see `app.model.text.mnemonics`."""

from __future__ import annotations

from functools import partial

from PySide6.QtWidgets import QMenu

from app.model.text.mnemonics import distinct


def keep_apart(menu: QMenu) -> None:
    """Let no letter choose two of the visible entries, each time the menu opens: other ones may be visible then."""
    menu.aboutToShow.connect(partial(_tell_apart, menu))


def _tell_apart(menu: QMenu) -> None:
    visible = [action for action in menu.actions() if action.isVisible() and not action.isSeparator()]
    for action, text in zip(visible, distinct([action.text() for action in visible]), strict=True):
        if text != action.text():
            action.setText(text)
