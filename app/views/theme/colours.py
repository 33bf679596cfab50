"""Colours that contours can be given: those that colour-blind people tell apart come first."""

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
"""Hues after Okabe and Ito, with white where they have black: the canvas is dark."""


def fill_colours(menu: QMenu, parent: QWidget, choose: Callable[[str], None]) -> None:
    """Fill a menu with colours; what is chosen is told as ``"#rrggbb"``, or empty for none."""
    for title, colour in PALETTE:
        menu.addAction(swatch(colour), title).triggered.connect(lambda _=False, colour=colour: choose(colour))
    menu.addSeparator()
    menu.addAction(tr("Other colour…")).triggered.connect(lambda: _ask(parent, choose))
    menu.addAction(tr("Colour of its kind")).triggered.connect(lambda: choose(""))


def _ask(parent: QWidget, choose: Callable[[str], None]) -> None:
    colour = QColorDialog.getColor(parent=parent, title=tr("Colour of the contours"))
    if colour.isValid():
        choose(colour.name())
