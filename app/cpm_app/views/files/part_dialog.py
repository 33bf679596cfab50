"""The dialog that asks which part of a file is opened: all pages as a volume or one of them, channel, time, series."""

from __future__ import annotations

from dataclasses import replace

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox, QDialog, QFormLayout, QLabel, QSpinBox, QWidget

from cpm_app.model.text.language import tr
from cpm_app.model.volume.parts import Parts
from cpm_app.views.widgets.containers import AcceptButtons, lay_out_form
from cpm_core.formats import Reading
from cpm_core.image import COLORS

_PAGE = {"plane": tr("Plane"), "page": tr("Page"), "frame": tr("Frame")}
_COLORS = {
    "luminance": tr("Perceived brightness"),
    "red": tr("Red"),
    "green": tr("Green"),
    "blue": tr("Blue"),
    "contrast": tr("Channel with the largest variation"),
}


class PartDialog(QDialog):
    """Shows what a file holds, and takes one part of it.

    Parameters
    ----------
    parent : QWidget
        The window.
    name : str
        The file.
    parts : Parts
        What it holds.
    reading : Reading
        What is open.
    as_volume : bool
        Whether that is a volume.
    colored : bool
        Whether the file has colors.
    """

    asked = Signal(int)
    """The user wants to know what another series holds: its number, from 1."""
    chosen = Signal(object, object)
    """The user has chosen: whether a volume is opened, None for the series in its folder, and the reading."""

    def __init__(
        self, parent: QWidget, name: str, parts: Parts, reading: Reading, as_volume: bool, colored: bool
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle(tr("Part of the file"))
        self._reading = reading
        self._parts = parts
        self.series, self.kind, self.color = QComboBox(), QComboBox(), QComboBox()
        self.page, self.channel, self.time = QSpinBox(), QSpinBox(), QSpinBox()
        self._page_label = QLabel()
        self._form = QFormLayout()
        self.series.addItems([f"{number}: {title}" for number, title in enumerate(parts.series, start=1)])
        self.series.setCurrentIndex(parts.number - 1)
        self._as_volume = as_volume
        for color in COLORS:
            self.color.addItem(_COLORS[color], color)
        self.color.setCurrentIndex(COLORS.index(reading.color))
        for label, field in (
            (tr("Series"), self.series),
            (tr("Open"), self.kind),
            (self._page_label, self.page),
            (tr("Channel"), self.channel),
            (tr("Time"), self.time),
            (tr("Gray levels of colors"), self.color),
        ):
            self._form.addRow(label, field)
        self._colored = colored
        buttons = AcceptButtons(self, tr("Open"))
        self.open_button = buttons.accept_button
        lay_out_form(self, tr("Which part of {name} do you want to open?", name=name), self._form, buttons)
        self.show_parts(parts)
        self.page.setValue(reading.page or parts.usual)
        self.channel.setValue(reading.channel or 1)
        self.time.setValue(reading.time or 1)
        self.accepted.connect(lambda: self.chosen.emit(self.kind.currentData(), self.reading))
        self.series.currentIndexChanged.connect(self._ask)
        self.kind.currentIndexChanged.connect(self._enable)

    def show_parts(self, parts: Parts) -> None:
        """Show what a series holds."""
        self._parts = parts
        self._page_label.setText(_PAGE[parts.word])
        for field, count in ((self.page, parts.pages), (self.channel, parts.channels), (self.time, parts.times)):
            field.setRange(1, count)
            field.setSuffix(tr(" of {count}", count=count))
            self._form.setRowVisible(field, count > 1)
        self._form.setRowVisible(self.series, len(parts.series) > 1)
        self.kind.clear()
        if parts.fit_a_volume:
            self.kind.addItem(tr("All as one volume"), True)
        self.kind.addItem(tr("One as an image"), False)
        if parts.series_around is not None:
            self.kind.addItem(tr("The whole series in {folder}", folder=parts.series_around.name), None)
        self.kind.setCurrentIndex(0 if self._as_volume else self.kind.findData(False))
        self._form.setRowVisible(self.kind, self.kind.count() > 1)
        self.open_button.setEnabled(True)
        self._enable()

    @property
    def as_volume(self) -> bool:
        """Whether a volume is chosen."""
        return bool(self.kind.currentData())

    @property
    def reading(self) -> Reading:
        """What is chosen; what can be no other is left to the reader."""
        parts, as_volume = self._parts, self.as_volume
        several = len(parts.series) > 1
        return replace(
            self._reading,
            series=self.series.currentIndex() + 1 if several else self._reading.series,
            page=self.page.value() if parts.pages > 1 and not as_volume else None,
            channel=self.channel.value() if parts.channels > 1 else None,
            time=self.time.value() if parts.times > 1 else None,
            color=self.color.currentData() if as_volume else COLORS[0],
        )

    def _ask(self, index: int) -> None:
        """Wait for what another series holds."""
        self.open_button.setEnabled(False)
        self.asked.emit(index + 1)

    def _enable(self) -> None:
        """A volume has all pages, and an image its colors as a parameter."""
        self.page.setEnabled(self.kind.currentData() is False)
        self._form.setRowVisible(self.color, self._colored and self.as_volume)
