"""Colors for contours; those that color-blind people can distinguish come first."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtWidgets import QColorDialog, QMenu, QWidget

from app.model.text.language import tr
from app.views.theme.icons import swatch

PALETTE: tuple[tuple[str, str], ...] = (
    (tr("Orange"), "#e69f00"),
    (tr("Sky blue"), "#56b4e9"),
    (tr("Bluish green"), "#009e73"),
    (tr("Yellow"), "#f0e442"),
    (tr("Blue"), "#0072b2"),
    (tr("Vermilion"), "#d55e00"),
    (tr("Reddish purple"), "#cc79a7"),
    (tr("White"), "#ffffff"),
)
"""Hues after Okabe and Ito, with white instead of black because the canvas is dark."""


def fill_colors(menu: QMenu, parent: QWidget, choose: Callable[[str], None]) -> None:
    """Fill a menu with colors; `choose` is called with ``"#rrggbb"``, or with an empty text for none."""
    for title, color in PALETTE:
        menu.addAction(swatch(color), title).triggered.connect(lambda _=False, color=color: choose(color))
    menu.addSeparator()
    menu.addAction(tr("Other color…")).triggered.connect(lambda: _ask(parent, choose))
    menu.addAction(tr("Color of its kind")).triggered.connect(lambda: choose(""))


def _ask(parent: QWidget, choose: Callable[[str], None]) -> None:
    color = QColorDialog.getColor(parent=parent, title=tr("Color of the contours"))
    if color.isValid():
        choose(color.name())
