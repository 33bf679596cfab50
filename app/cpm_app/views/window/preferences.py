"""The preferences dialog: its pages, the fields of preferences, and the page of the shortcuts."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtGui import QKeySequence
from PySide6.QtWidgets import (
    QCheckBox,
    QColorDialog,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QFrame,
    QHBoxLayout,
    QHeaderView,
    QKeySequenceEdit,
    QLabel,
    QLineEdit,
    QPushButton,
    QScrollArea,
    QSizePolicy,
    QStackedWidget,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from cpm_app.model.preferences.shortcuts import refusal
from cpm_app.model.preferences.table import BY_PAGE, PAGES, Choice, Color, Flag, Number, Preference
from cpm_app.model.text.language import tr
from cpm_app.session.storage.preferences import Preferences
from cpm_app.views.theme.icons import swatch
from cpm_app.views.widgets.actions import native
from cpm_app.views.widgets.containers import Contents, arrange, wrapped
from cpm_app.views.widgets.fields import ChoiceBox, DecimalField
from cpm_app.views.window.shortcuts import Shortcuts
from cpm_core.numerics.types import Callback

_WIDTH, _HEIGHT, _MARGIN = 720, 540, 80
"""Size of the dialog, and space that it leaves free on the screen [px]."""

_COLOR_WIDTH = 110
"""Least widths of fields [px]."""

_NAME = Qt.ItemDataRole.UserRole


class PreferencesDialog(QDialog):
    """A list of pages on the left, the fields of one of them on the right; changes take effect immediately.

    Attributes
    ----------
    rows : dict
        Widgets by their labels.
    """

    def __init__(self, parent: QWidget, preferences: Preferences, shortcuts: Shortcuts) -> None:
        super().__init__(parent)
        self.setWindowTitle(tr("Preferences"))
        self._keys, self._pages = shortcuts, QStackedWidget()
        self.rows: dict[str, QWidget] = {}
        self._preferences = preferences
        self._show: dict[str, Callback] = {}
        self.contents = Contents(tr("Pages of the preferences"), [*PAGES.values()])
        preferences.changed.connect(self._follow)
        self._made = {name: self._make_page(name) for name in BY_PAGE} | {"shortcuts": ShortcutsPage(shortcuts)}
        for name in PAGES:
            self._pages.addWidget(self._made[name])
        self.contents.currentRowChanged.connect(self._pages.setCurrentIndex)
        self.contents.setCurrentRow(0)
        buttons = QDialogButtonBox()
        reset = buttons.addButton(tr("Reset this page"), QDialogButtonBox.ButtonRole.ResetRole)
        reset.setToolTip(tr("Set everything on this page to its default."))
        reset.clicked.connect(self.reset)
        close = buttons.addButton(tr("Close"), QDialogButtonBox.ButtonRole.RejectRole)
        # Enter belongs to the fields, in which it ends a number or a key.
        for button in (reset, close):
            button.setAutoDefault(False)
        buttons.rejected.connect(self.reject)
        middle = arrange(QHBoxLayout(), self.contents, self._pages, wide=self._pages)
        layout = QVBoxLayout(self)
        layout.addLayout(middle, 1)
        layout.addWidget(buttons)
        room = self.screen().availableSize()
        self.resize(min(_WIDTH, room.width() - _MARGIN), min(_HEIGHT, room.height() - _MARGIN))

    def page(self, name: str) -> QWidget:
        """A page by its name."""
        return self._made[name]

    def turn_to(self, page: str) -> None:
        """Show a page by its name."""
        self.contents.setCurrentRow(list(PAGES).index(page))

    def reset(self) -> None:
        """Set everything on the shown page to its default."""
        page = list(PAGES)[self.contents.currentRow()]
        for preference in BY_PAGE.get(page, ()):
            self._preferences.choose(preference, preference.default)
        if page == "shortcuts":
            self._keys.reset()

    def _make_page(self, name: str) -> QScrollArea:
        """A page, with a row for each of its preferences."""
        page, content = QScrollArea(widgetResizable=True), QWidget()
        content.setObjectName("scrolled")
        rows = QFormLayout(
            content,
            fieldGrowthPolicy=QFormLayout.FieldGrowthPolicy.ExpandingFieldsGrow,
            labelAlignment=Qt.AlignmentFlag.AlignLeft,
            horizontalSpacing=16,
            verticalSpacing=8,
        )
        page.setWidget(content)
        page.setFrameShape(QFrame.Shape.NoFrame)
        for preference in BY_PAGE[name]:
            self._add_row(rows, preference)
        return page

    def _add_row(self, rows: QFormLayout, preference: Preference[Any]) -> None:
        """Add a field, with a sentence below it."""
        widget, show = field_for(preference, self._preferences)
        self._show[preference.name] = lambda: show(self._preferences.value(preference))
        self.rows[preference.label] = widget
        widget.setAccessibleName(preference.label)
        widget.setAccessibleDescription(preference.note)
        rows.addRow(preference.label, widget)
        if preference.note:
            note = wrapped(preference.note, dim=True)
            note.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Minimum)
            rows.addRow("", note)

    def _follow(self, key: str) -> None:
        """Show a value that has changed."""
        if key in self._show:
            self._show[key]()


def field_for(preference: Preference[Any], preferences: Preferences) -> tuple[QWidget, Callable[[Any], object]]:
    """A widget that shows the value in use and stores another one immediately, and what shows a value in it."""
    value, store = preferences.value(preference), partial(preferences.choose, preference)
    match preference:
        case Flag():
            check = QCheckBox(preference.text)
            check.setChecked(value)
            check.toggled.connect(store)
            return check, check.setChecked
        case Number():
            limits = preference.low, preference.high, preference.step
            number = DecimalField(*limits, preference.decimals, preference.suffix)
            number.setValue(value)
            number.valueChanged.connect(store)
            return number, number.setValue
        case Choice():
            choice = ChoiceBox(preference.ways)
            choice.show_value(value)
            choice.chosen.connect(store)
            return choice, choice.show_value
        case Color():
            button = QPushButton(autoDefault=False)
            button.setMinimumWidth(_COLOR_WIDTH)
            button.setToolTip(tr("Choose another color…"))

            def show(shown: str) -> None:
                button.setIcon(swatch(shown))
                button.setText(shown)

            def ask() -> None:
                chosen = QColorDialog.getColor(preferences.value(preference), button, preference.label)
                if chosen.isValid():
                    store(chosen.name())

            show(value)
            button.clicked.connect(ask)
            return button, show
    raise TypeError(f"{type(preference).__name__} has no field.")


class ShortcutsPage(QWidget):
    """All actions with a search field above them, and below them the field in which new keys are pressed."""

    def __init__(self, shortcuts: Shortcuts) -> None:
        super().__init__()
        self._shortcuts = shortcuts
        self._wanted = ""
        self.search = QLineEdit(placeholderText=tr("Search actions and keys"), clearButtonEnabled=True)
        self.search.setAccessibleName(tr("Search actions and keys"))
        self.search.textChanged.connect(self._show_keys)
        self.list = QTreeWidget()
        self.list.setHeaderLabels([tr("Action"), tr("Keys")])
        self.list.setAccessibleName(tr("Actions and their keys"))
        self.list.header().setStretchLastSection(False)
        self.list.header().setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        self.list.header().setSectionResizeMode(1, QHeaderView.ResizeMode.ResizeToContents)
        self.list.setUniformRowHeights(True)
        self._groups: dict[str, QTreeWidgetItem] = {}
        self._items: dict[str, QTreeWidgetItem] = {}
        self._fill()
        self.list.currentItemChanged.connect(lambda *_: self._show_current())
        self.keys = QKeySequenceEdit(maximumSequenceLength=1)
        self.keys.setAccessibleName(tr("Press the new key"))
        self.keys.keySequenceChanged.connect(lambda _: self._take())
        self.message = wrapped(dim=True)
        self.take_over, self.remove = QPushButton(tr("Use it here")), QPushButton(tr("Remove"))
        self.restore = QPushButton(tr("Reset"))
        self.take_over.setToolTip(tr("Remove the key from the other action."))
        self.remove.setToolTip(tr("Remove the key of this action."))
        self.restore.setToolTip(tr("Restore the default key of this action."))
        self.take_over.clicked.connect(lambda: self._choose(self._wanted))
        self.remove.clicked.connect(lambda: self._choose(""))
        self.restore.clicked.connect(lambda: shortcuts.restore(self._current))
        buttons = self.take_over, self.remove, self.restore
        for button in buttons:
            button.setAutoDefault(False)
        row = arrange(QHBoxLayout(), QLabel(tr("New key:")), self.keys, *buttons, wide=self.keys)
        arrange(QVBoxLayout(self), self.search, self.list, row, self.message, wide=self.list)
        shortcuts.changed.connect(self._show_keys)
        self._show_keys()

    def choose(self, name: str) -> None:
        """Choose an action by its name in code."""
        self.list.setCurrentItem(self._items[name])

    def _fill(self) -> None:
        for action in self._shortcuts.actions:
            if action.group not in self._groups:
                self._groups[action.group] = group = QTreeWidgetItem(self.list, [action.group])
                group.setFlags(Qt.ItemFlag.ItemIsEnabled)
                group.setFirstColumnSpanned(True)
                group.setExpanded(True)
            self._items[action.name] = item = QTreeWidgetItem(self._groups[action.group], [action.title])
            item.setData(0, _NAME, action.name)

    @property
    def _current(self) -> str:
        item = self.list.currentItem()
        return (item.data(0, _NAME) or "") if item is not None else ""

    def _show_keys(self) -> None:
        """Show the keys as they are now, of the actions that are searched for."""
        wanted = self.search.text().casefold()
        for name, item in self._items.items():
            item.setText(1, ", ".join(map(native, self._shortcuts.keys(name))))
            item.setHidden(wanted not in f"{item.text(0)} {item.text(1)}".casefold())
        for group in self._groups.values():
            group.setHidden(all(item.isHidden() for item in self._items.values() if item.parent() is group))
        self._show_current()

    def _show_current(self) -> None:
        name = self._current
        with QSignalBlocker(self.keys):
            keys = self._shortcuts.keys(name) if name else ()
            self.keys.setKeySequence(QKeySequence(keys[0] if keys else ""))
        for widget in (self.keys, self.remove, self.restore):
            widget.setEnabled(bool(name))
        self._say(tr("Choose the field and press the new key.") if name else tr("Select an action to change its key."))

    def _say(self, text: str, wanted: str = "") -> None:
        self._wanted = wanted
        self.message.setText(text)
        self.take_over.setVisible(bool(wanted))

    def _take(self) -> None:
        """Use what has been pressed, or report why it cannot be used."""
        key, name = self.keys.keySequence().toString(QKeySequence.SequenceFormat.PortableText), self._current
        if not name or not key:
            return
        other, refused = self._shortcuts.holder(key, name), refusal(key)
        if refused:
            self._say(refused)
        elif other is not None:
            self._say(tr("{key} belongs to “{action}”.", key=native(key), action=other.title), key)
        else:
            self._choose(key)

    def _choose(self, key: str) -> None:
        if self._current:
            self._shortcuts.choose(self._current, key)
            self._show_current()
