"""Tables of items: columns as data, rows that stay in place, and a selection shared with the canvas."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence, Set
from functools import partial
from itertools import groupby
from typing import Any, Generic, TypeVar

from PySide6.QtCore import (
    QAbstractTableModel,
    QEvent,
    QItemSelection,
    QItemSelectionModel,
    QModelIndex,
    QPersistentModelIndex,
    QPoint,
    Qt,
    QTimer,
    Signal,
)
from PySide6.QtGui import QKeyEvent, QMouseEvent, QPalette, QResizeEvent, QShowEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QLineEdit,
    QMenu,
    QSizePolicy,
    QStyle,
    QStyledItemDelegate,
    QTableView,
    QToolButton,
    QWidget,
)

from cpm_app.model.display.lengths import PixelSize, format_measured
from cpm_app.model.text.keys import insert_keys
from cpm_app.model.text.language import localize_number, tr
from cpm_app.views.theme.icons import load_icon
from cpm_app.views.widgets.actions import add_menu_action
from cpm_app.views.widgets.containers import DELETE_KEYS, ENTER_KEYS, claim_key
from cpm_core.numerics.types import Callback, frozen

Row = TypeVar("Row")
CellIndex = QModelIndex | QPersistentModelIndex
Role = Qt.ItemDataRole

_NUMBER_ALIGNMENT = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
"""Alignment of columns that hold numbers."""

_READ_ONLY_FLAGS = Qt.ItemFlag.ItemIsSelectable | Qt.ItemFlag.ItemIsEnabled
"""Flags of a cell that cannot be edited."""

_EDITABLE_FLAGS = _READ_ONLY_FLAGS | Qt.ItemFlag.ItemIsEditable
"""Flags of a cell with a name that can be edited."""

NO_VALUE_TEXT = "–"
"""Text of a cell without a value."""

_ROW_KEYS = (Qt.Key.Key_Up, Qt.Key.Key_Down)
"""Keys that go from row to row."""

_MIN_TABLE_HEIGHT = 48
"""Smallest height of a table [px]."""

_COLUMN_PADDING = 12
"""Space around the text of a column [px]."""


def _group_consecutive(rows: Sequence[int]) -> Iterator[tuple[int, int]]:
    """Yield first and last of each group of consecutive rows, as Qt is slow with many ranges."""
    for _, block in groupby(enumerate(rows), lambda pair: pair[1] - pair[0]):
        found = [row for _, row in block]
        yield found[0], found[-1]


@frozen
class Column(Generic[Row]):
    """One column of a table.

    Attributes
    ----------
    name : str
        Name in code.
    title : str
        Heading, with ``{unit}`` for the unit of lengths.
    tip : str
        Tooltip of the heading.
    value : callable
        Number or text of a row; None where there is none.
    sample : str
        Widest usual text.
    power : int
        1 for lengths, 2 for areas, 3 for volumes, which are shown in the preferred unit.
    number_format : str
        Format of a number; empty for three significant digits.
    suffix : str
        Text after a number.
    sort_by : callable, optional
        Number by which rows are sorted, by default the value.
    icon : callable, optional
        Name of the icon that a row shows instead of its value, and whether that is a state that is out of the ordinary;
        the name is empty for none. A click on the icon changes the state, and the heading is empty.
    """

    name: str
    title: str
    tip: str
    value: Callable[[Row], float | str | None]
    sample: str
    power: int = 0
    number_format: str = ""
    suffix: str = ""
    sort_by: Callable[[Row], float] | None = None
    icon: Callable[[Row], tuple[str, bool]] | None = None

    @property
    def is_numeric(self) -> bool:
        """Whether the column holds numbers, which are aligned to the right."""
        return not any(map(str.isalpha, self.sample))

    def format_cell(self, row: Row, factor: float) -> str:
        """Format the cell of a row; lengths are multiplied by a factor."""
        value = self.value(row)
        if isinstance(value, str):
            return value
        if value is None or not math.isfinite(value):
            return NO_VALUE_TEXT
        value *= factor**self.power
        if self.number_format:
            return localize_number(format(value, self.number_format)) + self.suffix
        return format_measured(value, 3)

    def sort_key(self, row: Row) -> float | str:
        """Return the sort key of a row; rows without a number come first, those without a text last."""
        value = self.value(row) if self.sort_by is None else self.sort_by(row)
        if isinstance(value, str) or (not self.is_numeric and value is None):
            return (value or "\uffff").casefold()
        return -math.inf if value is None or math.isnan(value) else float(value)


class TableModel(QAbstractTableModel, Generic[Row]):
    """Sorted rows, identified by the keys of their items: an update preserves the selection and a name being edited.

    It sorts them itself and computes each sort key once; Qt would ask for two in each comparison.

    Parameters
    ----------
    columns : sequence of Column
        Columns in the order shown.
    key : callable
        Returns the key that identifies an item.
    look : callable, optional
        Icon, color or font of an item for a role; the third argument is whether the cell is that of the name.
    rename : callable, optional
        Gives the item with a key the name that was typed into the column ``name``.
    """

    def __init__(
        self,
        columns: Sequence[Column[Row]],
        key: Callable[[Row], Hashable],
        look: Callable[[Row, int, bool], Any] = lambda *_: None,
        rename: Callable[[Any, str], None] | None = None,
    ) -> None:
        super().__init__()
        self.columns = columns
        self.items: list[Row] = []
        self._key, self._look, self._rename = key, look, rename
        self._texts: dict[tuple[Hashable, int], str] = {}
        """Texts of cells that Qt has asked for since the last update."""
        self._sort_column, self._sort_order = 0, Qt.SortOrder.AscendingOrder
        self.unit, self.factor = "px", 1.0

    def item_key(self, row: int) -> Any:
        """Return the key of the item in a row."""
        return self._key(self.items[row])

    def update_items(
        self, items: Iterable[Row], size: PixelSize | None, columns: Sequence[Column[Row]] | None = None
    ) -> None:
        """Show these items, with lengths in the unit of a pixel size."""
        if size is not None:
            square = set(size.spacing) == {1.0}
            self.unit, self.factor = size.unit or ("px" if square else tr("units")), size.factor
        self.columns = columns or self.columns
        wanted = self._sort_items(items)
        present = {self._key(item): item for item in wanted}
        gone = [row for row in range(len(self.items)) if self.item_key(row) not in present]
        for first, last in reversed([*_group_consecutive(gone)]):
            self.beginRemoveRows(QModelIndex(), first, last)
            del self.items[first : last + 1]
            self.endRemoveRows()
        known = {*map(self._key, self.items)}
        self._reorder_items([item for item in wanted if self._key(item) in known])
        self._texts = {}
        if self.items:
            self.dataChanged.emit(self.index(0, 0), self.index(len(self.items) - 1, len(self.columns) - 1))
        self.headerDataChanged.emit(Qt.Orientation.Horizontal, 0, len(self.columns) - 1)
        for first, last in _group_consecutive([row for row, item in enumerate(wanted) if self._key(item) not in known]):
            self.beginInsertRows(QModelIndex(), first, last)
            self.items[first:first] = wanted[first : last + 1]
            self.endInsertRows()

    def _sort_items(self, items: Iterable[Row]) -> list[Row]:
        if self._sort_column < 0:  # in the given order
            return [*items]
        return sorted(
            items,
            key=self.columns[self._sort_column].sort_key,
            reverse=self._sort_order == Qt.SortOrder.DescendingOrder,
        )

    def _reorder_items(self, items: list[Row]) -> None:
        """Replace the items by others with the same keys, in their order."""
        now, before = {self._key(item): row for row, item in enumerate(items)}, [*map(self._key, self.items)]
        if before == [*now]:
            self.items = items
            return
        self.layoutAboutToBeChanged.emit()
        marked = self.persistentIndexList()
        self.items = items
        self.changePersistentIndexList(
            marked, [self.index(now[before[index.row()]], index.column()) for index in marked]
        )
        self.layoutChanged.emit()

    def unit_suffix(self, column: Column[Row]) -> str:
        """Return the unit of a column with a space before it; empty for numbers without a unit."""
        return f" {self.unit}{('', '', '²', '³')[column.power]}" if column.power else ""

    # Qt interface

    def rowCount(self, parent: CellIndex = QModelIndex()) -> int:  # noqa: B008  # as Qt declares it
        """Return the number of items."""
        return 0 if parent.isValid() else len(self.items)

    def columnCount(self, parent: CellIndex = QModelIndex()) -> int:  # noqa: B008  # as Qt declares it
        """Return the number of columns."""
        return 0 if parent.isValid() else len(self.columns)

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = Role.DisplayRole) -> Any:
        """Return a heading with the unit of lengths, or its tooltip."""
        if orientation == Qt.Orientation.Vertical:
            return None
        column = self.columns[section]
        if role == (Role.DisplayRole if column.icon is None else Role.AccessibleTextRole):
            return column.title.format(unit=self.unit)
        return f"{insert_keys(column.tip)}{self.unit_suffix(column)}" if role == Role.ToolTipRole else None

    def data(self, index: CellIndex, role: int = Role.DisplayRole) -> Any:
        """Return text, alignment or look of a cell."""
        item, column = self.items[index.row()], self.columns[index.column()]
        match role:
            case Role.DisplayRole | Role.DecorationRole if column.icon is not None:
                name, special = column.icon(item)
                color = QPalette.ColorRole.WindowText if special else QPalette.ColorRole.PlaceholderText
                return load_icon(name, color) if name and role == Role.DecorationRole else None
            case Role.DisplayRole | Role.ToolTipRole:
                cell = self._key(item), index.column()
                if cell not in self._texts:
                    self._texts[cell] = column.format_cell(item, self.factor)
                return self._texts[cell]
            case Role.EditRole:
                return column.value(item)
            case Role.TextAlignmentRole:
                return _NUMBER_ALIGNMENT if column.is_numeric else None
            case Role.DecorationRole | Role.ForegroundRole | Role.FontRole:
                return self._look(item, role, column.name == "name")
        return None

    def sort(self, column: int, order: Qt.SortOrder = Qt.SortOrder.AscendingOrder) -> None:
        """Sort the rows by a column."""
        self._sort_column, self._sort_order = column, order
        self._reorder_items(self._sort_items(self.items))

    def setData(self, index: CellIndex, value: Any, role: int = Role.EditRole) -> bool:
        """Rename an item."""
        if self._rename is None or role != Role.EditRole:
            return False
        self._rename(self.item_key(index.row()), str(value))
        return True

    def flags(self, index: CellIndex) -> Qt.ItemFlag:
        """Return the flags of a cell; only names can be edited."""
        editable = self._rename is not None and self.columns[index.column()].name == "name"
        return _EDITABLE_FLAGS if editable else _READ_ONLY_FLAGS


class SortableTable(QTableView):
    """Table whose rows are sorted by a click on a heading.

    If it is too narrow for all columns, those without any value are hidden, then the last ones, not scrolled; the user
    shows and hides columns by the menu of the header. The column `wide` takes the remaining width.
    """

    def __init__(self, rows: TableModel[Any], wide: str, name: str) -> None:
        super().__init__(showGrid=False, wordWrap=False)
        self.rows = rows
        rows.setParent(self)
        self.setModel(rows)
        self.setAccessibleName(name)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSortingEnabled(True)
        self.sortByColumn(0, Qt.SortOrder.AscendingOrder)
        self.setAlternatingRowColors(True)
        self.setTabKeyNavigation(False)
        self.setMinimumHeight(_MIN_TABLE_HEIGHT)
        self.verticalHeader().hide()
        self.verticalHeader().setDefaultSectionSize(self.fontMetrics().height() + 8)
        header = self.horizontalHeader()
        header.setHighlightSections(False)
        header.setMinimumSectionSize(_COLUMN_PADDING)
        # With the selection model of the table, the header would query each cell of each selected row in every paint.
        header.setSelectionModel(QItemSelectionModel(rows, header))
        header.setDefaultAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        header.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        header.customContextMenuRequested.connect(self._open_header_menu)
        self._stretched_column = self.column_index(wide)
        header.setSectionResizeMode(self._stretched_column, QHeaderView.ResizeMode.Stretch)
        self._columns_set_by_user: dict[int, bool] = {}
        self._widths = self._measure_samples()
        header.sortIndicatorChanged.connect(self._measure_columns)

    def column_index(self, column: str) -> int:
        """Return the index of a column."""
        return [known.name for known in self.rows.columns].index(column)

    def describe_cell(self, row: Any, column: Column[Any]) -> str:
        """Return title, text and unit of a cell; empty if it has no value."""
        text = column.format_cell(row, self.rows.factor)
        return f"{column.title} {text}{self.rows.unit_suffix(column)}" if text != NO_VALUE_TEXT else ""

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Show the columns for which there is room."""
        self._fit_columns()
        super().resizeEvent(event)

    def showEvent(self, event: QShowEvent) -> None:
        """Make room for the whole titles, whose widths are known once the table is visible."""
        super().showEvent(event)
        self._measure_columns()

    def _measure_samples(self) -> list[int]:
        """Return the widths that usual texts need, and the largest area or volume, whose digits may be many."""
        widths, items, measure = [], self.rows.items, self.fontMetrics().horizontalAdvance
        for column in self.rows.columns:
            largest = max(items, key=column.sort_key) if items and column.power > 1 else None
            number = "" if largest is None else column.format_cell(largest, self.rows.factor)
            widths.append(max(measure(column.sample), measure(number)) + _COLUMN_PADDING)
        widths[self._stretched_column] += _COLUMN_PADDING  # room for the color
        return widths

    def _measure_columns(self) -> None:
        """Make room for the titles, and for the arrow in the column by which rows are sorted; Qt would in each."""
        header = self.horizontalHeader()
        arrow = self.style().pixelMetric(QStyle.PixelMetric.PM_HeaderMarkSize, None, header)
        for index, width in enumerate(self._measure_samples()):
            self.setColumnHidden(index, False)
            title = header.sectionSizeHint(index) - arrow * (index != header.sortIndicatorSection())
            title *= self.rows.columns[index].icon is None
            self._widths[index] = max(width, title)
            self.setColumnWidth(index, self._widths[index])
        self._fit_columns()

    def _fit_columns(self) -> None:
        """Show the columns for which there is room, each at least as wide as what it holds now."""
        for index, width in enumerate(self._measure_samples()):
            if width > self._widths[index]:
                self._widths[index] = width
                self.setColumnWidth(index, width)
        asked = sum(self._widths[index] for index, on in self._columns_set_by_user.items() if on)
        room = self.viewport().width() - self._widths[self._stretched_column] - asked
        items = self.rows.items
        empty = [
            column.icon is None and bool(items) and all(column.value(item) is None for item in items)
            for column in self.rows.columns
        ]
        for index, needed in sorted(enumerate(self._widths), key=lambda each: empty[each[0]]):
            shown = self._columns_set_by_user.get(index, index == self._stretched_column)
            if not shown and index not in self._columns_set_by_user:
                room -= needed
                shown = room >= 0
            self.setColumnHidden(index, not shown)

    def _open_header_menu(self, point: QPoint) -> None:
        """Open the menu of the header, which shows and hides columns."""
        menu = QMenu(self, toolTipsVisible=True)
        for index, column in enumerate(self.rows.columns):
            title, hidden = column.title.format(unit=self.rows.unit), self.isColumnHidden(index)
            shown = add_menu_action(
                menu, title, partial(self._set_column_shown, index, hidden), insert_keys(column.tip), not hidden
            )
            shown.setEnabled(index != self._stretched_column)
        menu.aboutToHide.connect(menu.deleteLater)
        menu.popup(self.horizontalHeader().mapToGlobal(point))

    def _set_column_shown(self, index: int, shown: bool) -> None:
        self._columns_set_by_user[index] = shown
        self._fit_columns()


