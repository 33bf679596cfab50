"""Preferences dialog: its pages, the fields of preferences, and the page of the shortcuts."""

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

from cpm_app.model.preferences.shortcuts import explain_reserved_key
from cpm_app.model.preferences.table import (
    PAGE_TITLES,
    PREFERENCES_BY_PAGE,
    ChoicePreference,
    ColorPreference,
    FlagPreference,
    NumberPreference,
    Preference,
    TextPreference,
)
from cpm_app.model.text.language import tr
from cpm_app.session.storage.preferences import Preferences
from cpm_app.views.theme.icons import create_swatch
from cpm_app.views.widgets.actions import native_key_text
from cpm_app.views.widgets.containers import PageList, create_wrapped_label, fill_layout
from cpm_app.views.widgets.fields import ChoiceBox, DecimalField
from cpm_app.views.window.shortcuts import Shortcuts
from cpm_core.numerics.types import Callback

_DIALOG_WIDTH = 720
"""Preferred width of the dialog [px]."""

_DIALOG_HEIGHT = 540
"""Preferred height of the dialog [px]."""

_FREE_SCREEN_SPACE = 80
"""Space that the dialog leaves free on the screen [px]."""

_MIN_COLOR_BUTTON_WIDTH = 110
"""Smallest width of the button of a color [px]."""

_ACTION_NAME_ROLE = Qt.ItemDataRole.UserRole
"""Role under which a row holds the name of its action."""


