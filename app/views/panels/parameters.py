"""The panel of parameters: presets, the three live ones, and the others tucked away."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt, QTimer
from PySide6.QtWidgets import QComboBox, QFrame, QHBoxLayout, QLabel, QScrollArea, QVBoxLayout, QWidget

from app.model import edits
from app.model.controls import Control, controls, value_of
from app.model.document import Document
from app.session.session import Session
from app.views.panels.parameter_row import ParameterRow
from app.views.panels.section import Section
from app.views.theme import Theme
from cpm_core.parameters import PRESETS

_PRESET_TITLES = {"shape": "Shape recovery", "automatic": "Automatic segmentation", "noisy": "Noisy image"}
_OWN = "Own settings"
_EXPLANATION_LINES = 4


class ParametersPanel(QWidget):
    """Shows the parameters of the document and edits them through the session."""

    def __init__(self, session: Session) -> None:
        super().__init__()
        self._session = session
        self.rows = {control.name: ParameterRow(control) for control in controls()}
        self.presets = self._make_presets()
        self._explanation = QLabel()
        self.advanced = self._lay_out()
        for row in self.rows.values():
            row.changed.connect(self._change)
            row.settled.connect(session.seal)
            row.explained.connect(self._explain)
        session.document_changed.connect(self.show_document)
        self._explain(next(iter(self.rows.values())).control)
        self.show_document(session.document)

    def show_document(self, document: Document) -> None:
        """Show the parameters of a document."""
        contrast = document.image.contrast if document.image else 0.0
        for name, row in self.rows.items():
            row.show_value(value_of(document.parameters, name), contrast)
        names = list(PRESETS)
        same = [name for name in names if PRESETS[name] == document.parameters]
        self.presets.setCurrentIndex(names.index(same[0]) if same else -1)

    def use_theme(self, theme: Theme) -> None:
        """Tint the buttons."""
        for row in self.rows.values():
            row.use_theme(theme)

    def _make_presets(self) -> QComboBox:
        presets = QComboBox()
        presets.setPlaceholderText(_OWN)
        presets.setAccessibleName("Preset")
        presets.setToolTip("Settings that have proved good for a kind of task.")
        for name in PRESETS:
            presets.addItem(_PRESET_TITLES.get(name, name.capitalize()), name)
        presets.activated.connect(self._use_preset)
        return presets

    def _lay_out(self) -> Section:
        advanced = QWidget()
        rows = QVBoxLayout(advanced)
        rows.setContentsMargins(0, 0, 0, 0)
        scrolled = QWidget()
        scrolled.setObjectName("scrolled")
        column = QVBoxLayout(scrolled)
        column.setContentsMargins(0, 0, 8, 0)
        column.setSpacing(2)
        for row in self.rows.values():
            (rows if row.control.advanced else column).addWidget(row)
        section = Section("Advanced", advanced, unfolded=False)
        column.addWidget(section)
        column.addStretch(1)
        area = QScrollArea()
        area.setWidget(scrolled)
        area.setWidgetResizable(True)
        area.viewport().setAutoFillBackground(False)
        scrolled.setAutoFillBackground(False)
        area.setFrameShape(QFrame.Shape.NoFrame)
        area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        # What has been unfolded is brought into sight once it has got its place.
        section.fold.toggled.connect(
            lambda unfolded: QTimer.singleShot(0, area, lambda: self._bring_into_sight(area, section, unfolded))
        )
        head = QHBoxLayout()
        heading = QLabel("Parameters")
        heading.setObjectName("heading")
        head.addWidget(heading)
        head.addStretch(1)
        head.addWidget(self.presets)
        self._explanation.setObjectName("explanation")
        self._explanation.setWordWrap(True)
        self._explanation.setAlignment(Qt.AlignmentFlag.AlignTop)
        self._explanation.setFixedHeight(_EXPLANATION_LINES * self._explanation.fontMetrics().lineSpacing() + 8)
        self._explanation.setContentsMargins(0, 4, 0, 0)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(4)
        layout.addLayout(head)
        layout.addWidget(area, 1)
        layout.addWidget(self._explanation)
        return section

    def minimumSizeHint(self) -> QSize:
        """Room for the presets, one row and the explanation; the rest scrolls."""
        return QSize(super().minimumSizeHint().width(), 190)

    @staticmethod
    def _bring_into_sight(area: QScrollArea, section: Section, unfolded: bool) -> None:
        area.verticalScrollBar().setValue(section.y() if unfolded else 0)

    def _change(self, name: str, value: float | str) -> None:
        title = self.rows[name].control.title.lower()
        self._session.edit(
            f"change of {title}", lambda document: edits.set_parameter(document, name, value), f"parameter {name}"
        )
        # A value that was refused must not stay on show.
        self.show_document(self._session.document)

    def _use_preset(self, index: int) -> None:
        name = self.presets.itemData(index)
        self._session.edit(
            f"preset “{self.presets.itemText(index)}”", lambda document: edits.use_preset(document, name)
        )

    def _explain(self, control: Control) -> None:
        self._explanation.setText(f"<b>{control.symbol}</b>{control.facts[len(control.symbol) :]}<br>{control.more}")
