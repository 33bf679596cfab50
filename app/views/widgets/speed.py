"""The speed control in the tool bar."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QHBoxLayout, QLabel, QSizePolicy, QSlider, QWidget

from app.model.state.resolve import FIRST_PACE, PACES, pace_text
from app.model.text.language import tr
from app.session.session import Session


class SpeedControl(QWidget):
    """A slider from one step per second to as many as possible."""

    def __init__(self, session: Session) -> None:
        super().__init__()
        self._session = session
        self.slider = QSlider(Qt.Orientation.Horizontal)
        self.slider.setRange(0, len(PACES) - 1)
        self.slider.setPageStep(1)
        self.slider.setValue(FIRST_PACE)
        self.slider.setFixedWidth(96)
        self.slider.setAccessibleName(tr("Speed"))
        self.slider.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.label = QLabel(pace_text(PACES[FIRST_PACE]))
        self.label.setMinimumWidth(self.label.fontMetrics().horizontalAdvance(max(map(pace_text, PACES), key=len)) + 8)
        name = QLabel(tr("Speed"))
        name.setObjectName("dim")
        for widget in (self, self.slider, self.label, name):
            widget.setToolTip(tr("Largest number of steps per second ([ slower, ] faster)."))
        layout = QHBoxLayout(self)
        layout.setContentsMargins(6, 0, 6, 0)
        layout.addWidget(name)
        layout.addWidget(self.slider)
        layout.addWidget(self.label)
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Preferred)
        self.slider.valueChanged.connect(self._change)

    def faster(self) -> None:
        """One notch up."""
        self.slider.setValue(self.slider.value() + 1)

    def slower(self) -> None:
        """One notch down."""
        self.slider.setValue(self.slider.value() - 1)

    def _change(self, index: int) -> None:
        self.label.setText(pace_text(PACES[index]))
        self._session.set_pace(PACES[index])
