"""The panel of parameters: the preset, the main sliders, the advanced ones folded away, and an explanation."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import QEvent, QObject, QPoint, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QAction, QEnterEvent, QResizeEvent, QWheelEvent
from PySide6.QtWidgets import (
    QApplication,
    QCheckBox,
    QComboBox,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QSizePolicy,
    QToolButton,
    QVBoxLayout,
    QWhatsThis,
    QWidget,
)

from app.model.display.filter_counts import FILTERS, GAP, FilterCounts
from app.model.document import edits
from app.model.document.document import Document
from app.model.document.modes import acting_in
from app.model.parameters.controls import (
    CHANNEL,
    ChoiceControl,
    Control,
    choice_controls,
    controls,
    in_dimension,
    slider_range,
    value_of,
)
from app.model.text.language import tr, written
from app.model.text.wording import FIRST_WORDING, Wording
from app.session.scene import NO_CONTOURS, ReviewedContours
from app.session.session import Session
from app.views.theme.icons import icon
from app.views.theme.theme import Theme
from app.views.widgets.containers import Scrolled, Section
from app.views.widgets.fields import DecimalField, MarkedSlider

_SAME = 1e-9

_WIDTH, _ARROWS, _LONGEST = 106, 44, "0000.0"
"""Width of the field of a number, that of its arrows and margins [px], and a number that has room with any unit."""

_LOWEST, _ROWS = 120, 96
"""Minimum height of the panel, and height that is left to the sliders when the explanation is shown [px]."""

_EXPLAINED_FROM, _LINES = 800, 14
"""Height of the window from which the explanation is shown [px], and its height [lines].

It does not depend on what is folded next to it, so that it stays the same while one works.
"""


def tip(control: Control) -> str:
    """The explanation of a control."""
    place = f" ({control.equation})" if control.equation else ""
    lines = (
        f"<b>{control.title}</b> {control.facts}",
        control.meaning,
        f"{control.formula}{place}",
        f"{control.more} {control.acts}",
    )
    return "".join(f"<p style='margin: 3px 0'>{line}</p>" for line in lines)


class Box(QComboBox):
    """A combo box; the wheel changes it only while it has the focus."""

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Scroll the column unless the box has the focus."""
        if self.hasFocus():
            super().wheelEvent(event)
        else:
            event.ignore()


class ChoiceRow(QWidget):
    """Shows one choice and reports what the user takes."""

    changed = Signal(str, object)
    """Name of the parameter and its new value."""

    def __init__(self, control: ChoiceControl) -> None:
        super().__init__()
        self.control = control
        self.box = Box()
        for value, title, about in control.choices:
            self.box.addItem(title, value)
            self.box.setItemData(self.box.count() - 1, about, Qt.ItemDataRole.ToolTipRole)
        self.box.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.box.setAccessibleName(control.title)
        self.box.setAccessibleDescription(control.explanation)
        label = QLabel(control.title)
        label.setBuddy(self.box)
        for widget in (label, self.box):
            widget.setToolTip("".join(f"<p>{line}</p>" for line in control.lines))
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 2, 0, 2)
        row.addWidget(label, 1)
        row.addWidget(self.box)
        self.box.activated.connect(lambda index: self.changed.emit(control.name, self.box.itemData(index)))

    def show_value(self, value: str) -> None:
        """Show the value of a document."""
        self.box.setCurrentIndex(self.box.findData(value))


