"""The panel of parameters: presets, the main sliders, the advanced ones folded away, and an explanation."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import QSize, QTimer
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QHBoxLayout, QLabel, QScrollArea, QToolButton, QVBoxLayout, QWidget

from app.model.display.filter_counts import FILTERS, GAP, FilterCounts
from app.model.document import edits
from app.model.document.document import Document
from app.model.document.modes import acting_in
from app.model.parameters.controls import CHANNEL, Control, choice_controls, controls, value_of
from app.model.text.language import tr
from app.model.text.wording import Wording
from app.session.scene import NO_CONTOURS, ReviewedContours
from app.session.session import Session
from app.views.panels.parameters.choice_row import ChoiceRow
from app.views.panels.parameters.explanation import Explanation, Form, form_in
from app.views.panels.parameters.parameter_row import ParameterRow
from app.views.theme.theme import Theme
from app.views.widgets.scrolled import Scroller
from app.views.widgets.section import Section

_LOWEST = 120
"""Minimum height of the panel [px]."""

_BESIDE = 28
"""Width of the margins and of the scroll bar [px]."""

_ROWS = 96
"""Height that is left to the sliders before the explanation becomes shorter [px]."""


class ParametersPanel(QWidget):
    """Shows the parameters of the document and the presets, and edits them through the session."""

    def __init__(self, session: Session, presets: QToolButton) -> None:
        super().__init__()
        self._session = session
        self._counts = FilterCounts()
        self._contours: ReviewedContours = NO_CONTOURS
        self._before: dict[str, int] = {}
        """Number of contours before a slider that is held was moved, by parameter."""
        self.rows = {control.name: ParameterRow(control) for control in controls()}
        self.choices = {control.name: ChoiceRow(control) for control in choice_controls()}
        self.presets = presets
        self._acting: frozenset[str] = frozenset((*self.rows, *self.choices))
        self.explanation = Explanation()
        self.advanced = self._lay_out()
        for row in self.rows.values():
            row.changed.connect(self.change)
            row.released.connect(session.seal)
            row.explained.connect(self._explain)
            row.slider.sliderPressed.connect(partial(self._hold, row.control.name))
            row.slider.sliderReleased.connect(partial(self._let_go, row.control.name))
        session.scene_changed.connect(self._follow)
        for choice in self.choices.values():
            choice.changed.connect(self.change)
        session.document_changed.connect(self.show_document)
        self._explain(next(iter(self.rows.values())).control)
        self.show_document(session.document)

    def show_document(self, document: Document) -> None:
        """Show the parameters of a document."""
        contrast = document.image.contrast if document.image else 0.0
        acting = self._show_acting(document)
        for name, row in self.rows.items():
            row.use_dimension(len(document.image.shape) if document.image else 2)
            row.show_value(value_of(document.parameters, name), contrast)
        self._show_effects()
        if self.explanation.control is not None and self.explanation.control.name not in acting:
            self._explain(next(row.control for name, row in self.rows.items() if name in acting))
        for name, choice in self.choices.items():
            choice.show_value(str(value_of(document.parameters, name)))
        if self.explanation.control is not None:
            self._explain(self.rows[self.explanation.control.name].control)

    def _show_acting(self, document: Document) -> frozenset[str]:
        """Show what acts in the mode of a document and hide the rest; to show a row again takes long."""
        dimension = len(document.image.shape) if document.image else 2
        named = acting_in(document.mode, dimension)
        acting = frozenset(name for name in named if name != CHANNEL or self._colored())
        for name, row in (*self.rows.items(), *self.choices.items()):
            if (name in acting) != (name in self._acting):
                row.setVisible(name in acting)
        self._acting = acting
        return acting

    def use_wording(self, wording: Wording) -> None:
        """Label everything by name or by symbol first."""
        for row in self.rows.values():
            row.use_wording(wording)
        self.explanation.use_wording(wording)

    def use_theme(self, theme: Theme) -> None:
        """Color the buttons."""
        for row in self.rows.values():
            row.use_theme(theme)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Show as much of the explanation as the window has room for."""
        super().resizeEvent(event)
        left = self.height() - self.presets.sizeHint().height() - _ROWS
        forms: tuple[Form, ...] = ("full", "brief", "hidden")
        wanted = form_in(self.window().height())
        fitting = (form for form in forms[forms.index(wanted) :] if self.explanation.height_of(form) <= left)
        self.explanation.set_form(next(fitting, "hidden"))

    def minimumSizeHint(self) -> QSize:
        """Room for the presets and two rows; the rest scrolls."""
        return QSize(self._rows.minimumSizeHint().width() + _BESIDE, _LOWEST)

    def _lay_out(self) -> Section:
        advanced = QWidget()
        rows = QVBoxLayout(advanced)
        rows.setContentsMargins(0, 0, 0, 0)
        for name, choice in self.choices.items():
            if name != CHANNEL:
                rows.addWidget(choice)
        self._rows = scrolled = QWidget()
        scrolled.setObjectName("scrolled")
        area = Scroller(scrolled)  # while it is empty: it lays out its content at once, and again in the window
        column = QVBoxLayout(scrolled)
        column.setContentsMargins(0, 0, 5, 0)
        column.setSpacing(0)
        column.addWidget(self.choices[CHANNEL])  # not hidden under "Advanced": a color image needs it first
        for row in self.rows.values():
            (rows if row.control.advanced else column).addWidget(row)
        section = Section(tr("Advanced"), advanced, unfolded=False)
        column.addWidget(section)
        column.addStretch(1)
        # The unfolded rows are scrolled into view after the layout has placed them.
        section.fold.toggled.connect(
            lambda unfolded: QTimer.singleShot(0, area, lambda: self._scroll_to(area, section, unfolded))
        )
        head = QHBoxLayout()
        heading = QLabel(tr("Preset"))
        heading.setObjectName("heading")
        heading.setBuddy(self.presets)
        head.addWidget(heading)
        head.addWidget(self.presets, 1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(12, 8, 6, 6)
        layout.setSpacing(4)
        layout.addLayout(head)
        layout.addWidget(area, 1)
        layout.addWidget(self.explanation)
        return section

    @staticmethod
    def _scroll_to(area: QScrollArea, section: Section, unfolded: bool) -> None:
        area.verticalScrollBar().setValue(section.y() if unfolded else 0)

    def change(self, name: str, value: float | str) -> None:
        """Set a parameter of the document."""
        change = tr("change of {parameter}").format(parameter=self._title(name).lower())
        before = self._session.document
        self._session.edit(change, lambda document: edits.set_parameter(document, name, value), f"parameter {name}")
        # A rejected value must not stay visible; an accepted one is shown through the signal.
        if self._session.document is before:
            self.show_document(before)

    def _follow(self) -> None:
        """Count the contours of the scene when they are others."""
        contours, document = self._session.scene.contours, self._session.document
        if contours is self._contours:
            return
        self._contours = contours
        result = contours.result
        moment = (self._session.generation, result.steps) if result is not None else None
        thresholds = {name: float(getattr(document.parameters, name)) for name in FILTERS}
        items = contours.items
        self._counts.update(moment, thresholds, [item.contour for item in items], [item.measures for item in items])
        self._show_effects()

    def _show_effects(self) -> None:
        for name in (*FILTERS, GAP):
            value = float(getattr(self._session.document.parameters, name))
            self.rows[name].show_effect(self._counts.words(name, value, self._before.get(name)))

    def _hold(self, name: str) -> None:
        self._before[name] = self._counts.present

    def _let_go(self, name: str) -> None:
        self._before.pop(name, None)
        self._show_effects()

    def _colored(self) -> bool:
        image = self._session.image
        return image is not None and image.colors is not None

    def _title(self, name: str) -> str:
        return (self.rows[name] if name in self.rows else self.choices[name]).control.title

    def _explain(self, control: Control) -> None:
        self.explanation.explain(control)
