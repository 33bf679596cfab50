"""A field for a number with decimals, in the language of the window, which takes a point as well."""

from __future__ import annotations

import re

from PySide6.QtGui import QValidator
from PySide6.QtWidgets import QDoubleSpinBox

_POINT = "."
_GROUP = 3
"""Digits between separators of groups."""


class DecimalField(QDoubleSpinBox):
    """Takes numbers as the language writes them, and with a point where that cannot be meant as a separator.

    Where the language writes a comma, ``0.25`` is a quarter; ``1.250`` is what the language says, unless that is out of
    range.
    """

    def validate(self, text: str, place: int) -> tuple[QValidator.State, str, int]:
        """Whether a text is a number, or the beginning of one."""
        state, _, at = super().validate(self._as_written(text), place)
        return state, text, at

    def fixup(self, text: str) -> str:
        """What becomes of the beginning of a number."""
        return super().fixup(self._as_written(text))

    def valueFromText(self, text: str) -> float:
        """The number that a text means."""
        return super().valueFromText(self._as_written(text))

    def _as_written(self, text: str) -> str:
        """The text with the decimal mark of the language."""
        mark = self.locale().decimalPoint()
        if mark == _POINT or mark in text or text.count(_POINT) != 1:
            return text
        converted = text.replace(_POINT, mark)
        digits = re.search(r"\.(\d*)", text)
        if digits is None or len(digits[1]) != _GROUP or self.locale().groupSeparator() != _POINT:
            return converted
        state = super().validate(text, len(text))[0]
        return text if state == QValidator.State.Acceptable else converted
