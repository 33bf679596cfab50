"""What leads the runs of the comparison: run, pause, step, stop, and a line along which their states are looked at."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QSlider, QWidget

from app.model.text.language import tr
from app.model.text.numbers import written

_NOTCHES = 1000


class Transport(QWidget):
    """Buttons and a slider; the slider at its end follows the newest states."""

    looked = Signal()
    """Another place on the line has been chosen."""

    def __init__(self) -> None:
        super().__init__()
        self.run_button, self.stop_button = QPushButton(tr("Run")), QPushButton(tr("Stop"))
        self.pause_button, self.step_button = QPushButton(), QPushButton(tr("Step"))
        self.run_button.setToolTip(tr("Run all methods from the beginning."))
        self.step_button.setToolTip(tr("Do one step of each method."))
        self.stop_button.setToolTip(tr("End all runs; what they have found so far stays."))
        self.slider = QSlider(Qt.Orientation.Horizontal)
        self.slider.setRange(0, _NOTCHES)
        self.slider.setPageStep(_NOTCHES // 20)
        self.slider.setAccessibleName(tr("Steps of the methods"))
        self.slider.setToolTip(
            tr("Look back: each method is shown after the same share of its own steps. At the end it follows the runs.")
        )
        self.words = QLabel()
        self.words.setMinimumWidth(self.words.fontMetrics().horizontalAdvance(_share(_NOTCHES // 2)))
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        for button in (self.run_button, self.pause_button, self.step_button, self.stop_button):
            button.setAutoDefault(False)  # Enter in a field takes its value, and is no order to run all
            row.addWidget(button)
        row.addWidget(self.slider, 1)
        row.addWidget(self.words)
        self.slider.valueChanged.connect(self._look)
        self.follow()
        self.show_state(running=False, held=False)

    @property
    def share(self) -> float:
        """The share of the steps that is looked at, from 0 to 1, which is the newest state."""
        return self.slider.value() / _NOTCHES

    def follow(self) -> None:
        """Go to the end, which follows the newest states."""
        self.slider.setValue(_NOTCHES)
        self._look()

    def show_state(self, *, running: bool, held: bool) -> None:
        """Show what can be done now."""
        self.pause_button.setText(tr("Resume") if held else tr("Pause"))
        self.pause_button.setToolTip(tr("Let all methods run on.") if held else tr("Hold all methods where they are."))
        self.pause_button.setEnabled(running)
        self.stop_button.setEnabled(running)

    def _look(self) -> None:
        self.words.setText("" if self.share == 1.0 else _share(self.slider.value()))
        self.looked.emit()


def _share(value: int) -> str:
    return tr("{percent} % of the steps").format(percent=written(f"{100.0 * value / _NOTCHES:.0f}"))
