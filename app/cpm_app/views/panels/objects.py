"""Panel of the objects: figures of the selected one, the classes, and the table of objects and proposals."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
from PySide6.QtCore import QSize, Qt, QTimer
from PySide6.QtGui import (
    QColor,
    QGuiApplication,
    QKeyEvent,
    QPalette,
    QShowEvent,
)
from PySide6.QtWidgets import (
    QComboBox,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QMenu,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from cpm_app.model.display.lengths import preferred_pixel_size
from cpm_app.model.document.objects import class_title, list_classes
from cpm_app.model.text.language import tr
from cpm_app.session.features.object_brush import BRUSH_RADIUS_RANGE
from cpm_app.session.features.object_commands import ObjectCommands, ObjectState
from cpm_app.session.features.object_list import ObjectList
from cpm_app.session.features.object_measures import ObjectFigures
from cpm_app.session.features.object_rows import ItemKey, ObjectRow, RowKind
from cpm_app.session.features.outcome import describe_lack
from cpm_app.session.features.workspace import Workspace
from cpm_app.views.panels.tables import Column, ItemTable, Role, TableModel
from cpm_app.views.theme import theme
from cpm_app.views.theme.icons import create_swatch, fill_colors
from cpm_app.views.widgets.actions import ActionButton
from cpm_app.views.widgets.containers import ENTER_KEYS, create_wrapped_label, fill_layout
from cpm_app.views.widgets.fields import DecimalField, MarkedSlider
from cpm_core.numerics.types import Sides
from cpm_core.objects.confidence import whole_percent
from cpm_core.objects.segmented import SegmentedObjects


def _object_figure_getter(get: Callable[[ObjectFigures], float | None]) -> Callable[[ObjectRow], float | None]:
    """Return a function from a row to a figure of its object, or None while it is unknown."""
    return lambda row: None if row.figures is None else get(row.figures)


def _state_column(icon: str, title: str, tip: str, state: ObjectState, word: str) -> Column[ObjectRow]:
    """Build the column of a state that a click on its icon changes."""
    ordinary, special = ("eye", "eye_closed") if state == "hidden" else ("lock_open", "lock")

    def choose_icon(row: ObjectRow) -> tuple[str, bool]:
        on = getattr(row.item, state)
        return "" if row.kind == "proposal" else special if on else ordinary, on

    return Column(
        icon, title, tip, lambda row: word if getattr(row.item, state) else None, "0", icon=choose_icon,
        sort_by=lambda row: getattr(row.item, state),
    )  # fmt: skip


CONFIDENCE_TIP = tr(
    "Confidence: the estimated probability that the object covers most of the true one and little else."
)
"""Tooltip of the confidence."""


def build_object_columns(objects: SegmentedObjects, spacing: Sides = (1.0, 1.0)) -> tuple[Column[ObjectRow], ...]:
    """Build the columns, the most important first, for the classes of the objects and a pixel size."""
    pixel = float(np.prod(spacing))
    solid = len(spacing) == 3

    def describe_class(row: ObjectRow) -> str:
        if row.kind == "proposal":
            return tr("proposal")
        named = bool(objects.classes[row.item.category - 1].name)
        return f"{row.item.category} " * named + class_title(objects, row.item.category)

    def row_number(row: ObjectRow) -> int | str | None:
        number = abs(row.key[1])
        return f"({number})" if row.kind == "proposal" and number else number or None

    return (
        Column("number", "#", tr("Number; it stays the same. That of a proposal is in brackets."),
               row_number, "000", number_format=".0f",
               sort_by=lambda row: (row.kind == "proposal") * 1e7 + abs(row.key[1])),
        Column("name", tr("Name"), tr("Name and color; double-click or press {key:name_object} to rename."),
               lambda row: row.item.name, "name"),
        _state_column("eye", tr("Shown"), tr("A click on the eye hides an object, or shows it again."),
                      "hidden", tr("hidden")),
        _state_column("lock", tr("Frozen"), tr("A click on the lock freezes an object, or unfreezes it: frozen ones "
                                               "are not changed, and stop particles."), "frozen", tr("frozen")),
        Column("class", tr("Class"), tr("Class of an object, which the digits 1 to 9 set, or that it is a proposal."),
               describe_class, "proposal", sort_by=lambda row: 10 * (row.kind == "proposal") + row.item.category),
        Column("area", tr("Volume"), tr("Volume of the voxels inside, without hollows."),
               _object_figure_getter(lambda found: found.volume),
               "00,000", 3)
        if solid else
        Column("area", tr("Area"), tr("Area without holes."),
               lambda row: None if row.item.line else row.item.region.size * pixel, "00,000", 2),
        Column("confidence", tr("%"), CONFIDENCE_TIP,
               lambda row: whole_percent(row.item.confidence) if row.item.confidence else None,
               "00 %", number_format=".0f", suffix=" %", sort_by=lambda row: row.item.confidence),
        Column("length", tr("Area"), tr("Area of the surface, including hollows."),
               _object_figure_getter(lambda found: found.area), "00,000", 2)
        if solid else
        Column("length", tr("Length"),
               tr("Length of the boundary including holes, or of the line of an open object."),
               lambda row: row.item.measure_perimeter(spacing), "0,000", 1),
        Column("gray", tr("Mean gray"), tr("Mean gray value inside."),
               _object_figure_getter(lambda found: found.gray), "000.0"),
        Column("strength", tr("Strength"), tr("Mean edge strength along the boundary [gray levels/px]."),
               lambda row: row.item.strength or None, "000.0"),
        Column("gaps", tr("Surfaces"), tr("Number of closed surfaces that bound it: one more for each hollow."),
               _object_figure_getter(lambda found: found.parts), "0,000", number_format=".0f")
        if solid else
        Column("gaps", tr("Bridged"), tr("Length of the boundary that follows no contour; dashed."),
               lambda row: row.item.measure_gap_length(spacing) or None, "0,000", 1),
        Column("euler", tr("Euler number"),
               tr("Euler characteristic of its surface: 2 for a sphere, 2 less for each handle."),
               _object_figure_getter(lambda found: found.euler if solid else None), "000", number_format=".0f"),
    )  # fmt: skip


class ObjectTable(ItemTable):
    """Table of objects and proposals, in which they are selected, named, classified and removed."""

    menu_name = "object"

    def __init__(self, workspace: Workspace) -> None:
        self._session, self._commands = workspace.session, workspace.object_commands
        self._object_list, self._selection = workspace.object_list, workspace.object_selection
        object_list = self._object_list
        self._kinds: tuple[RowKind, ...] = ()
        rows = TableModel[ObjectRow](
            build_object_columns(object_list.objects),
            lambda row: row.key,
            self._get_cell_look,
            self._commands.rename_row,
        )
        super().__init__(rows, tr("Objects and proposals"))
        object_list.changed.connect(self.show_items)
        object_list.selection_changed.connect(self.show_selection)
        self._session.image_changed.connect(self.show_items)
        self.show_items()

    @property
    def selected_keys(self) -> frozenset[ItemKey]:
        """Keys of the selected rows."""
        return frozenset(row.key for row in self._object_list.selected_rows)

    def select_keys(self, keys: Sequence[ItemKey]) -> None:
        """Select rows."""
        self._object_list.select_items(keys)

    def remove_selected(self) -> None:
        """Delete the selected rows."""
        self._commands.delete_selected()

    def hover_item(self, key: ItemKey | None) -> None:
        """Highlight a row, or none."""
        self._object_list.set_hovered_item(key)

    def press_icon(self, key: ItemKey, column: str) -> None:
        """Hide or freeze the object of a row, and all selected ones if it is one of them."""
        self._commands.toggle_state("hidden" if column == "eye" else "frozen", key)

    def show_kinds(self, kinds: tuple[RowKind, ...]) -> None:
        """Show only rows of these kinds, or all rows if there are none."""
        self._kinds = kinds
        self.show_items()

    @property
    def listed_rows(self) -> list[ObjectRow]:
        """Rows that the table shows."""
        return [row for row in self._object_list.rows if not self._kinds or row.kind in self._kinds]

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Set the class by a digit; leave Enter to the canvas while it accepts something."""
        digit = event.key() - Qt.Key.Key_0
        if event.key() in ENTER_KEYS and self._selection.can_accept:
            event.ignore()
        elif 1 <= digit <= len(self._object_list.objects.classes):
            self._commands.classify_selected(digit)
        else:
            super().keyPressEvent(event)

    def update_rows(self) -> None:
        """Show the rows with lengths in the unit of the image."""
        image = self._session.image
        spacing, unit = (image.spacing, image.unit) if image is not None else ((1.0, 1.0), None)
        self.rows.update_items(
            self.listed_rows,
            preferred_pixel_size(spacing, unit),
            build_object_columns(self._object_list.objects, spacing),
        )

    def _get_cell_look(self, row: ObjectRow, role: int, of_name: bool) -> Any:
        """Return the swatch next to a name; hidden rows are pale."""
        if role == Role.DecorationRole and of_name:
            proposed, objects = row.kind == "proposal", self._object_list.objects
            return create_swatch(theme.PROPOSAL_COLOR if proposed else objects.color_of(row.item))
        if role == Role.ForegroundRole and row.item.hidden:
            return QColor(QGuiApplication.palette().color(QPalette.ColorRole.PlaceholderText))
        return None


