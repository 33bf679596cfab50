"""Dialog that asks which part of a file to open: all pages as a volume or one page, channel, time, series."""

from __future__ import annotations

from dataclasses import replace

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox, QDialog, QFormLayout, QLabel, QSpinBox, QWidget

from cpm_app.model.text.language import tr
from cpm_app.model.volume.parts import FileParts
from cpm_app.views.widgets.containers import AcceptButtons, lay_out_form
from cpm_core.formats import Reading
from cpm_core.image import COLOR_CHOICES

_PAGE_LABELS = {"plane": tr("Plane"), "page": tr("Page"), "frame": tr("Frame")}
"""Label of the page number by what a page is."""

_COLOR_READING_TITLES = {
    "luminance": tr("Perceived brightness"),
    "red": tr("Red"),
    "green": tr("Green"),
    "blue": tr("Blue"),
    "contrast": tr("Channel with the largest variation"),
}
"""Titles of the ways to make gray levels of colors."""


class PartDialog(QDialog):
    """Dialog that shows the contents of a file and asks for a part of it.

    Parameters
    ----------
    parent : QWidget
        The window.
    name : str
        Name of the file.
    parts : FileParts
        Contents of the file.
    reading : Reading
        Part that is open.
    as_volume : bool
        Whether it is open as a volume.
    colored : bool
        Whether the file has colors.
    """

    series_requested = Signal(int)
    """The user asks for the contents of another series: its number, from 1."""
    part_selected = Signal(object, object)
    """The user has selected a part: whether to open a volume, or None for the series in the folder; the reading."""

    def __init__(
        self, parent: QWidget, name: str, parts: FileParts, reading: Reading, as_volume: bool, colored: bool
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
        self.series.setCurrentIndex(parts.series_number - 1)
        self._as_volume = as_volume
        for color in COLOR_CHOICES:
            self.color.addItem(_COLOR_READING_TITLES[color], color)
        self.color.setCurrentIndex(COLOR_CHOICES.index(reading.color))
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
        self.page.setValue(reading.page or parts.default_page)
        self.channel.setValue(reading.channel or 0)
        self.time.setValue(reading.time or 1)
        self.accepted.connect(lambda: self.part_selected.emit(self.kind.currentData(), self.reading))
        self.series.currentIndexChanged.connect(self._on_series_changed)
        self.kind.currentIndexChanged.connect(self._on_kind_changed)

    def show_parts(self, parts: FileParts) -> None:
        """Show the contents of a series."""
        self._parts = parts
        self._page_label.setText(_PAGE_LABELS[parts.word])
        for field, count in ((self.page, parts.pages), (self.channel, parts.channels), (self.time, parts.times)):
            field.setRange(1, count)
            field.setSuffix(tr(" of {count}", count=count))
            self._form.setRowVisible(field, count > 1)
        if parts.has_colors:
            self.channel.setMinimum(0)
        self.channel.setSpecialValueText(tr("Red, green and blue") if parts.has_colors else "")
        self._form.setRowVisible(self.series, len(parts.series) > 1)
        self.kind.clear()
        if parts.can_be_volume:
            self.kind.addItem(tr("All as one volume"), True)
        self.kind.addItem(tr("One as an image"), False)
        if parts.series_around is not None:
            self.kind.addItem(tr("The whole series in {folder}", folder=parts.series_around.name), None)
        self.kind.setCurrentIndex(0 if self._as_volume else self.kind.findData(False))
        self._form.setRowVisible(self.kind, self.kind.count() > 1)
        self.open_button.setEnabled(True)
        self._on_kind_changed()

    @property
    def as_volume(self) -> bool:
        """Whether a volume is selected."""
        return bool(self.kind.currentData())

    @property
    def reading(self) -> Reading:
        """Selected part; where there is only one possibility, it is left to the reader."""
        parts, as_volume = self._parts, self.as_volume
        several = len(parts.series) > 1
        return replace(
            self._reading,
            series=self.series.currentIndex() + 1 if several else self._reading.series,
            page=self.page.value() if parts.pages > 1 and not as_volume else None,
            channel=(self.channel.value() or None) if parts.channels > 1 else None,
            time=self.time.value() if parts.times > 1 else None,
            color=self.color.currentData() if as_volume else COLOR_CHOICES[0],
        )

    def _on_series_changed(self, index: int) -> None:
        """Ask for the contents of another series, and wait for them."""
        self.open_button.setEnabled(False)
        self.series_requested.emit(index + 1)

    def _on_kind_changed(self) -> None:
        """Enable the page for images only, and show the reading of colors for volumes only.

        An image keeps its colors, and a parameter selects the channel.
        """
        self.page.setEnabled(self.kind.currentData() is False)
        self._form.setRowVisible(self.color, self._colored and self.as_volume)
