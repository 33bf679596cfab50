"""The numbers of a run: names and values, two in a row."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtWidgets import QGridLayout, QLabel, QWidget

from app.model.text.language import tr

_WIDE = (tr("Contours"), tr("Bridged"), tr("Skeleton of"))
"""Numbers that need a row of their own."""

Number = tuple[str, str, str]
"""Name, value and explanation."""


class Numbers(QWidget):
    """Names and values in a grid; only labels that differ are updated."""

    def __init__(self) -> None:
        super().__init__()
        self._values: dict[str, QLabel] = {}
        self._rows: dict[str, tuple[QLabel, QLabel]] = {}
        self._shown: tuple[str, ...] = ()
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setHorizontalSpacing(8)
        self._grid.setVerticalSpacing(3)
        self._grid.setColumnStretch(1, 3)
        self._grid.setColumnStretch(3, 2)

    def __contains__(self, name: object) -> bool:
        return name in self._shown

    def show_numbers(self, numbers: Sequence[Number]) -> None:
        """Show these numbers, the wide ones last."""
        ordered = sorted(numbers, key=lambda number: number[0] in _WIDE)
        names = tuple(name for name, _, _ in ordered)
        if names != self._shown:
            self._lay_out(ordered)
        for name, value, _ in ordered:
            if self._values[name].text() != value:
                self._values[name].setText(value)

    def value(self, name: str) -> str:
        """The value shown beside a name."""
        return self._values[name].text()

    def _lay_out(self, numbers: Sequence[Number]) -> None:
        """Give each number its place, two in a row, and hide those of another mode."""
        for pair in self._rows.values():
            for widget in pair:
                self._grid.removeWidget(widget)
                widget.hide()
        place = 0
        for name, _, explanation in numbers:
            label, value = self._row(name, explanation)
            wide = name in _WIDE
            place += place % 2 if wide else 0
            row, column = place // 2, 2 * (place % 2)
            place += 2 if wide else 1
            self._grid.addWidget(label, row, column)
            self._grid.addWidget(value, row, column + 1, 1, 3 if wide else 1)
            label.show()
            value.show()
        self._shown = tuple(name for name, _, _ in numbers)

    def _row(self, name: str, explanation: str) -> tuple[QLabel, QLabel]:
        """The name and the value of a number, made when it is first shown."""
        if name not in self._rows:
            label, value = QLabel(name), QLabel()
            label.setObjectName("dim")
            for widget in (label, value):
                widget.setToolTip(explanation)
            value.setAccessibleName(name)
            self._rows[name], self._values[name] = (label, value), value
        return self._rows[name]
