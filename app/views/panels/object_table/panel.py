"""The panel of the objects: the table, with what can be done to objects beside it."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from PySide6.QtCore import QSize
from PySide6.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QMenu, QToolButton, QVBoxLayout, QWidget

from app.model.text.keys import with_keys
from app.model.text.language import tr
from app.session.features.object_list import ObjectList
from app.session.session import Session
from app.views.panels.item_table.row_table import LEAST
from app.views.panels.object_table.view import ObjectTable
from app.views.widgets.scrolled import Scrolled

_BESIDE = 236


class ObjectPanel(QWidget):
    """Shows the objects; `fill_classes` fills a menu with the classes on offer."""

    def __init__(self, session: Session, object_list: ObjectList, fill_classes: Callable[[QMenu], None]) -> None:
        super().__init__()
        self._session, self._list = session, object_list
        self.table = ObjectTable(session, object_list)
        self.setFocusProxy(self.table)
        self.summary = QLabel()
        self.summary.setWordWrap(True)
        self.summary.setObjectName("dim")
        self.buttons: dict[str, QToolButton] = {}
        self._classes = QMenu(self)
        self._classes.aboutToShow.connect(partial(self._fill, fill_classes))
        layout = QHBoxLayout(self)
        layout.setContentsMargins(12, 6, 12, 6)
        layout.setSpacing(12)
        layout.addWidget(Scrolled(self._make_beside(), LEAST))
        layout.addWidget(self.table, 1)
        object_list.changed.connect(self._show)
        object_list.selection_changed.connect(self._show)
        session.image_changed.connect(self._show)
        self._show()

    def sizeHint(self) -> QSize:
        """Wide and low."""
        return QSize(900, 230)

    def _make_beside(self) -> QWidget:
        beside = QWidget()
        beside.setMaximumWidth(_BESIDE)
        column = QVBoxLayout(beside)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(6)
        column.addWidget(self.summary)
        grid = QGridLayout()
        grid.setSpacing(4)
        parts: tuple[tuple[str, str, Callable[[], None] | None], ...] = (
            ("class", tr("Class"), None),
            ("name", tr("Name…"), self.table.name_selected),
            ("freeze", tr("Freeze"), self._list.toggle_frozen),
            ("hide", tr("Hide"), self._list.toggle_hidden),
            ("merge", tr("Merge"), self._list.merge),
            ("delete", tr("Delete"), self._list.delete),
        )
        for place, (name, text, do) in enumerate(parts):
            button = self.buttons[name] = QToolButton()
            button.setText(text)
            button.setSizePolicy(button.sizePolicy().Policy.Expanding, button.sizePolicy().Policy.Fixed)
            if do is not None:
                button.clicked.connect(do)
            grid.addWidget(button, place // 2, place % 2)
        self.buttons["class"].setMenu(self._classes)
        self.buttons["class"].setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        column.addLayout(grid)
        column.addStretch(1)
        return beside

    def show_keys(self) -> None:
        """Name the keys as they are now."""
        self._show()

    def _fill(self, fill_classes: Callable[[QMenu], None]) -> None:
        self._classes.clear()
        fill_classes(self._classes)

    def _show(self) -> None:
        items, chosen = self._list.objects.items, self._list.items
        self.summary.setText(self._summary())
        for name, button in self.buttons.items():
            button.setEnabled(len(chosen) > 1 if name == "merge" else bool(chosen) or (name == "class" and bool(items)))
        self.buttons["freeze"].setText(tr("Release") if chosen and all(i.frozen for i in chosen) else tr("Freeze"))
        self.buttons["hide"].setText(tr("Show") if chosen and all(item.hidden for item in chosen) else tr("Hide"))

    def _summary(self) -> str:
        objects = self._list.objects
        if not objects.items:
            return with_keys(tr("No objects yet. Take the tool Select objects ({key:objects}) and click in one."))
        if len(objects.items) == 1:
            return tr("1 object.")
        return tr("{count} objects.").format(count=len(objects.items))
