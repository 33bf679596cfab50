"""The short help and the about box."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QMessageBox, QTextBrowser, QVBoxLayout, QWidget

from app.views.entry import Entry
from app.views.icons import program_icon

_TOUR = """
<h3>In one minute</h3>
<ol>
<li><b>Draw</b> where to start: drag a circle in or around an object, draw a stroke, or place points; or
start everywhere, on strong edges or at centres without drawing (menu Draw).</li>
<li><b>Limit</b> the particles where need be: they stay in a region of interest and do not cross a barrier.</li>
<li><b>Run</b> (Space). Particles are pulled to edges and push each other along them, into every bay, until they
rest.</li>
<li><b>Steer</b> while it runs: each slider acts at the very next step.</li>
<li><b>Export</b> the contours as drawing (SVG), table (CSV) or label mask (PNG).</li>
</ol>
<h3>On the canvas</h3>
<p>Left button: the tool. Middle or right button: pan. Wheel: zoom around the pointer.
Arrow keys move the selected shape by a pixel, with Shift by ten; &lt; and &gt; make a selected circle smaller and
larger.</p>
<p>Strokes, regions of interest and barriers are drawn freehand with a drag, or corner by corner with clicks; Enter or
a double click ends them, Backspace takes the last corner back, Esc gives up.</p>
<p>A changed drawing acts from the next start: press Reset while the particles run; otherwise Run starts anew by
itself. Changed parameters act at once; a run that has come to rest goes on with them after Resume.</p>
"""

_ABOUT = """<h3>CPM</h3>
<p>Finds contours in images by letting charged particles flow to them.</p>
<p>The model: A. C. Jalba, M. H. F. Wilkinson and J. B. T. M. Roerdink, “CPM: A deformable model for shape recovery and
segmentation based on charged particles”, IEEE Transactions on Pattern Analysis and Machine Intelligence 26 (10),
2004.</p>
<p>Free software under the MIT licence.</p>"""


def show_help(parent: QWidget, entries: Iterable[Entry]) -> QDialog:
    """Open the short help beside the window."""
    dialog = QDialog(parent)
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    dialog.setWindowTitle("CPM – short help")
    text = QTextBrowser()
    text.setHtml(_TOUR + _keys(entries))
    buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
    buttons.rejected.connect(dialog.close)
    layout = QVBoxLayout(dialog)
    layout.addWidget(text)
    layout.addWidget(buttons)
    dialog.resize(560, 640)
    dialog.show()
    return dialog


def show_about(parent: QWidget) -> QMessageBox:
    """Open the about box."""
    box = QMessageBox(parent)
    box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    box.setWindowTitle("About CPM")
    box.setIconPixmap(program_icon().pixmap(64, 64))
    box.setTextFormat(Qt.TextFormat.RichText)
    box.setText(_ABOUT)
    box.open()
    return box


def _keys(entries: Iterable[Entry]) -> str:
    cell = "<td style='padding-left: 14px'>"
    rows = [
        f"<tr><td><b>{' or '.join(entry.shortcuts[:2])}</b></td>{cell}{entry.tip}</td></tr>"
        for entry in entries
        if entry.shortcuts
    ]
    return f"<h3>Keys</h3><table cellspacing='3'>{''.join(rows)}</table>"