class _NameDelegate(QStyledItemDelegate):
    """Editor of names that updates do not disturb."""

    def setEditorData(self, editor: QWidget, index: CellIndex) -> None:
        """Start with the current name, and do not overwrite what the user has typed."""
        if not (isinstance(editor, QLineEdit) and editor.isModified()):
            super().setEditorData(editor, index)


class ItemTable(SortableTable):
    """Table in which items are selected and named; subclasses act on the keys of the items."""

    zoom_wanted = Signal()
    """The user asks to see the selected items as large as possible."""

    _showing = True  # while Qt constructs the widget

    menu_name = ""
    """Name of its rows in the context menus."""

    def __init__(self, rows: TableModel[Any], name: str) -> None:
        super().__init__(rows, "name", name)
        self._showing = False
        self._stale = False
        self._update_timer = QTimer(self, singleShot=True, interval=0)
        self._update_timer.timeout.connect(self._update_now)
        self.setItemDelegate(_NameDelegate(self))
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setEditTriggers(QAbstractItemView.EditTrigger.EditKeyPressed)
        self.setMouseTracking(True)
        self.entered.connect(lambda index: self.hover_item(self.rows.item_key(index.row())))
        self.doubleClicked.connect(self._on_double_clicked)

    @property
    def selected_keys(self) -> Set[Any]:
        """Keys of the selected items."""
        raise NotImplementedError

    def update_rows(self) -> None:
        """Update the rows of the model."""
        raise NotImplementedError

    def select_keys(self, keys: Sequence[Any]) -> None:
        """Select items."""
        raise NotImplementedError

    def remove_selected(self) -> None:
        """Remove the selected items, on the key Delete."""
        raise NotImplementedError

    def hover_item(self, key: Any) -> None:
        """Highlight an item, or none."""

    def press_icon(self, key: Any, column: str) -> None:
        """Change the state that the icon of an item in a column shows."""

    def show_items(self) -> None:
        """Schedule an update of the rows; a hidden table is updated when it becomes visible."""
        self._stale = True
        if self.isVisible():
            self._update_timer.start()

    def _update_now(self) -> None:
        self._stale, self._showing = False, True
        self.update_rows()
        self._fit_columns()
        self._showing = False
        self.show_selection()

    def show_selection(self) -> None:
        """Show which items are selected."""
        wanted = self.selected_keys
        if self._stale or set(self._selected_in_view) == wanted:
            return
        selection, name = QItemSelection(), self.column_index("name")
        rows = [row for row in range(len(self.rows.items)) if self.rows.item_key(row) in wanted]
        for first, last in _group_consecutive(rows):
            selection.select(self.rows.index(first, 0), self.rows.index(last, len(self.rows.columns) - 1))
        self._showing = True
        self.selectionModel().select(selection, QItemSelectionModel.SelectionFlag.ClearAndSelect)
        if rows and self.state() != QAbstractItemView.State.EditingState:
            at = self.rows.index(rows[0], name)
            self.selectionModel().setCurrentIndex(at, QItemSelectionModel.SelectionFlag.NoUpdate)
            self.scrollTo(at)
        self._showing = False

    def menu_at(self, point: QPoint | None) -> tuple[str, QPoint]:
        """Return the selected rows; select a row at the point first. See `MenuOwner`."""
        inside = self.viewport().mapFrom(self, point) if point is not None else None
        index = self.indexAt(inside) if inside is not None else self.currentIndex()
        if index.isValid() and not self.selectionModel().isRowSelected(index.row(), QModelIndex()):
            self.selectRow(index.row())
        place = self.viewport().mapTo(self, self.visualRect(index).center()) if point is None else point
        return self.menu_name if self.selected_keys else "", place

    # Qt interface

    def event(self, event: QEvent) -> bool:
        """Handle the keys of the table before they act as shortcuts of the window."""
        return claim_key(event, DELETE_KEYS) or super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Edit the name on Enter, remove on Delete; an arrow key first selects the current row."""
        if event.key() in ENTER_KEYS:
            self.edit_name(self.currentIndex().row())
        elif event.key() in DELETE_KEYS:
            self.remove_selected()
        elif event.key() in _ROW_KEYS and not self.selected_keys and self.currentIndex().isValid():
            self.selectRow(self.currentIndex().row())
        else:
            super().keyPressEvent(event)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Act on an icon, without selecting its row."""
        index = self.indexAt(event.position().toPoint())
        column = self.rows.columns[index.column()] if index.isValid() else None
        if column is not None and column.icon is not None and event.button() == Qt.MouseButton.LeftButton:
            self.press_icon(self.rows.item_key(index.row()), column.name)
        else:
            super().mousePressEvent(event)

    def showEvent(self, event: QShowEvent) -> None:
        """Update the table if items changed while it was hidden."""
        super().showEvent(event)
        if self._stale:
            self._update_now()

    def selectionChanged(self, selected: QItemSelection, deselected: QItemSelection) -> None:
        """Pass on what the user has selected."""
        super().selectionChanged(selected, deselected)
        if not self._showing:
            self.select_keys(self._selected_in_view)

    def leaveEvent(self, event: QEvent) -> None:
        """Clear the highlight when the pointer leaves."""
        self.hover_item(None)
        super().leaveEvent(event)

    @property
    def _selected_in_view(self) -> list[Any]:
        """Keys of the rows selected in the view; Qt's ``selectedRows`` is slow with many ranges."""
        ranges = self.selectionModel().selection().toList()
        return [self.rows.item_key(row) for one in ranges for row in range(one.top(), one.bottom() + 1)]

    def _on_double_clicked(self, index: QModelIndex) -> None:
        if index.column() == self.column_index("name"):
            self.edit_name(index.row())
        elif self.rows.columns[index.column()].icon is None:
            self.zoom_wanted.emit()

    def edit_selected_name(self) -> None:
        """Edit the name of the first selected row."""
        if self._stale:
            self._update_now()
        for index in self.selectionModel().selectedRows()[:1]:
            self.edit_name(index.row())

    def edit_name(self, row: int) -> None:
        """Edit the name in a row."""
        index = self.rows.index(row, self.column_index("name"))
        if index.flags() & Qt.ItemFlag.ItemIsEditable and self.state() != QAbstractItemView.State.EditingState:
            self.edit(index)


def create_wide_button(text: str, do: Callback) -> QToolButton:
    """Create a button that fills the available width."""
    button = QToolButton()
    button.setText(text)
    button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
    button.clicked.connect(lambda _=False: do())
    return button
