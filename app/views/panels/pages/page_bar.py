"""The line below the canvas that chooses which page of a stack is shown, and runs all of them."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QCheckBox, QFrame, QHBoxLayout, QLabel, QPushButton, QSlider, QSpinBox

from app.model.text.keys import with_keys
from app.model.text.language import tr

_JUMP = 10


class PageBar(QFrame):
    """Slider and number of the page, whether pages follow each other, and a button that runs all."""

    moved = Signal(int)
    """The user wants a page."""
    asked = Signal()
    """The user wants to run all pages, or to stop that."""
    followed = Signal(bool)
    """The user has chosen whether each page starts from the contours of the one before."""

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("slices")
        self.slider, self.number, self.of = QSlider(Qt.Orientation.Horizontal), QSpinBox(), QLabel()
        self.follow, self.run = QCheckBox(tr("Follow")), QPushButton()
        self.slider.setAccessibleName(tr("Page"))
        self.slider.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.slider.setPageStep(_JUMP)
        self.slider.setTracking(False)
        self.number.setAccessibleName(tr("Number of the page"))
        self.number.setKeyboardTracking(False)
        self.of.setObjectName("dim")
        self.follow.setToolTip(
            tr("Start each page from the contours of the one before, not each one from the same drawing.")
        )
        self.follow.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.run.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        row = QHBoxLayout(self)
        row.setContentsMargins(10, 3, 10, 3)
        row.setSpacing(4)
        row.addWidget(QLabel(tr("Page")))
        row.addWidget(self.slider, 1)
        for widget in (self.number, self.of, self.follow, self.run):
            row.addWidget(widget)
        row.insertSpacing(4, 8)
        self.slider.valueChanged.connect(self.moved)
        self.number.valueChanged.connect(self.moved)
        self.follow.toggled.connect(self.followed)
        self.run.clicked.connect(self.asked)
        self.hide()

    def show_keys(self) -> None:
        """Name the keys as they are now."""
        self.slider.setToolTip(with_keys(tr("Go through the pages: {key:previous_slice} and {key:next_slice}.")))

    def show_pages(self, number: int, count: int, *, following: bool, running: bool, possible: bool) -> None:
        """Show which page is open; hidden where there are not several."""
        self.setVisible(count > 1)
        for field in (self.slider, self.number):
            field.blockSignals(True)
            field.setRange(1, max(count, 1))
            field.setValue(number)
            field.blockSignals(False)
        self.of.setText(tr("of {last}").format(last=count))
        self.follow.blockSignals(True)
        self.follow.setChecked(following)
        self.follow.blockSignals(False)
        self.run.setText(tr("Stop") if running else tr("Run all pages"))
        self.run.setToolTip(
            tr("Stop after the pages that are done.")
            if running
            else tr("Run every page of the stack, one after the other, in the background.")
        )
        self.run.setEnabled(running or possible)
