"""Fields for preferences: each shows the value in use and stores another one at once."""

from __future__ import annotations

from abc import abstractmethod
from functools import singledispatch
from typing import Generic, TypeVar

from PySide6.QtCore import QObject, Qt
from PySide6.QtWidgets import (
    QCheckBox,
    QColorDialog,
    QComboBox,
    QHBoxLayout,
    QLineEdit,
    QPushButton,
    QWidget,
)

from app.model.preferences.preference import Choice, Color, Flag, Folder, Number, Preference
from app.model.text.language import tr
from app.session.storage.preferences import Preferences
from app.views.theme.icons import swatch
from app.views.widgets.fields.decimal_field import DecimalField
from app.views.window.file_dialogs import ask_for_folder

V = TypeVar("V")

_FOLDER_WIDTH, _COLOR_WIDTH = 220, 110
"""Least widths [px]."""


class Field(QObject, Generic[V]):
    """Joins a preference to a widget, which owns it."""

    def __init__(self, preference: Preference[V], preferences: Preferences, widget: QWidget) -> None:
        super().__init__(widget)
        self.preference = preference
        self.widget = widget
        self._preferences = preferences
        widget.setAccessibleName(preference.label)
        widget.setAccessibleDescription(preference.note)
        preferences.changed.connect(self._follow)
        self.show_value(preferences.value(preference))
        self._enable()

    @abstractmethod
    def show_value(self, value: V) -> None:
        """Show a value."""

    def store(self, value: V) -> None:
        """Store what the user has chosen."""
        self._preferences.choose(self.preference, value)

    def reset(self) -> None:
        """Go back to the default."""
        self.store(self.preference.default)

    def _follow(self, key: str) -> None:
        if key == self.preference.name:
            self.show_value(self._preferences.value(self.preference))
        elif self.preference.needs is not None and key == self.preference.needs[0].name:
            self._enable()

    def _enable(self) -> None:
        if self.preference.needs is not None:
            other, value = self.preference.needs
            self.widget.setEnabled(self._preferences.value(other) == value)


class FlagField(Field[bool]):
    """A check box."""

    def __init__(self, flag: Flag, preferences: Preferences) -> None:
        self.box = QCheckBox(flag.text)
        super().__init__(flag, preferences, self.box)
        self.box.toggled.connect(self.store)

    def show_value(self, value: bool) -> None:
        """Check or clear the box."""
        self.box.setChecked(value)


class NumberField(Field[float]):
    """A spin box."""

    def __init__(self, number: Number, preferences: Preferences) -> None:
        self.box = DecimalField()
        self.box.setDecimals(number.decimals)
        self.box.setRange(number.low, number.high)
        self.box.setSingleStep(number.step)
        self.box.setSuffix(number.suffix)
        # Each digit of a number that is typed would be stored on its own, and "1" of "16" is out of limits.
        self.box.setKeyboardTracking(False)
        super().__init__(number, preferences, self.box)
        self.box.valueChanged.connect(self.store)

    def show_value(self, value: float) -> None:
        """Show the number."""
        self.box.setValue(value)


class ChoiceField(Field[str]):
    """A combo box."""

    def __init__(self, choice: Choice, preferences: Preferences) -> None:
        self.box = QComboBox()
        self.box.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        for name, title in choice.ways.items():
            self.box.addItem(title, name)
        super().__init__(choice, preferences, self.box)
        self.box.activated.connect(lambda index: self.store(self.box.itemData(index)))

    def show_value(self, value: str) -> None:
        """Show the alternative."""
        self.box.setCurrentIndex(self.box.findData(value))


class ColorField(Field[str]):
    """A button with the color, which opens a dialog of colors."""

    def __init__(self, color: Color, preferences: Preferences) -> None:
        self.button = QPushButton()
        self.button.setMinimumWidth(_COLOR_WIDTH)
        self.button.setAutoDefault(False)
        super().__init__(color, preferences, self.button)
        self.button.setToolTip(tr("Choose another color…"))
        self.button.clicked.connect(self._ask)

    def show_value(self, value: str) -> None:
        """Show the color and its digits."""
        self.button.setIcon(swatch(value))
        self.button.setText(value)

    def _ask(self) -> None:
        chosen = QColorDialog.getColor(self._preferences.value(self.preference), self.button, self.preference.label)
        if chosen.isValid():
            self.store(chosen.name())


class FolderField(Field[str]):
    """The path of a folder, and a button that asks for another one."""

    def __init__(self, folder: Folder, preferences: Preferences) -> None:
        both = QWidget()
        self.path = QLineEdit()
        self.path.setReadOnly(True)
        self.path.setMinimumWidth(_FOLDER_WIDTH)
        self.path.setPlaceholderText(tr("None chosen yet"))
        self.path.setAccessibleName(folder.label)
        self.button = QPushButton(tr("Choose…"))
        self.button.setAutoDefault(False)
        both.setFocusProxy(self.button)
        row = QHBoxLayout(both)
        row.setContentsMargins(0, 0, 0, 0)
        row.addWidget(self.path, 1)
        row.addWidget(self.button)
        super().__init__(folder, preferences, both)
        self.button.clicked.connect(self._ask)

    def show_value(self, value: str) -> None:
        """Show the path."""
        self.path.setText(value)
        self.path.setToolTip(value)

    def _ask(self) -> None:
        chosen = ask_for_folder(self.button, self.preference.label, self._preferences.value(self.preference))
        if chosen:
            self.store(chosen)


@singledispatch
def field_for(preference: object, preferences: Preferences) -> Field[str] | Field[bool] | Field[float]:
    """A new field for a preference."""
    raise TypeError(f"{type(preference).__name__} has no field.")


field_for.register(Flag, FlagField)
field_for.register(Number, NumberField)
field_for.register(Choice, ChoiceField)
field_for.register(Color, ColorField)
field_for.register(Folder, FolderField)
