"""Selection of what is compared: values of one or two parameters, or methods with their settings."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QFormLayout,
    QLabel,
    QLineEdit,
    QListWidget,
    QListWidgetItem,
    QScrollArea,
    QVBoxLayout,
    QWidget,
)

from cpm_app.model.display.comparison import (
    FIRST_AXES,
    Trial,
    TrialAxis,
    parse_values,
    plan_method_trials,
    plan_parameter_trials,
    propose_values,
)
from cpm_app.model.display.lengths import format_short_number
from cpm_app.model.document.modes import find_effective_controls
from cpm_app.model.parameters.controls import Control, build_controls
from cpm_app.model.text.language import tr, translate_core_text
from cpm_app.session.session import Session
from cpm_app.views.widgets.containers import create_wrapped_label, fill_layout
from cpm_app.views.widgets.fields import DecimalField
from cpm_core import CONTOUR_METHODS
from cpm_core.methods import MethodComparison, Settings


class ParameterChoice(QWidget):
    """Two parameters with some values each; the second one is optional."""

    def __init__(self, session: Session) -> None:
        super().__init__()
        self._session = session
        offered = tuple(control for control in build_controls() if control.name in find_effective_controls("shape"))
        self.down, self.across = AxisRow(tr("Parameter"), offered), AxisRow(tr("Second parameter"), (*offered, None))
        layout = QVBoxLayout(self)
        layout.setAlignment(Qt.AlignmentFlag.AlignTop)
        for row, first in zip((self.down, self.across), FIRST_AXES, strict=True):
            layout.addWidget(row)
            row.choice.currentIndexChanged.connect(lambda _, row=row: self._suggest_values(row))
            row.choice.setCurrentIndex([control.name for control in offered].index(first))
            self._suggest_values(row)

    def build_trials(self) -> tuple[Trial, ...]:
        """Return the runs to compare; raise ValueError for invalid values."""
        axes = [axis for axis in (self.down.read_axis(), self.across.read_axis()) if axis is not None]
        return plan_parameter_trials(self._session.document.parameters, axes)

    def _suggest_values(self, row: AxisRow) -> None:
        """Suggest values around the current one."""
        document, control = self._session.document, row.selected_control
        contrast = document.image.contrast if document.image else 255.0
        values = () if control is None else propose_values(control, document.parameters, contrast)
        row.values.setText(", ".join(map(format_short_number, values)))
        row.values.setEnabled(control is not None)


class AxisRow(QWidget):
    """A parameter, or none, and a line for its values."""

    def __init__(self, title: str, offered: Iterable[Control | None]) -> None:
        super().__init__()
        self.choice, self.values = QComboBox(), QLineEdit()
        for control in offered:
            self.choice.addItem(tr("None") if control is None else f"{control.title}  {control.symbol}", control)
        self.choice.setAccessibleName(title)
        self.values.setAccessibleName(tr("Values"))
        self.values.setToolTip(tr("Values of the parameter, separated by commas."))
        fill_layout(QVBoxLayout(self), QLabel(title), self.choice, self.values)

    @property
    def selected_control(self) -> Control | None:
        """Selected parameter, if any."""
        chosen: Control | None = self.choice.currentData()
        return chosen

    def read_axis(self) -> TrialAxis | None:
        """Return the selected parameter with its values; raise ValueError for invalid values."""
        return (
            None
            if self.selected_control is None
            else TrialAxis(self.selected_control, parse_values(self.selected_control, self.values.text()))
        )


class MethodChoice(QWidget):
    """Methods with a check box each, and the idea, source and settings of the current one.

    Methods and settings are part of the document: they are saved with it, and changing them can be undone.
    """

    def __init__(self, session: Session) -> None:
        super().__init__()
        self._session = session
        self.list, self.about, self.around = (
            QListWidget(),
            create_wrapped_label(),
            QCheckBox(tr("The start lies around the object")),
        )
        self.fields: dict[str, QDoubleSpinBox] = {}
        self._shown: tuple[str, Settings] | None = None
        for name, method in CONTOUR_METHODS.items():
            item = QListWidgetItem(translate_core_text(method.title))
            item.setData(Qt.ItemDataRole.UserRole, name)
            item.setToolTip(translate_core_text(method.about))
            self.list.addItem(item)
        self.list.setAccessibleName(tr("Compare methods"))
        self.list.setFixedHeight(self.list.sizeHintForRow(0) * self.list.count() + 6)
        self.around.setToolTip(tr("Balloons and pressures then drive contours inwards."))
        self.about.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._area = QScrollArea(widgetResizable=True)
        layout = QVBoxLayout(self)
        note = create_wrapped_label(
            tr("They start from circles, ellipses and polygons; only particles respond to other shapes."), dim=True
        )
        for widget in (self.list, self.around, note, self.about):
            layout.addWidget(widget)
        layout.addWidget(self._area, 1)
        self.list.itemChanged.connect(self._on_item_changed)
        self.list.currentRowChanged.connect(self._show_current_method)
        self.around.toggled.connect(lambda on: self._edit_comparison(lambda compared: replace(compared, around=on)))
        session.document_changed.connect(self._on_document_changed)
        self._on_document_changed()
        self.list.setCurrentRow(0)

    @property
    def current_method(self) -> str:
        """Name of the method whose settings are shown."""
        return str(self.list.currentItem().data(Qt.ItemDataRole.UserRole))

    def build_trials(self) -> tuple[Trial, ...]:
        """Return the runs to compare; raise ValueError if no method is selected."""
        document = self._session.document
        return plan_method_trials(document.comparison, document.parameters)

    def _edit_comparison(self, change: Callable[[MethodComparison], MethodComparison], gesture: str = "") -> None:
        self._session.edit(
            tr("compare methods"), lambda document: replace(document, comparison=change(document.comparison)), gesture
        )

    def _on_item_changed(self) -> None:
        items = map(self.list.item, range(self.list.count()))
        chosen = tuple(item.data(Qt.ItemDataRole.UserRole) for item in items
                       if item.checkState() == Qt.CheckState.Checked)  # fmt: skip
        self._edit_comparison(lambda compared: replace(compared, methods=chosen))

    def _on_document_changed(self) -> None:
        compared = self._session.document.comparison
        with QSignalBlocker(self.around), QSignalBlocker(self.list):
            self.around.setChecked(compared.around)
            for row, name in enumerate(CONTOUR_METHODS):
                on = Qt.CheckState.Checked if name in compared.methods else Qt.CheckState.Unchecked
                self.list.item(row).setCheckState(on)
        if self.list.currentItem() is not None:
            self._show_current_method()

    def _show_current_method(self) -> None:
        name = self.current_method
        method, settings = CONTOUR_METHODS[name], self._session.document.comparison.settings_of(name)
        if self._shown == (name, settings):
            return
        self._shown = name, settings
        self.about.setText(f"{translate_core_text(method.about)}\n{method.reference}")
        body, self.fields = QWidget(), {}
        form = QFormLayout(body, rowWrapPolicy=QFormLayout.RowWrapPolicy.WrapAllRows)
        if method.of_particles:
            form.addRow(
                create_wrapped_label(tr("These are the parameters of the window: change them there and run again."))
            )
        else:
            for field_name, info in settings.describe_parameters().items():
                decimals = max(0, -math.floor(math.log10(info.step)))
                unit = f" {info.unit}" if info.unit else ""
                field = self.fields[field_name] = DecimalField(info.low, info.high, info.step, decimals, unit)
                field.setValue(getattr(settings, field_name))
                field.setToolTip(f"{translate_core_text(info.meaning)} {translate_core_text(info.effect_of_larger)}")
                field.setAccessibleName(translate_core_text(info.title))
                field.valueChanged.connect(partial(self._on_setting_changed, field_name))
                form.addRow(f"{translate_core_text(info.title)}  {info.symbol}", field)
        self._area.setWidget(body)

    def _on_setting_changed(self, field_name: str, value: float) -> None:
        name = self.current_method
        before = self._session.document.comparison.settings_of(name)
        whole = isinstance(getattr(type(before), field_name), int)
        settings = replace(before, **{field_name: int(value) if whole else value})
        self._shown = name, settings  # so that the field with the keyboard focus is not replaced
        self._edit_comparison(lambda compared: compared.with_settings(name, settings), f"settings of {name}")
