"""The preferences dialog: its pages, the fields of preferences, and the page of the shortcuts."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Mapping
from functools import singledispatch
from typing import Generic, TypeVar

from PySide6.QtCore import QModelIndex, QObject, QSignalBlocker, Qt
from PySide6.QtGui import QKeySequence
from PySide6.QtWidgets import (
    QCheckBox,
    QColorDialog,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QFrame,
    QHBoxLayout,
    QHeaderView,
    QKeySequenceEdit,
    QLabel,
    QLineEdit,
    QListWidget,
    QPushButton,
    QScrollArea,
    QSizePolicy,
    QStackedWidget,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from app.model.preferences.shortcuts import refusal
from app.model.preferences.table import PAGES, PREFERENCES, Choice, Color, Flag, Folder, Number, Preference
from app.model.text.language import tr
from app.session.storage.preferences import Preferences
from app.views.theme.icons import swatch
from app.views.widgets.fields.decimal_field import DecimalField
from app.views.widgets.key_text import native, natives
from app.views.widgets.preference_row import PreferenceRow
from app.views.window.dialogs import ask_for_folder
from app.views.window.shortcuts import Shortcuts

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


_NAME = Qt.ItemDataRole.UserRole


class ShortcutsPage(QWidget):
    """A list with a search field above it, and below it the field in which new keys are pressed."""

    def __init__(self, shortcuts: Shortcuts) -> None:
        super().__init__()
        self._shortcuts = shortcuts
        self._wanted = ""
        self.search = QLineEdit()
        self.search.setPlaceholderText(tr("Search actions and keys"))
        self.search.setAccessibleName(tr("Search actions and keys"))
        self.search.setClearButtonEnabled(True)
        self.search.textChanged.connect(self._filter)
        self.list = QTreeWidget()
        self.list.setHeaderLabels([tr("Action"), tr("Keys")])
        self.list.setAccessibleName(tr("Actions and their keys"))
        self.list.header().setStretchLastSection(False)
        self.list.header().setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        self.list.header().setSectionResizeMode(1, QHeaderView.ResizeMode.ResizeToContents)
        self.list.setUniformRowHeights(True)
        self._groups: dict[str, QTreeWidgetItem] = {}
        self._items = self._fill()
        self.list.currentItemChanged.connect(lambda *_: self._show_current())
        self.keys = QKeySequenceEdit()
        self.keys.setMaximumSequenceLength(1)
        self.keys.setAccessibleName(tr("Press the new key"))
        self.keys.keySequenceChanged.connect(lambda _: self._take())
        self.message = QLabel()
        self.message.setObjectName("dim")
        self.message.setWordWrap(True)
        self.take_over = self._button(
            tr("Use it here"), tr("Take the key away from the other action."), self._take_over
        )
        self.remove = self._button(tr("Remove"), tr("Leave the action without a key."), lambda: self._choose(""))
        self.restore = self._button(tr("Reset"), tr("Go back to the default key of this action."), self._restore)
        self._lay_out()
        shortcuts.changed.connect(self._show_keys)
        self._show_keys()
        self._show_current()

    def choose(self, name: str) -> None:
        """Choose an action by its name in code."""
        self.list.setCurrentItem(self._items[name])

    def reset(self) -> None:
        """Give all actions their default keys."""
        self._shortcuts.reset()

    def _button(self, text: str, tip: str, do: object) -> QPushButton:
        button = QPushButton(text)
        button.setToolTip(tip)
        button.setAutoDefault(False)
        button.clicked.connect(do)
        return button

    def _lay_out(self) -> None:
        row = QHBoxLayout()
        row.addWidget(QLabel(tr("New key:")))
        row.addWidget(self.keys, 1)
        for button in (self.take_over, self.remove, self.restore):
            row.addWidget(button)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.search)
        column.addWidget(self.list, 1)
        column.addLayout(row)
        column.addWidget(self.message)

    def _fill(self) -> dict[str, QTreeWidgetItem]:
        groups = self._groups
        items: dict[str, QTreeWidgetItem] = {}
        for action in self._shortcuts.actions:
            if action.group not in groups:
                groups[action.group] = group = QTreeWidgetItem(self.list, [action.group])
                group.setFlags(Qt.ItemFlag.ItemIsEnabled)
                self.list.setFirstColumnSpanned(self.list.indexOfTopLevelItem(group), QModelIndex(), True)
                group.setExpanded(True)
            items[action.name] = item = QTreeWidgetItem(groups[action.group], [action.title])
            item.setData(0, _NAME, action.name)
        return items

    @property
    def _current(self) -> str:
        item = self.list.currentItem()
        return (item.data(0, _NAME) or "") if item is not None else ""

    def _show_keys(self) -> None:
        for name, item in self._items.items():
            item.setText(1, natives(self._shortcuts.keys(name)))
        self._filter()
        self._show_current()

    def _show_current(self) -> None:
        name = self._current
        with QSignalBlocker(self.keys):
            self.keys.setKeySequence(
                QKeySequence(next(iter(self._shortcuts.keys(name)), "")) if name else QKeySequence()
            )
        for widget in (self.keys, self.remove, self.restore):
            widget.setEnabled(bool(name))
        self._say(tr("Choose the field and press the new key.") if name else tr("Select an action to change its key."))

    def _say(self, text: str, wanted: str = "") -> None:
        self._wanted = wanted
        self.message.setText(text)
        self.take_over.setVisible(bool(wanted))

    def _take(self) -> None:
        """Use what has been pressed, or tell why it cannot be used."""
        key, name = self.keys.keySequence().toString(QKeySequence.SequenceFormat.PortableText), self._current
        if not name or not key:
            return
        other, refused = self._shortcuts.holder(key, name), refusal(key)
        if refused:
            self._say(refused)
        elif other is not None:
            self._say(tr("{key} belongs to “{action}”.").format(key=native(key), action=other.title), key)
        else:
            self._choose(key)

    def _take_over(self) -> None:
        self._choose(self._wanted)

    def _choose(self, key: str) -> None:
        if self._current:
            self._shortcuts.choose(self._current, key)
            self._show_current()

    def _restore(self) -> None:
        self._shortcuts.restore(self._current)

    def _filter(self) -> None:
        wanted = self.search.text().casefold()
        for item in self._items.values():
            item.setHidden(wanted not in f"{item.text(0)} {item.text(1)}".casefold())
        for group in self._groups.values():
            group.setHidden(all(item.isHidden() for item in self._items.values() if item.parent() is group))


_WIDTH, _HEIGHT, _MARGIN = 720, 540, 80
"""Size of the dialog, and space that it leaves free on the screen [px]."""


class PreferencesDialog(QDialog):
    """Changes take effect at once.

    Attributes
    ----------
    rows : dict
        Widgets by their labels.
    """

    def __init__(
        self, parent: QWidget, preferences: Preferences, rows: Iterable[PreferenceRow], shortcuts: ShortcutsPage
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle(tr("Preferences"))
        self.rows: dict[str, QWidget] = {}
        self.shortcuts = shortcuts
        self._fields: dict[str, list[Field[bool] | Field[float] | Field[str]]] = {name: [] for name in PAGES}
        self.contents = QListWidget()
        self.contents.setObjectName("contents")
        self.contents.setAccessibleName(tr("Pages of the preferences"))
        self.contents.addItems(list(PAGES.values()))
        self.contents.setFixedWidth(self.contents.sizeHintForColumn(0) + 40)
        self._pages = QStackedWidget()
        forms = {name: _Form() for name in PAGES}
        self._fill(preferences, forms, rows)
        for name, form in forms.items():
            self._pages.addWidget(shortcuts if name == "shortcuts" else form)
        self.contents.currentRowChanged.connect(self._pages.setCurrentIndex)
        self.contents.setCurrentRow(0)
        self._lay_out()
        room = self.screen().availableSize()
        self.resize(min(_WIDTH, room.width() - _MARGIN), min(_HEIGHT, room.height() - _MARGIN))

    def turn_to(self, page: str) -> None:
        """Show a page by its name."""
        self.contents.setCurrentRow(list(PAGES).index(page))

    def reset(self) -> None:
        """Set everything on the shown page to its default."""
        page = list(PAGES)[self.contents.currentRow()]
        for field in self._fields[page]:
            field.reset()
        if page == "shortcuts":
            self.shortcuts.reset()

    def _fill(self, preferences: Preferences, forms: Mapping[str, _Form], rows: Iterable[PreferenceRow]) -> None:
        for preference in PREFERENCES:
            field = field_for(preference, preferences)
            self._fields[preference.page].append(field)
            forms[preference.page].add(preference.label, field.widget, preference.note)
            self.rows[preference.label] = field.widget
        for row in rows:
            self.rows[row.label] = row.make()
            forms[row.page].add(row.label, self.rows[row.label], row.note)

    def _lay_out(self) -> None:
        self._reset = QPushButton(tr("Reset this page"))
        self._reset.setToolTip(tr("Set everything on this page to its default."))
        self._reset.clicked.connect(self.reset)
        buttons = QDialogButtonBox()
        buttons.addButton(self._reset, QDialogButtonBox.ButtonRole.ResetRole)
        close = buttons.addButton(tr("Close"), QDialogButtonBox.ButtonRole.RejectRole)
        # Enter belongs to the fields, in which it ends a number or a key.
        for button in (self._reset, close):
            button.setAutoDefault(False)
        buttons.rejected.connect(self.reject)
        middle = QHBoxLayout()
        middle.addWidget(self.contents)
        middle.addWidget(self._pages, 1)
        layout = QVBoxLayout(self)
        layout.addLayout(middle, 1)
        layout.addWidget(buttons)


class _Form(QScrollArea):
    """Rows of one page."""

    def __init__(self) -> None:
        super().__init__()
        content = QWidget()
        content.setObjectName("scrolled")
        self._rows = QFormLayout(content)
        self._rows.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.ExpandingFieldsGrow)
        self._rows.setLabelAlignment(Qt.AlignmentFlag.AlignLeft)
        self._rows.setHorizontalSpacing(16)
        self._rows.setVerticalSpacing(8)
        self.setWidget(content)
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)

    def add(self, label: str, widget: QWidget, text: str) -> None:
        """Add a row, with a sentence below it."""
        self._rows.addRow(label, widget)
        if text:
            note = QLabel(text)
            note.setObjectName("dim")
            note.setWordWrap(True)
            note.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Minimum)
            self._rows.addRow("", note)
