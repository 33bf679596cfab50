"""What is compared: values of one or two parameters, or methods with their settings."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial

from PySide6.QtCore import Qt
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

from app.model.display.comparison import (
    COUNTS,
    FIRST_AXES,
    Axis,
    Tile,
    in_text,
    method_tiles,
    parameter_tiles,
    read_values,
    sensible_values,
)
from app.model.document.modes import acting_in
from app.model.parameters.controls import Control, controls
from app.model.text.language import from_core, tr
from app.session.session import Session
from app.views.widgets.fields.decimal_field import DecimalField
from cpm_core.objects.methods import CONTOUR_METHODS, Compared, Settings
from cpm_core.parameters import Parameters


class ParameterChoice(QWidget):
    """Two parameters with some values each, of which the second may be left out."""

    def __init__(self, session: Session) -> None:
        super().__init__()
        self._session = session
        offered = tuple(control for control in controls() if control.name in acting_in("shape"))
        self.down = AxisRow(tr("Rows"), offered, FIRST_AXES[0])
        self.across = AxisRow(tr("Columns"), offered, FIRST_AXES[1], may_lack=True)
        self.count = QComboBox()
        for number in COUNTS:
            self.count.addItem(tr("{count} values each").format(count=number), number)
        self.count.setAccessibleName(tr("Number of values"))
        layout = QVBoxLayout(self)
        layout.setAlignment(Qt.AlignmentFlag.AlignTop)
        for widget in (self.down, self.across, self.count):
            layout.addWidget(widget)
        self.count.currentIndexChanged.connect(self._suggest)
        for row in (self.down, self.across):
            row.choice.currentIndexChanged.connect(lambda _, row=row: self._suggest_for(row))
        self._suggest()

    def tiles(self) -> tuple[Tile, ...]:
        """The runs; ValueError where values are not valid."""
        axes = [axis for axis in (self.down.axis(), self.across.axis()) if axis is not None]
        return parameter_tiles(self._session.document.parameters, axes)

    def _suggest(self) -> None:
        for row in (self.down, self.across):
            self._suggest_for(row)

    def _suggest_for(self, row: AxisRow) -> None:
        document = self._session.document
        contrast = document.image.contrast if document.image else 255.0
        row.suggest(document.parameters, contrast, self.count.currentData())


class AxisRow(QWidget):
    """A choice among all parameters (`first` is the name of the initial one), and a line for its values."""

    def __init__(self, title: str, controls: tuple[Control, ...], first: str, may_lack: bool = False) -> None:
        super().__init__()
        self.choice = QComboBox()
        for control in controls:
            self.choice.addItem(f"{control.title}  {control.symbol}", control)
            if control.name == first:
                self.choice.setCurrentIndex(self.choice.count() - 1)
        if may_lack:
            self.choice.addItem(tr("None"), None)
        self.choice.setAccessibleName(title)
        self._suggested: tuple[float, ...] = ()
        self.values = QLineEdit()
        self.values.setAccessibleName(tr("Values"))
        self.values.setToolTip(tr("Values of the parameter, separated by commas."))
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        for widget in (QLabel(title), self.choice, self.values):
            layout.addWidget(widget)

    @property
    def control(self) -> Control | None:
        """The chosen parameter, if any."""
        chosen: Control | None = self.choice.currentData()
        return chosen

    def suggest(self, parameters: Parameters, contrast: float, count: int) -> None:
        """Suggest values around the present one."""
        control = self.control
        self._suggested = () if control is None else sensible_values(control, parameters, contrast, count)
        self.values.setText(in_text(self._suggested))
        self.values.setEnabled(control is not None)

    def axis(self) -> Axis | None:
        """The chosen parameter and values; raises `ValueError` if the values are not valid."""
        if self.control is None:
            return None
        if len(self._suggested) > 1 and self.values.text() == in_text(self._suggested):  # the text has fewer digits
            return Axis(self.control, self._suggested)
        return Axis(self.control, read_values(self.control, self.values.text()))


class MethodChoice(QWidget):
    """The methods with a check each; of the marked one its idea, its source, and its settings.

    Methods and settings are part of the document: they are saved with it, and changing them can be undone.
    """

    def __init__(self, session: Session) -> None:
        super().__init__()
        self._session = session
        self.list, self.about, self.around = QListWidget(), QLabel(), QCheckBox(tr("The start lies around the object"))
        self.fields: dict[str, QDoubleSpinBox] = {}
        self._shown: tuple[str, Settings] | None = None
        for name, method in CONTOUR_METHODS.items():
            item = QListWidgetItem(from_core(method.title))
            item.setData(Qt.ItemDataRole.UserRole, name)
            item.setToolTip(from_core(method.missing) or from_core(method.about))
            self.list.addItem(item)
        self.list.setAccessibleName(tr("Compare methods"))
        self.list.setMaximumHeight(self.list.sizeHintForRow(0) * (self.list.count() + 1))
        self.around.setToolTip(tr("Balloons and pressures then drive contours inwards."))
        self.about.setWordWrap(True)
        self.about.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._area = QScrollArea()
        self._area.setWidgetResizable(True)
        layout = QVBoxLayout(self)
        for widget in (self.list, self.around, self.about):
            layout.addWidget(widget)
        layout.addWidget(self._area, 1)
        self.list.itemChanged.connect(self._choose)
        self.list.currentRowChanged.connect(self._show_marked)
        self.around.toggled.connect(lambda on: self._change(lambda compared: replace(compared, around=on)))
        session.document_changed.connect(self._follow)
        self._follow()
        self.list.setCurrentRow(0)

    @property
    def marked(self) -> str:
        """Name of the method whose settings are shown."""
        return str(self.list.currentItem().data(Qt.ItemDataRole.UserRole))

    def mark(self, method: str) -> None:
        """Show the settings of a method."""
        self.list.setCurrentRow(list(CONTOUR_METHODS).index(method))

    def tiles(self) -> tuple[Tile, ...]:
        """The runs; ValueError where no method is chosen."""
        document = self._session.document
        return method_tiles(document.comparison, document.parameters)

    def _change(self, change: Callable[[Compared], Compared], gesture: str = "") -> None:
        self._session.edit(
            tr("compare methods"), lambda document: replace(document, comparison=change(document.comparison)), gesture
        )

    def _choose(self) -> None:
        items = map(self.list.item, range(self.list.count()))
        chosen = tuple(item.data(Qt.ItemDataRole.UserRole) for item in items
                       if item.checkState() == Qt.CheckState.Checked)  # fmt: skip
        self._change(lambda compared: replace(compared, methods=chosen))

    def _follow(self) -> None:
        compared = self._session.document.comparison
        for widget in (self.list, self.around):
            widget.blockSignals(True)
        self.around.setChecked(compared.around)
        for row, name in enumerate(CONTOUR_METHODS):
            on = Qt.CheckState.Checked if name in compared.methods else Qt.CheckState.Unchecked
            self.list.item(row).setCheckState(on)
        for widget in (self.list, self.around):
            widget.blockSignals(False)
        if self.list.currentItem() is not None:
            self._show_marked()

    def _show_marked(self) -> None:
        name = self.marked
        method, settings = CONTOUR_METHODS[name], self._session.document.comparison.settings_of(name)
        if self._shown == (name, settings):
            return
        self._shown = name, settings
        self.about.setText(f"{from_core(method.about)}\n{method.reference}")
        body, self.fields = QWidget(), {}
        form = QFormLayout(body)
        form.setRowWrapPolicy(QFormLayout.RowWrapPolicy.WrapAllRows)
        if method.of_particles:
            ours = QLabel(tr("These are the parameters of the window: change them there and run again."))
            ours.setWordWrap(True)
            form.addRow(ours)
        else:
            for field_name, info in settings.table().items():
                field = self.fields[field_name] = DecimalField()
                field.setDecimals(max(0, -math.floor(math.log10(info.step))))
                field.setRange(info.low, info.high)
                field.setSingleStep(info.step)
                field.setSuffix(f" {info.unit}" if info.unit else "")
                field.setValue(getattr(settings, field_name))
                field.setKeyboardTracking(False)
                field.setToolTip(f"{from_core(info.meaning)} {from_core(info.more)}")
                field.setAccessibleName(from_core(info.title))
                field.valueChanged.connect(partial(self._set, field_name))
                form.addRow(f"{from_core(info.title)}  {info.symbol}", field)
        self._area.setWidget(body)

    def _set(self, field_name: str, value: float) -> None:
        name = self.marked
        before = self._session.document.comparison.settings_of(name)
        whole = isinstance(getattr(type(before), field_name), int)
        settings = replace(before, **{field_name: int(value) if whole else value})
        self._shown = name, settings  # the field with the keyboard stays
        self._change(lambda compared: compared.with_settings(name, settings), f"settings of {name}")
