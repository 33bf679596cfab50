"""The cheat sheet: all keys of the menus, the panels and the canvas."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QKeySequence, QShortcut
from PySide6.QtWidgets import (
    QDialog,
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QMainWindow,
    QScrollArea,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from app.model.text.keys import with_keys
from app.model.text.language import tr
from app.views.widgets.action_spec import LAYER, ActionSpec
from app.views.widgets.key_text import native
from app.views.window.docks import PanelAction
from app.views.window.menus import MENUS

KeyTable = Sequence[tuple[tuple[str, ...], str]]
"""Rows of equivalent keys, which may be those of actions (see `with_keys`), and their effect."""

_POINTER: KeyTable = (
    ((tr("left"),), tr("current tool")),
    ((tr("right"),), tr("menu of what lies there")),
    ((tr("right drag, middle drag"),), tr("move the image")),
    ((tr("wheel"),), tr("zoom")),
    (("Shift",), tr("circle; eight directions")),
    (("Ctrl",), tr("ellipse from its center")),
    ((tr("Shift-click"),), tr("cut a contour; remove from the object")),
)
_IMAGE: KeyTable = (
    (("Enter",), tr("show the cross-hair")),
    (("←↑↓→",), tr("move the cross-hair, the selected shape or the image")),
    (("Shift+←↑↓→",), tr("the same by 10 px")),
    (("Enter",), tr("press and release at the cross-hair")),
    (("Enter", "Enter"), tr("end a path")),
    (("Backspace",), tr("remove the last corner")),
    (("{key:escape}",), tr("cancel")),
    (("Enter",), tr("accept the object that is offered; rename it")),
    (("1 … 9",), tr("class of the object")),
    (("<", ">"), tr("size of shape or ring, strength, spacing")),
)
_FIELDS: KeyTable = (
    (("Enter",), tr("enter the value, go back to the image; press the button")),
    (("Esc",), tr("restore the value, go back to the image")),
    (("↑↓",), tr("next slider; next row of a table")),
    (("←→",), tr("move the slider")),
    (("{key:run}",), tr("run or pause, unless a name is typed")),
)
KEYS = "keys"
"""Name of the action that opens the sheet and closes it."""

_COLUMNS, _WIDTH, _KEYS = 4, 296, 100
"""Maximum number of columns, the width of each, and the width of the keys in it [px]."""

_TOOLS, _LAYERS = "tools", "layers"
_LINE = 24
"""Characters of a meaning that fit in one line."""

_BAR = 16
"""Space for a scroll bar [px]."""

_MARGIN = 48
"""Space around the sheet in the window [px]."""


class CheatSheet(QDialog):
    """All keys in groups, over the window; the key that opens it, or Esc, closes it."""

    def __init__(self, window: QMainWindow, specs: Iterable[ActionSpec]) -> None:
        super().__init__(window)
        specs = list(specs)
        for key in next((spec.shortcuts for spec in specs if spec.name == KEYS), ()):
            QShortcut(QKeySequence(key), self, self.close)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(tr("Keys"))
        self.setObjectName("cheat_sheet")
        inside = QWidget()
        inside.setObjectName("scrolled")
        columns = QHBoxLayout(inside)
        columns.setSpacing(20)
        room = window.size() - QSize(_MARGIN, _MARGIN)
        many = min(max(room.width() // _WIDTH, 1), _COLUMNS)
        for blocks in _balanced(groups(window, specs), many):
            column = QVBoxLayout()
            column.setSpacing(14)
            for title, lines in blocks:
                column.addWidget(_block(title, lines))
            column.addStretch(1)
            columns.addLayout(column, 1)
        area = QScrollArea()
        area.setWidgetResizable(True)
        area.setFrameShape(QFrame.Shape.NoFrame)
        area.setWidget(inside)
        foot = QLabel(with_keys(tr("{key:keys} or Esc closes this sheet.")))
        foot.setObjectName("dim")
        layout = QVBoxLayout(self)
        layout.addWidget(area)
        layout.addWidget(foot)
        width = min(many * _WIDTH, room.width())
        height = inside.heightForWidth(width) + layout.sizeHint().height() - area.sizeHint().height()
        self.resize(QSize(width + _BAR, height + _BAR).boundedTo(room))
        self.move(window.geometry().center() - self.rect().center())

    def text(self) -> str:
        """All texts of the sheet."""
        return "\n".join(label.text() for label in self.findChildren(QLabel))


def groups(window: QMainWindow, specs: Iterable[ActionSpec]) -> list[tuple[str, KeyTable]]:
    """All keys in groups: those of each menu, of the panels, and of the canvas."""
    titles = {_TOOLS: tr("Tools"), _LAYERS: tr("Layers"), **{name: _plain(title) for name, title in MENUS.items()}}
    found: dict[str, list[tuple[tuple[str, ...], str]]] = {name: [] for name in titles}
    for spec in specs:
        if spec.shortcuts:
            keys = tuple(native(key) for key in spec.shortcuts[:2])
            group = spec.menu.partition(">")[0]
            group = _TOOLS if spec.group == "tool" else _LAYERS if spec.name.startswith(LAYER) else group
            found[group].append((keys, _plain(spec.text)))
    keyed = [action for action in window.findChildren(PanelAction) if not action.shortcut().isEmpty()]
    panels = [((native(action.shortcut().toString()),), action.text()) for action in keyed]
    for rows in (panels, found[_LAYERS]):
        rows.sort(key=lambda row: _order(row[0][0]))
    sections = (
        (titles[_TOOLS], found.pop(_TOOLS)),
        (tr("Keys on the image"), _with_keys(_IMAGE)),
        (tr("Mouse on the image"), _POINTER),
        (tr("In fields and tables"), _with_keys(_FIELDS)),
        (titles[_LAYERS], found.pop(_LAYERS)),
        (tr("Panels"), panels),
        *((titles[name], lines) for name, lines in found.items()),
    )
    return [(title, rows) for title, rows in sections if rows]


def _with_keys(table: KeyTable) -> KeyTable:
    return [(tuple(map(with_keys, keys)), meaning) for keys, meaning in table]


def _order(key: str) -> tuple[int, str, int]:
    """Place of a key among others: function keys first, then by modifier, digits as on the keyboard with 0 last."""
    held, _, last = key.rpartition("+")
    number = int("".join(filter(str.isdigit, last)) or 0)
    return bool(held) or not last.startswith("F"), held, number if number or not last.isdigit() else 10


def _balanced(blocks: Sequence[tuple[str, KeyTable]], many: int) -> list[list[tuple[str, KeyTable]]]:
    """The blocks, in order, in at most `many` columns of the least height."""
    heights = [2 + sum(-(-max(len(what), 1) // _LINE) for _, what in lines) for _, lines in blocks]
    for most in range(max(heights), sum(heights) + 1):
        columns: list[list[tuple[str, KeyTable]]] = [[]]
        room = most
        for block, height in zip(blocks, heights, strict=True):
            if height > room:
                columns.append([])
                room = most
            columns[-1].append(block)
            room -= height
        if len(columns) <= many:
            return columns
    return [list(blocks)]


def _block(title: str, lines: KeyTable) -> QWidget:
    block = QWidget()
    grid = QGridLayout(block)
    grid.setContentsMargins(0, 0, 0, 0)
    grid.setHorizontalSpacing(12)
    grid.setVerticalSpacing(3)
    heading = QLabel(title)
    heading.setObjectName("heading")
    grid.addWidget(heading, 0, 0, 1, 2)
    for row, (keys, what) in enumerate(lines, start=1):
        caps = QLabel(" &nbsp;".join(f"<b>{_escaped(key)}</b>" for key in keys))
        caps.setTextFormat(Qt.TextFormat.RichText)
        meaning = QLabel(what)
        meaning.setWordWrap(True)
        meaning.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        grid.addWidget(caps, row, 0, Qt.AlignmentFlag.AlignTop)
        grid.addWidget(meaning, row, 1)
    grid.setColumnMinimumWidth(0, _KEYS)
    grid.setColumnStretch(1, 1)
    return block


def _plain(text: str) -> str:
    return text.replace("&", "").rstrip("…")


def _escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
