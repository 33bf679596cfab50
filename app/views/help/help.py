"""The about box."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QMessageBox, QWidget

from app.model.text.language import tr
from app.views.theme.icons import program_icon


def show_about(parent: QWidget) -> QMessageBox:
    """Open the about box."""
    box = QMessageBox(parent)
    box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    box.setWindowTitle(tr("About CPM"))
    box.setIconPixmap(program_icon().pixmap(64, 64))
    box.setTextFormat(Qt.TextFormat.RichText)
    box.setText(
        tr(
            "<h3>CPM</h3><p>Finds contours in images by letting charged particles flow to them.</p>"
            "<p>The model: A. C. Jalba, M. H. F. Wilkinson and J. B. T. M. Roerdink, “CPM: A deformable model for "
            "shape recovery and segmentation based on charged particles”, IEEE Transactions on Pattern Analysis and "
            "Machine Intelligence 26 (10), 2004.</p><p>Free software under the MIT licence.</p>"
        )
    )
    box.open()
    return box
