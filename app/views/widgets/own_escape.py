"""Widgets that handle Escape themselves, instead of giving the keyboard back to the canvas."""

from __future__ import annotations

from PySide6.QtWidgets import QWidget

_OWN = "own_escape"


def keep_escape(widget: QWidget) -> None:
    """Let a widget, and those in it, handle Escape; text fields in it handle Enter, too."""
    widget.setProperty(_OWN, True)


def has_own_escape(widget: QWidget) -> bool:
    """Whether a widget, or one around it, handles Escape itself."""
    around: QWidget | None = widget
    while around is not None:
        if around.property(_OWN):
            return True
        around = around.parentWidget()
    return False