class ClassRow(QWidget):
    """Row of a class: its color with a menu, the digit that sets it, and its name."""

    def __init__(self, object_list: ObjectList, commands: ObjectCommands, number: int) -> None:
        super().__init__()
        self._object_list, self._commands, self._number = object_list, commands, number
        instant = QToolButton.ToolButtonPopupMode.InstantPopup
        self.color, self.digit = QToolButton(autoRaise=True, popupMode=instant), QToolButton()
        self.name = QLineEdit(frame=False)
        self.color.setToolTip(tr("Color of the class"))
        menu = QMenu(self.color)
        fill_colors(menu, self, lambda color: commands.name_class(number, self.name.text(), color))
        self.color.setMenu(menu)
        self.digit.setText(str(number))
        self.digit.setCheckable(True)
        self.digit.setToolTip(tr("Set the class of the selection and of the next objects ({number}).", number=number))
        self.digit.clicked.connect(partial(commands.classify_selected, number))
        self.name.setAccessibleName(tr("Name of class {number}", number=number))
        self.name.editingFinished.connect(self._on_name_edited)
        fill_layout(QHBoxLayout(self), self.color, self.digit, self.name, spacing=4, wide=self.name)

    def show_class(self) -> None:
        """Show the current color, digit and name."""
        objects = self._object_list.objects
        known = objects.classes[self._number - 1]
        self.color.setIcon(create_swatch(known.color))
        self.digit.setChecked(objects.category == self._number)
        self.name.setPlaceholderText(class_title(objects, self._number))
        if not self.name.isModified():
            self.name.setText(known.name)

    def _on_name_edited(self) -> None:
        if self.name.isModified():
            self.name.setModified(False)
            self._commands.name_class(self._number, self.name.text())