class ParameterRow(QWidget):
    """One parameter: label, number, slider, and a button that restores its default; reports what the user changes."""

    changed = Signal(str, object)
    """Name of the control and its new value."""
    released = Signal()
    """The user has finished one change."""
    explained = Signal(object)
    """The pointer or the focus is on this control."""

    def __init__(self, control: Control) -> None:
        super().__init__()
        self.control = self._in_image = control
        numeric = control.default if isinstance(control.default, float | int) else None
        self._label, self.effect = QLabel(), QLabel()
        self.number = DecimalField(control.words)
        self.slider = MarkedSlider(control.slider_low, control.slider_high, control.step, numeric)
        self._automatic = QCheckBox(tr("auto")) if control.automatic else None
        self._restore = QToolButton()
        self._set_up()
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 2, 0, 2)
        grid.setVerticalSpacing(0)
        grid.setHorizontalSpacing(6)
        grid.addWidget(self._label, 0, 0)
        grid.addWidget(self.slider, 1, 0, 1, 3)  # before the number, so that Tab reaches it first
        if self._automatic is not None:
            grid.addWidget(self._automatic, 0, 1)
        grid.addWidget(self.number, 0, 2, 1, 2, Qt.AlignmentFlag.AlignRight)
        grid.addWidget(self._restore, 1, 3, Qt.AlignmentFlag.AlignRight)
        grid.addWidget(self.effect, 2, 0, 1, 3)
        grid.setColumnStretch(0, 1)
        self._connect()

    def show_value(self, value: float | str, contrast: float) -> None:
        """Show a value or ``"auto"``; the range of some sliders depends on the contrast of the image."""
        control = self.control
        low, high = slider_range(control, contrast)
        step = control.step * (high - low) / (control.slider_high - control.slider_low)
        self.slider.set_range(low, high, step)
        by_hand = not isinstance(value, str)
        if self._automatic is not None:
            self._automatic.setChecked(not by_hand)
        self.number.setEnabled(by_hand)
        self.slider.setEnabled(by_hand)
        if not isinstance(value, str):
            self.slider.show_value(value)
            spoken = value in dict(control.words)
            self.number.setSuffix(f" {control.unit}" if control.unit and not spoken else "")
            self.number.show_value(value)
        default = control.default
        same = value == default if isinstance(value, str) or isinstance(default, str) else abs(value - default) < _SAME
        self._restore.setEnabled(not same)

    def use_dimension(self, ndim: int) -> None:
        """Explain it for an image, or for a volume, which has three axes."""
        made = in_dimension(self._in_image, ndim)
        if made != self.control:
            self.control = made
            for widget in (self._label, self.number, self.slider):
                widget.setToolTip(tip(made))

    def show_effect(self, words: str) -> None:
        """Show what the present value changes, below the slider."""
        self.effect.setText(words)
        self.effect.setVisible(bool(words))

    def use_wording(self, wording: Wording) -> None:
        """Label it by name or by symbol first."""
        self._label.setText(self.control.label(wording))

    def menu_at(self, point: QPoint | None) -> tuple[str, QPoint]:
        """The parameter. See `MenuOwner`."""
        if not self.actions():
            self._add_actions()
        return "parameter", point if point is not None else self.slider.geometry().center()

    def use_theme(self, theme: Theme) -> None:
        """Color the button."""
        self._restore.setIcon(icon("restore", theme.accent, faded=theme.line))

    def enterEvent(self, event: QEnterEvent) -> None:
        """Explain the control under the pointer."""
        self.explained.emit(self.control)
        super().enterEvent(event)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Explain the control with the focus, and restore the default on a double click on the name."""
        if watched is self._label:
            if event.type() == QEvent.Type.MouseButtonDblClick:
                self._reset()
        elif event.type() == QEvent.Type.FocusIn:
            self.explained.emit(self.control)
        elif event.type() == QEvent.Type.FocusOut:
            self.released.emit()
        return False

    def _set_up(self) -> None:
        control = self.control
        self.number.setRange(control.low, control.high)
        self.number.setSingleStep(control.step)
        self.number.setDecimals(control.decimals)
        self.number.setKeyboardTracking(False)
        self.number.setAlignment(Qt.AlignmentFlag.AlignRight)
        longest = self.number.fontMetrics().horizontalAdvance(f"{_LONGEST} {control.unit}")
        self.number.setFixedWidth(max(_WIDTH, longest + _ARROWS))
        self.effect.setObjectName("dim")
        self.effect.hide()
        self._restore.setObjectName("restore")
        self._restore.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self._restore.setAccessibleName(tr("{parameter}: restore the default").format(parameter=control.title))
        default = control.default if isinstance(control.default, str) else written(f"{control.default:.4g}")
        restore = tr("Restore the default, {default} (or double-click the slider or its name).")
        self._restore.setToolTip(restore.format(default=default))
        self._label.setBuddy(self.number)
        self._label.installEventFilter(self)
        for widget in (self._label, self.number, self.slider):
            widget.setToolTip(tip(control))
        self.use_wording(FIRST_WORDING)
        for field in (self.number, self.slider):
            field.setAccessibleName(control.title)
            field.setAccessibleDescription(f"{control.facts}. {control.meaning} {control.more}")
            field.installEventFilter(self)
        if control.by_hand is not None:
            self.number.show_value(control.by_hand)
            self.slider.show_value(control.by_hand)
        if self._automatic is not None:
            self._automatic.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            self._automatic.setToolTip(control.by_itself)
            self._automatic.installEventFilter(self)

    def _connect(self) -> None:
        self.slider.moved_to.connect(self._report)
        self.slider.sliderReleased.connect(self.released)
        self.slider.restored.connect(self._reset)
        self.number.valueChanged.connect(self._report)
        self.number.editingFinished.connect(self.released)
        self._restore.clicked.connect(self._reset)
        if self._automatic is not None:
            self._automatic.clicked.connect(lambda on: self._finish("auto" if on else self.number.value()))

    def _add_actions(self) -> None:
        """Make the actions of its menu, when that is opened first."""
        for text, do in (
            (tr("&Restore the default"), self._reset),
            (tr("&Copy the value"), lambda: QApplication.clipboard().setText(f"{self.number.exact:.10g}")),
            (tr("&Explain"), lambda: QWhatsThis.showText(self.mapToGlobal(QPoint(0, 0)), tip(self.control), self)),
        ):
            action = QAction(text, self)
            action.triggered.connect(lambda _=False, do=do: do())
            self.addAction(action)

    def _report(self, value: float) -> None:
        self.changed.emit(self.control.name, int(value) if self.control.whole else value)

    def _reset(self) -> None:
        self._finish(self.control.default)

    def _finish(self, value: float | str) -> None:
        """Report a value that is a change of its own."""
        self.released.emit()
        self.changed.emit(self.control.name, value)
        self.released.emit()


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
        self.explanation = QLabel()
        self.explanation.setObjectName("explanation")
        self.explanation.setWordWrap(True)
        self.explanation.setAlignment(Qt.AlignmentFlag.AlignTop | Qt.AlignmentFlag.AlignLeft)
        self.explanation.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        # that of the longest explanation, so that the layout stays the same for all of them
        self.explanation.setFixedHeight(_LINES * self.fontMetrics().lineSpacing())
        self._explained = ""
        self.advanced = self._lay_out()
        for row in self.rows.values():
            row.changed.connect(self.change)
            row.released.connect(session.seal)
            row.explained.connect(self._explain)
            row.slider.sliderPressed.connect(partial(self._hold, row.control.name))
            row.slider.sliderReleased.connect(partial(self._release, row.control.name))
        session.scene_changed.connect(self._follow)
        for choice in self.choices.values():
            choice.changed.connect(self.change)
        session.document_changed.connect(self.show_document)
        self.show_document(session.document)

    def show_document(self, document: Document) -> None:
        """Show the parameters of a document."""
        contrast = document.image.contrast if document.image else 0.0
        acting = self._show_acting(document)
        for name, row in self.rows.items():
            row.use_dimension(len(document.image.shape) if document.image else 2)
            row.show_value(value_of(document.parameters, name), contrast)
        self._show_effects()
        for name, choice in self.choices.items():
            choice.show_value(str(value_of(document.parameters, name)))
        if self._explained not in acting:
            self._explained = next(name for name in self.rows if name in acting)
        self._explain(self.rows[self._explained].control)

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

    def use_theme(self, theme: Theme) -> None:
        """Color the buttons."""
        for row in self.rows.values():
            row.use_theme(theme)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Show the explanation where the window has room for it."""
        super().resizeEvent(event)
        left = self.height() - self.presets.sizeHint().height() - self.explanation.height()
        self.explanation.setVisible(self.window().height() >= _EXPLAINED_FROM and left >= _ROWS)

    def minimumSizeHint(self) -> QSize:
        """Room for the presets and two rows; the rest scrolls."""
        return QSize(super().minimumSizeHint().width(), _LOWEST)

    def _lay_out(self) -> Section:
        advanced = QWidget()
        rows = QVBoxLayout(advanced)
        rows.setContentsMargins(0, 0, 0, 0)
        for name, choice in self.choices.items():
            if name != CHANNEL:
                rows.addWidget(choice)
        scrolled = QWidget()
        area = Scrolled(
            scrolled, _LOWEST
        )  # while it is empty: it lays out its content at once, and again in the window
        column = QVBoxLayout(scrolled)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self.choices[CHANNEL])  # not hidden under "Advanced": a color image needs it first
        for row in self.rows.values():
            (rows if row.control.advanced else column).addWidget(row)
        section = Section(tr("Advanced"), advanced, unfolded=False)
        column.addWidget(section)
        column.addStretch(1)
        # The unfolded rows are scrolled into view after the layout has placed them.
        section.fold.toggled.connect(
            lambda unfolded: QTimer.singleShot(
                0, area, lambda: area.verticalScrollBar().setValue(section.y() if unfolded else 0)
            )
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

    def _release(self, name: str) -> None:
        self._before.pop(name, None)
        self._show_effects()

    def _colored(self) -> bool:
        image = self._session.image
        return image is not None and image.colors is not None

    def _title(self, name: str) -> str:
        return (self.rows[name] if name in self.rows else self.choices[name]).control.title

    def _explain(self, control: Control) -> None:
        self._explained = control.name
        self.explanation.setText(tip(control))
