"""The form for the options of a layer."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QCheckBox, QComboBox, QFormLayout, QHBoxLayout, QLabel, QSizePolicy, QWidget

from app.model.text.numbers import written
from app.views.canvas.layers.layer import Layer
from app.views.canvas.layers.options import Amount, Choice, Option
from app.views.theme import color_maps
from app.views.widgets.fields import MarkedSlider


class LayerForm(QWidget):
    """A row for each option of a layer; it also follows changes that are made elsewhere."""

    def __init__(self, layer: Layer) -> None:
        super().__init__()
        self.layer = layer
        self.fields: dict[str, QWidget] = {}
        self._showing: list[Callable[[], None]] = []
        self.rows = QFormLayout(self)
        self.rows.setContentsMargins(0, 0, 0, 0)
        self.rows.setHorizontalSpacing(8)
        self.rows.setVerticalSpacing(4)
        self.rows.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        for option in layer.options:
            self._add(option)
        layer.changed.connect(self.show_chosen)
        self.show_chosen()

    def show_chosen(self) -> None:
        """Show the values of the options."""
        for show in self._showing:
            show()
        for name, field in self.fields.items():
            field.setEnabled(self.layer.acts(name))

    def _add(self, option: Option) -> None:
        if isinstance(option, Choice):
            field: QWidget = self._choice(option)
        elif isinstance(option, Amount):
            field = self._amount(option)
        else:
            field = self._switch(option.name, option.title)
        self.fields[option.name] = field
        field.setToolTip(option.tip)
        field.setAccessibleName(option.title)
        if isinstance(field, QCheckBox):
            self.rows.addRow(field)
            return
        label = QLabel(option.title)
        label.setObjectName("dim")
        label.setToolTip(option.tip)
        self.rows.addRow(label, field)

    def _choice(self, option: Choice) -> QComboBox:
        box = QComboBox()
        box.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        box.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        box.setIconSize(QSize(36, 12))
        for name, title in option.ways.items():
            if name in color_maps.MAPS:
                box.addItem(color_maps.icon(name), title, name)
            else:
                box.addItem(title, name)

        def show() -> None:
            box.setCurrentIndex(box.findData(self.layer.chosen[option.name]))

        self._showing.append(show)
        box.activated.connect(lambda index: self.layer.choose(option.name, box.itemData(index)))
        return box

    def _amount(self, option: Amount) -> QWidget:
        slider = MarkedSlider(option.low, option.high, option.step, option.first)
        figure = QLabel()
        figure.setMinimumWidth(figure.fontMetrics().horizontalAdvance("0.000"))
        figure.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)

        def show() -> None:
            slider.show_value(self.layer.number(option.name))
            figure.setText(written(f"{self.layer.number(option.name):g}"))

        self._showing.append(show)
        slider.moved_to.connect(lambda value: self.layer.choose(option.name, value))
        slider.restored.connect(lambda: self.layer.choose(option.name, option.first))
        both = QWidget()
        both.setFocusProxy(slider)
        row = QHBoxLayout(both)
        row.setContentsMargins(0, 0, 0, 0)
        row.addWidget(slider, 1)
        row.addWidget(figure)
        return both

    def _switch(self, name: str, title: str) -> QCheckBox:
        box = QCheckBox(title)
        box.toggled.connect(lambda checked: self.layer.choose(name, checked))
        self._showing.append(lambda: box.setChecked(bool(self.layer.chosen[name])))
        return box