_ROW_FILTERS: tuple[tuple[str, tuple[RowKind, ...]], ...] = (
    (tr("All"), ()),
    (tr("Objects"), ("object",)),
    (tr("Proposals"), ("proposal",)),
)
"""Title and kinds of rows of each restriction of the table; no kinds stand for all."""

BUTTON_ACTIONS = ("shrink", "enlarge", "split", "merge_objects", "objects_alike", "freeze_object", "fill_between",
           "paint_in_space")  # fmt: skip
"""Actions that have a button wherever the action is available."""


_FIGURE_LINES = 2
"""Number of lines for which there is always room above the table, so that it does not move when a row is selected."""


class ObjectPanel(QWidget):
    """Figures of the selected row above the table."""

    def __init__(self, workspace: Workspace) -> None:
        super().__init__()
        self._workspace, self._session = workspace, workspace.session
        self._object_list, self._commands = workspace.object_list, workspace.object_commands
        self._object_brush = workspace.object_brush
        self.table = ObjectTable(workspace)
        self.setFocusProxy(self.table)
        self.figures = create_wrapped_label()
        self.figures.setToolTip(CONFIDENCE_TIP)
        self.figures.setMinimumHeight(_FIGURE_LINES * self.figures.fontMetrics().lineSpacing())
        self.classes: dict[int, ClassRow] = {}
        self._classes = QVBoxLayout()
        self._classes.setSpacing(0)
        self.buttons = {name: ActionButton(name) for name in BUTTON_ACTIONS}
        half, each = len(BUTTON_ACTIONS) // 2, [*self.buttons.values()]
        grid = [fill_layout(QHBoxLayout(), *row, spacing=4) for row in (each[:half], each[half:])]
        self.brush = DecimalField(*BRUSH_RADIUS_RANGE, suffix=" px")
        self.brush.setPrefix(tr("Brush") + " ")
        self.brush.setToolTip(tr("Radius of the brush; the keys [ and ] change it."))
        self.brush.setVisible(False)
        self.brush.valueChanged.connect(self._object_brush.set_radius)
        self._object_brush.changed.connect(self.brush.show_value)
        self.opacity = MarkedSlider(0.0, 1.0, 0.05, 1.0)
        self.opacity.setAccessibleName(tr("Opacity"))
        self.opacity.setToolTip(tr("Opacity of the selected objects: through a transparent one, others are visible."))
        self.opacity.moved_to.connect(self._commands.fade_selected)
        self.opacity.restored.connect(partial(self.opacity.move_to, 1.0))
        self.shown = QComboBox()
        self.shown.setAccessibleName(tr("Rows in the table"))
        self.shown.setToolTip(tr("Which rows the table shows."))
        self.shown.addItems([text for text, _ in _ROW_FILTERS])
        self.shown.currentIndexChanged.connect(lambda place: self.table.show_kinds(_ROW_FILTERS[place][1]))
        self.summary = create_wrapped_label(dim=True)
        row = fill_layout(QHBoxLayout(), self.summary, self.shown, spacing=6, wide=self.summary)
        fade = fill_layout(QHBoxLayout(), QLabel(tr("Opacity")), self.opacity, spacing=6, wide=self.opacity)
        fill_layout(QVBoxLayout(self), self.figures, self._classes, *grid, fade, self.brush,
                    row, self.table, margins=(2, 6, 2, 6), spacing=6, wide=self.table)  # fmt: skip
        self._update_timer = QTimer(
            self, singleShot=True, interval=0
        )  # deferred, so that several changes are shown at once
        self._update_timer.timeout.connect(self.show_selected)
        listed, selection = self._object_list, workspace.object_selection
        session_signals = self._session.image_changed, self._session.store.status_changed
        for changed in (listed.changed, listed.selection_changed, selection.changed, *session_signals):
            changed.connect(self._update_timer.start)
        self.show_selected()

    def show_selected(self) -> None:
        """Show the selected row, or else the only one to accept, the classes, and the number of rows."""
        if not self.isVisible():
            return
        row = self._shown_row
        self.figures.setText(self._describe_row(row) if row else "")
        self.brush.show_value(self._object_brush.radius)
        chosen = self._object_list.selected_objects
        self.opacity.setEnabled(bool(chosen))
        self.opacity.show_value(chosen[0].opacity if chosen else 1.0)
        self._show_classes()
        found = Counter(each.kind for each in self._object_list.rows)
        words: tuple[tuple[RowKind, str, str], ...] = (
            ("object", tr("1 object"), tr("{count} objects")), ("proposal", tr("1 proposal"), tr("{count} proposals")),
        )  # fmt: skip
        parts = [
            one if found[kind] == 1 else many.format(count=found[kind]) for kind, one, many in words if found[kind]
        ]
        self.summary.setText(", ".join(parts) or describe_lack(self._workspace))

    def showEvent(self, event: QShowEvent) -> None:
        """Show what changed while the panel was hidden."""
        super().showEvent(event)
        self.show_selected()

    def sizeHint(self) -> QSize:
        """Return a size as narrow as the other panels."""
        return QSize(330, 500)

    def _show_classes(self) -> None:
        listed = list_classes(self._object_list.objects)
        for number in [*self.classes]:
            if number not in listed:
                self.classes.pop(number).deleteLater()
        for place, number in enumerate(listed):
            if number not in self.classes:
                self.classes[number] = ClassRow(self._object_list, self._commands, number)
                self._classes.insertWidget(place, self.classes[number])
            self.classes[number].show_class()

    def _describe_row(self, row: ObjectRow) -> str:
        """Describe the class, area, length and confidence of a row; a line of the text breaks between these figures."""
        columns = {column.name: column for column in self.table.rows.columns}
        figures = [self.table.describe_cell(row, columns[name]) for name in ("area", "length")]
        if row.item.confidence:
            figures.append(tr("Confidence: {share}", share=columns["confidence"].format_cell(row, 1.0)))
        whole = (figure.replace(" ", "\u00a0") for figure in figures)
        return " · ".join(filter(None, (columns["class"].format_cell(row, 1.0), *whole)))

    @property
    def _shown_row(self) -> ObjectRow | None:
        """Selected row, or else the only one that Enter would accept of all that are offered; None for several."""
        listed = self._object_list
        selected = listed.selected_rows
        rows = selected or listed.pending_rows
        return rows[0] if len(rows) == 1 and (selected or rows == listed.rows_to_accept) else None
