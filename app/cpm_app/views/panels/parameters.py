"""Parameters in the tab of the run: the preset, the most important sliders, and the others folded away."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from PySide6.QtCore import QEvent, QObject, Qt, Signal
from PySide6.QtGui import QPalette
from PySide6.QtWidgets import (
    QCheckBox,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from cpm_app.model.display.effects import (
    FILTER_PARAMETERS,
    MOTION_PARAMETERS,
    describe_contours_left,
    describe_effects,
)
from cpm_app.model.document import edits
from cpm_app.model.document.document import Document
from cpm_app.model.document.modes import find_effective_controls, initial_parameters
from cpm_app.model.parameters.controls import (
    AUTOMATIC_TEXTS,
    CHANNEL_CHOICE,
    MAIN_CONTROLS,
    ChoiceControl,
    Control,
    adapt_control,
    build_choice_controls,
    build_controls,
    control_value,
)
from cpm_app.model.text.language import localize_number, tr
from cpm_app.model.text.wording import PARAMETER_FORMULAS
from cpm_app.session.session import Session
from cpm_app.views.theme.icons import load_icon
from cpm_app.views.widgets.actions import ActionButton
from cpm_app.views.widgets.containers import FoldableSection, create_dim_label, fill_layout
from cpm_app.views.widgets.fields import ChoiceBox, DecimalField, MarkedSlider
from cpm_core import Parameters
from cpm_core.contours.contour import Contours

_EQUALITY_TOLERANCE = 1e-9
"""Difference up to which a value counts as the default."""

_NUMBER_FIELD_WIDTH = 64
"""Width of the field of a number [px]."""


def format_control_tip(control: Control) -> str:
    """Format the tooltip of a control, as HTML."""
    place = f" ({control.equation})" if control.equation else ""
    lines = (
        f"<b>{control.title}</b> {control.summary}",
        control.meaning,
        f"{PARAMETER_FORMULAS[control.name]}{place}",
        f"{control.effect_of_larger} {control.effect_text}",
    )
    return "".join(f"<p style='margin: 3px 0'>{line}</p>" for line in lines)


class ChoiceRow(QWidget):
    """Parameter with a few values; `change` is called with its name and the value that the user selects."""

    def __init__(self, control: ChoiceControl, change: Callable[[str, str], None]) -> None:
        super().__init__()
        self.control = control
        self.box = ChoiceBox({value: title for value, title, _ in control.choices})
        for index, (_, _, about) in enumerate(control.choices):
            self.box.setItemData(index, about, Qt.ItemDataRole.ToolTipRole)
        self.box.setAccessibleName(control.title)
        self.box.setAccessibleDescription(" ".join(control.lines))
        self.box.value_selected.connect(partial(change, control.name))
        label = QLabel(control.title)
        label.setBuddy(self.box)
        self.setToolTip("".join(f"<p>{line}</p>" for line in control.lines))
        fill_layout(QHBoxLayout(self), label, self.box, margins=(0, 2, 0, 2), wide=label)


class ParameterRow(QWidget):
    """One parameter: label, number, slider, and a button that restores its default."""

    changed = Signal(str, object)
    """Name of the control and its new value."""
    released = Signal()
    """The user has finished one change."""

    def __init__(self, control: Control) -> None:
        super().__init__()
        self.control = self._general = control
        self._label, self.effect = QLabel(control.label), create_dim_label()
        limits = control.low, control.high, control.step
        self.number = DecimalField(*limits, control.decimals, words=control.value_words)
        self.slider = MarkedSlider(control.slider_low, control.slider_high, control.step)
        self._automatic = QCheckBox(tr("auto")) if control.can_be_automatic else None
        self._restore = QToolButton()
        self._label.setBuddy(self.number)
        self._label.installEventFilter(self)
        self.number.setAlignment(Qt.AlignmentFlag.AlignRight)
        self.number.setButtonSymbols(DecimalField.ButtonSymbols.NoButtons)
        self.number.setFixedWidth(_NUMBER_FIELD_WIDTH)
        self.number.valueChanged.connect(self._on_value_changed)
        self.number.editingFinished.connect(self.released)
        self.slider.moved_to.connect(self._on_value_changed)
        self.slider.sliderReleased.connect(self.released)
        self.slider.restored.connect(self._restore_default)
        for field in (self.number, self.slider):
            field.setAccessibleName(control.title)
            field.installEventFilter(self)
            if control.manual_default is not None:
                field.show_value(control.manual_default)
        self._restore.setObjectName("restore")
        self._restore.setIcon(load_icon("restore", QPalette.ColorRole.Highlight))
        self._restore.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self._restore.setAccessibleName(tr("{parameter}: restore the default", parameter=control.title))
        self._restore.clicked.connect(self._restore_default)
        if self._automatic is not None:
            self._automatic.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            self._automatic.setToolTip(AUTOMATIC_TEXTS.get(control.name, ""))
            self._automatic.clicked.connect(
                lambda on: self._report_single_change("auto" if on else self.number.value())
            )
        self._lay_out()
        self.set_control(control)

    def show_value(self, value: float | str) -> None:
        """Show a value or ``"auto"``."""
        control, default = self.control, self.control.default
        by_hand = not isinstance(value, str)
        if self._automatic is not None:
            self._automatic.setChecked(not by_hand)
        self.number.setEnabled(by_hand)
        self.slider.setEnabled(by_hand)
        same = value == default
        if not isinstance(value, str):
            self.slider.show_value(value)
            self.number.setSuffix(f" {control.unit}" if control.unit and value not in dict(control.value_words) else "")
            self.number.show_value(value)
            same = not isinstance(default, str) and abs(value - default) < _EQUALITY_TOLERANCE
        self._restore.setVisible(not same)

    def adapt_to_image(self, usual: Parameters, ndim: int, contrast: float) -> None:
        """Adapt range, default and explanation to an image; see `adapt_control`."""
        self.set_control(adapt_control(self._general, usual, ndim, contrast))

    def set_control(self, control: Control) -> None:
        """Take range, default and explanation from a control."""
        self.control, default = control, control.default
        numeric = None if isinstance(default, str) else default
        self.slider.set_range(control.slider_low, control.slider_high, control.step, numeric)
        for field in (self.number, self.slider):
            field.setAccessibleDescription(f"{control.summary}. {control.meaning} {control.effect_of_larger}")
        self.setToolTip(format_control_tip(control))
        restore = tr("Restore the default, {default} (or double-click the slider or its name).")
        self._restore.setToolTip(
            restore.format(default=default if numeric is None else localize_number(f"{numeric:.4g}"))
        )

    def show_effect(self, words: str) -> None:
        """Show the effect of the current value below the slider."""
        self.effect.setText(words)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """End a change when the focus leaves, and restore the default on a double click on the name."""
        if watched is self._label:
            if event.type() == QEvent.Type.MouseButtonDblClick:
                self._restore_default()
        elif event.type() == QEvent.Type.FocusOut:
            self.released.emit()
        return False

    def _lay_out(self) -> None:
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 2, 0, 2)
        grid.setVerticalSpacing(0)
        grid.setHorizontalSpacing(4)
        grid.addWidget(self._label, 0, 0)
        grid.addWidget(self.slider, 1, 0, 1, 4)  # before the number, so that Tab reaches it first
        if self._automatic is not None:
            grid.addWidget(self._automatic, 0, 1)
        grid.addWidget(self._restore, 0, 2)
        grid.addWidget(self.number, 0, 3)
        grid.addWidget(self.effect, 2, 0, 1, 4)
        grid.setColumnStretch(0, 1)
        # its line is there before there is an effect, so that a run moves no slider
        self.effect.setFixedHeight(self.fontMetrics().height())
        self.effect.setVisible(self.control.name in (*MOTION_PARAMETERS, *FILTER_PARAMETERS))

    def _on_value_changed(self, value: float) -> None:
        self.changed.emit(self.control.name, int(value) if self.control.is_whole else value)

    def _restore_default(self) -> None:
        self._report_single_change(self.control.default)

    def _report_single_change(self, value: float | str) -> None:
        """Report a value as one complete change."""
        self.released.emit()
        self.changed.emit(self.control.name, value)
        self.released.emit()


class ParametersPanel(QWidget):
    """Parameters of the document and presets, which are edited through the session."""

    def __init__(self, session: Session, presets: QWidget) -> None:
        super().__init__()
        self._session = session
        self._contours: Contours = ()
        self._length = 0.0
        """Length of all contours [px]."""
        self._counts_before: dict[str, int] = {}
        """Number of contours when the user pressed a slider, by parameter."""
        self.rows = {control.name: ParameterRow(control) for control in build_controls()}
        self.choices = {control.name: ChoiceRow(control, self.set_parameter) for control in build_choice_controls()}
        self.presets = presets
        self._acting: frozenset[str] = frozenset((*self.rows, *self.choices))
        self._shown: tuple[object, ...] = ()
        """Document values that the rows show."""
        self.more = self._lay_out()
        for name, row in self.rows.items():
            row.changed.connect(self.set_parameter)
            row.released.connect(session.end_gesture)
            row.slider.sliderPressed.connect(partial(self._on_slider_held, name, True))
            row.slider.sliderReleased.connect(partial(self._on_slider_held, name, False))
        session.store.status_changed.connect(
            self._on_status_changed
        )  # not with each step: new words make Qt lay out all rows
        session.document_changed.connect(self.show_document)
        self.show_document(session.document)

    def show_document(self, document: Document) -> None:
        """Show those parameters of a document that matter in its mode."""
        contrast = document.image.contrast if document.image else 0.0
        usual = document.fit_scales(initial_parameters(document.mode, document.image))
        dimension = len(document.image.shape) if document.image else 2
        acting = find_effective_controls(document.mode, dimension)
        image = self._session.image
        if image is None or image.colors is None:
            acting = acting - {CHANNEL_CHOICE}
        shown = document.parameters, usual, dimension, contrast, acting
        if shown == self._shown:
            return
        self._shown = shown
        for name, row in (*self.rows.items(), *self.choices.items()):
            if (name in acting) != (name in self._acting):  # showing a row is slow
                row.setVisible(name in acting)
        self._acting = acting
        for name, row in self.rows.items():
            row.adapt_to_image(usual, dimension, contrast)
            row.show_value(control_value(document.parameters, name))
        self._show_effects()
        for name, choice in self.choices.items():
            choice.box.show_value(str(control_value(document.parameters, name)))

    def _lay_out(self) -> FoldableSection:
        more = QWidget()
        others = (choice for name, choice in self.choices.items() if name != CHANNEL_CHOICE)
        fill_layout(
            QVBoxLayout(more),
            *others,
            *(row for name, row in self.rows.items() if name not in MAIN_CONTROLS),
            spacing=0,
        )
        section = FoldableSection(tr("More parameters"), more)
        heading = QLabel(tr("Preset"))
        heading.setObjectName("heading")
        heading.setBuddy(self.presets)
        style = Qt.ToolButtonStyle.ToolButtonIconOnly
        save, delete = ActionButton("save_preset", style), ActionButton("delete_preset", style)
        head = fill_layout(QHBoxLayout(), heading, self.presets, save, delete, spacing=2, wide=self.presets)
        # the channel is not folded away: it is the first thing that a color image needs
        shown = self.choices[CHANNEL_CHOICE], *(self.rows[name] for name in MAIN_CONTROLS)
        fill_layout(QVBoxLayout(self), head, *shown, section, spacing=2)
        return section

    def set_parameter(self, name: str, value: float | str) -> None:
        """Set a parameter of the document."""
        title = (self.rows.get(name) or self.choices[name]).control.title
        change = tr("change of {parameter}", parameter=title.lower())
        before = self._session.document
        self._session.edit(change, lambda document: edits.set_parameter(document, name, value), f"parameter {name}")
        # A rejected value must not stay visible; an accepted one is shown through the signal.
        if self._session.document is before:
            self._shown = ()
            self.show_document(before)

    def _on_status_changed(self) -> None:
        """Show the effects of the parameters, and count the contours again if they have changed."""
        scene = self._session.scene
        if scene.contours is not self._contours:
            self._contours = scene.contours
            self._length = sum(contour.length for contour in scene.contours)
            self._show_effects()
        state = None if scene.snapshot is None else scene.snapshot.state
        for name, words in describe_effects(
            state, scene.document.parameters, self._length, scene.document.image
        ).items():
            self.rows[name].show_effect(words)

    def _show_effects(self) -> None:
        for name in FILTER_PARAMETERS:
            words = describe_contours_left(len(self._contours), self._counts_before.get(name))
            self.rows[name].show_effect(words)

    def _on_slider_held(self, name: str, held: bool) -> None:
        """Remember the number of contours while a slider is pressed."""
        self._counts_before = {name: len(self._contours)} if held else {}
        if not held:
            self._show_effects()
