"""The about dialog: what the program is, and the versions that a report of an error should give."""

from __future__ import annotations

import html

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QDialog, QDialogButtonBox, QGridLayout, QLabel, QWidget

from app.model.text.about import LICENSE, PAPER, PURPOSE, about_in_words, versions
from app.model.text.language import tr
from app.views.theme.icons import program_icon
from cpm_core.formats.provenance import VERSION

_ICON, _WIDTH = 64, 460
"""Size of the icon, and width of the text beside it [px]."""


class About(QDialog):
    """Shows what the program is, and copies it."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(tr("About CPM"))
        picture, self.text = QLabel(), QLabel(_rich())
        picture.setPixmap(program_icon().pixmap(_ICON, _ICON))
        self.text.setTextFormat(Qt.TextFormat.RichText)
        self.text.setWordWrap(True)
        self.text.setFixedWidth(_WIDTH)
        self.text.setTextInteractionFlags(
            Qt.TextInteractionFlag.TextSelectableByMouse | Qt.TextInteractionFlag.TextSelectableByKeyboard
        )
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        self.copy = buttons.addButton(tr("&Copy this text"), QDialogButtonBox.ButtonRole.ActionRole)
        self.copy.setToolTip(tr("Copy it to the clipboard, as for a report of an error."))
        self.copy.clicked.connect(lambda: QApplication.clipboard().setText(about_in_words()))
        buttons.rejected.connect(self.reject)
        layout = QGridLayout(self)
        layout.setHorizontalSpacing(16)
        layout.addWidget(picture, 0, 0, Qt.AlignmentFlag.AlignTop)
        layout.addWidget(self.text, 0, 1)
        layout.addWidget(buttons, 1, 0, 1, 2)
        layout.setSizeConstraint(QGridLayout.SizeConstraint.SetFixedSize)


def _rich() -> str:
    rows = "".join(
        f"<tr><td>{html.escape(name)}</td><td style='padding-left: 12px'>{html.escape(version)}</td></tr>"
        for name, version in versions()[1:]
    )
    told = "".join(f"<p>{html.escape(text)}</p>" for text in (PURPOSE, PAPER, LICENSE))
    return f"<h3>CPM {html.escape(VERSION)}</h3>{told}<table>{rows}</table>"