class PreferencesDialog(QDialog):
    """Dialog with a list of pages and the fields of the current one; changes take effect immediately.

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
        self._field_updates: dict[str, Callback] = {}
        self.contents = PageList(tr("Pages of the preferences"), [*PAGE_TITLES.values()])
        preferences.changed.connect(self._on_preference_changed)
        for name in PAGE_TITLES:
            self._pages.addWidget(ShortcutsPage(shortcuts) if name == "shortcuts" else self._make_page(name))
        self.contents.currentRowChanged.connect(self._pages.setCurrentIndex)
        self.contents.setCurrentRow(0)
        buttons = QDialogButtonBox()
        reset = buttons.addButton(tr("Reset this page"), QDialogButtonBox.ButtonRole.ResetRole)
        reset.setToolTip(tr("Set everything on this page to its default."))
        reset.clicked.connect(self.reset)
        close = buttons.addButton(tr("Close"), QDialogButtonBox.ButtonRole.RejectRole)
        # Enter belongs to the fields, where it accepts a number or a key.
        for button in (reset, close):
            button.setAutoDefault(False)
        buttons.rejected.connect(self.reject)
        middle = fill_layout(QHBoxLayout(), self.contents, self._pages, wide=self._pages)
        layout = QVBoxLayout(self)
        layout.addLayout(middle, 1)
        layout.addWidget(buttons)
        room = self.screen().availableSize()
        self.resize(
            min(_DIALOG_WIDTH, room.width() - _FREE_SCREEN_SPACE),
            min(_DIALOG_HEIGHT, room.height() - _FREE_SCREEN_SPACE),
        )

    def turn_to(self, page: str) -> None:
        """Show a page by its name."""
        self.contents.setCurrentRow(list(PAGE_TITLES).index(page))

    def reset(self) -> None:
        """Set everything on the shown page to its default."""
        page = list(PAGE_TITLES)[self.contents.currentRow()]
        for preference in PREFERENCES_BY_PAGE.get(page, ()):
            self._preferences.store_preference(preference, preference.default)
        if page == "shortcuts":
            self._keys.reset()

    def _make_page(self, name: str) -> QScrollArea:
        """Create a page with a row for each of its preferences."""
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
        for preference in PREFERENCES_BY_PAGE[name]:
            self._add_row(rows, preference)
        return page

    def _add_row(self, rows: QFormLayout, preference: Preference[Any]) -> None:
        """Add the field of a preference, with its note below."""
        widget, show = create_preference_field(preference, self._preferences)
        self._field_updates[preference.name] = lambda: show(self._preferences.read_preference(preference))
        self.rows[preference.label] = widget
        widget.setAccessibleName(preference.label)
        widget.setAccessibleDescription(preference.note)
        rows.addRow(preference.label, widget)
        if preference.note:
            note = create_wrapped_label(preference.note, dim=True)
            note.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Minimum)
            rows.addRow("", note)

    def _on_preference_changed(self, key: str) -> None:
        """Show a value that has changed."""
        if key in self._field_updates:
            self._field_updates[key]()


def create_preference_field(
    preference: Preference[Any], preferences: Preferences
) -> tuple[QWidget, Callable[[Any], object]]:
    """Create the field of a preference, which stores a new value immediately.

    Returns the widget and the function that shows a value in it.
    """
    value, store = preferences.read_preference(preference), partial(preferences.store_preference, preference)
    match preference:
        case FlagPreference():
            check = QCheckBox(preference.text)
            check.setChecked(value)
            check.toggled.connect(store)
            return check, check.setChecked
        case NumberPreference():
            limits = preference.low, preference.high, preference.step
            number = DecimalField(*limits, preference.decimals, preference.suffix)
            number.setValue(value)
            number.valueChanged.connect(store)
            return number, number.setValue
        case ChoicePreference():
            choice = ChoiceBox(preference.choices)
            choice.show_value(value)
            choice.value_selected.connect(store)
            return choice, choice.show_value
        case TextPreference():
            line = QLineEdit(value)
            line.editingFinished.connect(lambda: store(line.text().strip()))
            return line, line.setText
        case ColorPreference():
            button = QPushButton(autoDefault=False)
            button.setMinimumWidth(_MIN_COLOR_BUTTON_WIDTH)
            button.setToolTip(tr("Choose another color…"))

            def show_color(color: str) -> None:
                button.setIcon(create_swatch(color))
                button.setText(color)

            def ask_for_color() -> None:
                selected = QColorDialog.getColor(preferences.read_preference(preference), button, preference.label)
                if selected.isValid():
                    store(selected.name())

            show_color(value)
            button.clicked.connect(ask_for_color)
            return button, show_color
    raise TypeError(f"{type(preference).__name__} has no field.")


class ShortcutsPage(QWidget):
    """Page with a search field, a list of all actions, and the field in which a new key is pressed."""

    def __init__(self, shortcuts: Shortcuts) -> None:
        super().__init__()
        self._shortcuts = shortcuts
        self._conflicting_key = ""
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
        self.rows: dict[str, QTreeWidgetItem] = {}
        """Rows of the list by the names of their actions."""
        self._fill_action_list()
        self.list.currentItemChanged.connect(lambda *_: self._show_current())
        self.keys = QKeySequenceEdit(maximumSequenceLength=1)
        self.keys.setAccessibleName(tr("Press the new key"))
        self.keys.keySequenceChanged.connect(lambda _: self._on_key_entered())
        self.message = create_wrapped_label(dim=True)
        self.take_over, self.remove = QPushButton(tr("Use it here")), QPushButton(tr("Remove"))
        self.restore = QPushButton(tr("Reset"))
        self.take_over.setToolTip(tr("Remove the key from the other action."))
        self.remove.setToolTip(tr("Remove the key of this action."))
        self.restore.setToolTip(tr("Restore the default key of this action."))
        self.take_over.clicked.connect(lambda: self._assign_key(self._conflicting_key))
        self.remove.clicked.connect(lambda: self._assign_key(""))
        self.restore.clicked.connect(lambda: shortcuts.restore_default_keys(self._current_action))
        buttons = self.take_over, self.remove, self.restore
        for button in buttons:
            button.setAutoDefault(False)
        row = fill_layout(QHBoxLayout(), QLabel(tr("New key:")), self.keys, *buttons, wide=self.keys)
        fill_layout(QVBoxLayout(self), self.search, self.list, row, self.message, wide=self.list)
        shortcuts.changed.connect(self._show_keys)
        self._show_keys()

    def _fill_action_list(self) -> None:
        for action in self._shortcuts.actions:
            if action.group not in self._groups:
                self._groups[action.group] = group = QTreeWidgetItem(self.list, [action.group])
                group.setFlags(Qt.ItemFlag.ItemIsEnabled)
                group.setFirstColumnSpanned(True)
                group.setExpanded(True)
            self.rows[action.name] = item = QTreeWidgetItem(self._groups[action.group], [action.title])
            item.setData(0, _ACTION_NAME_ROLE, action.name)

    @property
    def _current_action(self) -> str:
        item = self.list.currentItem()
        return (item.data(0, _ACTION_NAME_ROLE) or "") if item is not None else ""

    def _show_keys(self) -> None:
        """Show the current keys of the actions that match the search."""
        wanted = self.search.text().casefold()
        for name, item in self.rows.items():
            item.setText(1, ", ".join(map(native_key_text, self._shortcuts.find_keys(name))))
            item.setHidden(wanted not in f"{item.text(0)} {item.text(1)}".casefold())
        for group in self._groups.values():
            group.setHidden(all(item.isHidden() for item in self.rows.values() if item.parent() is group))
        self._show_current()

    def _show_current(self) -> None:
        name = self._current_action
        with QSignalBlocker(self.keys):
            keys = self._shortcuts.find_keys(name) if name else ()
            self.keys.setKeySequence(QKeySequence(keys[0] if keys else ""))
        for widget in (self.keys, self.remove, self.restore):
            widget.setEnabled(bool(name))
        self._show_message(
            tr("Choose the field and press the new key.") if name else tr("Select an action to change its key.")
        )

    def _show_message(self, text: str, wanted: str = "") -> None:
        self._conflicting_key = wanted
        self.message.setText(text)
        self.take_over.setVisible(bool(wanted))

    def _on_key_entered(self) -> None:
        """Assign the key that was pressed, or explain why it cannot be used."""
        key, name = self.keys.keySequence().toString(QKeySequence.SequenceFormat.PortableText), self._current_action
        if not name or not key:
            return
        other, refused = self._shortcuts.find_holder(key, name), explain_reserved_key(key)
        if refused:
            self._show_message(refused)
        elif other is not None:
            self._show_message(tr("{key} belongs to “{action}”.", key=native_key_text(key), action=other.title), key)
        else:
            self._assign_key(key)

    def _assign_key(self, key: str) -> None:
        if self._current_action:
            self._shortcuts.assign_key(self._current_action, key)
            self._show_current()
