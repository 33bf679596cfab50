"""The preferences dialog, filled by the features."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtWidgets import QDialog, QDialogButtonBox, QFormLayout, QLabel, QScrollArea, QVBoxLayout, QWidget

from app.model.text.language import tr
from app.views.widgets.preference_row import PreferenceRow

_WIDTH, _HIGHEST = 500, 560


class PreferencesDialog(QDialog):
    """Sections of rows; changes take effect immediately."""

    def __init__(self, parent: QWidget, rows: Iterable[PreferenceRow]) -> None:
        super().__init__(parent)
        self.setWindowTitle(tr("Preferences"))
        self.rows: dict[str, QWidget] = {}
        content = QWidget()
        content.setObjectName("scrolled")
        form = QFormLayout(content)
        form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.FieldsStayAtSizeHint)
        form.setVerticalSpacing(8)
        sections: dict[str, list[PreferenceRow]] = {}
        for row in rows:
            sections.setdefault(row.section, []).append(row)
        for title, section in sections.items():
            heading = QLabel(title)
            heading.setObjectName("heading")
            form.addRow(heading)
            for row in section:
                self._add(form, row)
        scroll = QScrollArea()
        scroll.setWidget(content)
        scroll.setWidgetResizable(True)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.rejected.connect(self.reject)
        layout = QVBoxLayout(self)
        layout.addWidget(scroll, 1)
        layout.addWidget(buttons)
        margins = layout.contentsMargins()
        content.setFixedWidth(_WIDTH - margins.left() - margins.right() - 12)
        height = content.heightForWidth(content.width()) if content.hasHeightForWidth() else content.sizeHint().height()
        self.resize(_WIDTH, min(height + buttons.sizeHint().height() + 40, _HIGHEST))

    def _add(self, form: QFormLayout, row: PreferenceRow) -> None:
        widget = row.make()
        if row.label:
            widget.setAccessibleName(widget.accessibleName() or row.label)
            form.addRow(row.label, widget)
        else:
            form.addRow(widget)
        self.rows[row.label] = widget
        if row.note:
            note = QLabel(row.note)
            note.setObjectName("dim")
            note.setWordWrap(True)
            widget.setAccessibleDescription(row.note)
            form.addRow("", note)
