"""The page of the shortcuts: all actions with their keys, which are changed by pressing others."""

from __future__ import annotations

from PySide6.QtCore import QModelIndex, QSignalBlocker, Qt
from PySide6.QtGui import QKeySequence
from PySide6.QtWidgets import (
    QHBoxLayout,
    QHeaderView,
    QKeySequenceEdit,
    QLabel,
    QLineEdit,
    QPushButton,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from app.model.preferences.shortcuts import refusal
from app.model.text.language import tr
from app.views.widgets.key_text import native, natives
from app.views.window.keys.shortcuts import Shortcuts

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
