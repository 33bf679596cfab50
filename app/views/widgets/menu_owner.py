"""Widgets that know what lies at a point of theirs, for its menu."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from PySide6.QtCore import QPoint


@runtime_checkable
class MenuOwner(Protocol):
    """A widget with a menu; its own actions (`QWidget.actions`) come first in it."""

    def menu_at(self, point: QPoint | None) -> tuple[str, QPoint]:
        """Choose what lies at a point of the widget, or tell what is chosen for None, as keys ask.

        Returns the name of the thing, of which the menu knows the actions, or an empty text for nothing; and where
        the menu opens.
        """
