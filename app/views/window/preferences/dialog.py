"""The preferences dialog: a list of pages on the left, the fields of one of them on the right."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QFrame,
    QHBoxLayout,
    QLabel,
    QListWidget,
    QPushButton,
    QScrollArea,
    QSizePolicy,
    QStackedWidget,
    QVBoxLayout,
    QWidget,
)

from app.model.preferences.table import PAGES, PREFERENCES
from app.model.text.language import tr
from app.session.storage.preferences import Preferences
from app.views.widgets.preference_row import PreferenceRow
from app.views.window.preferences.fields import Field, field_for
from app.views.window.preferences.shortcuts import ShortcutsPage

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
