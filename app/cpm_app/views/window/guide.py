"""Guide: pages of ``assets/guide`` that explain real tasks, in a dialog next to the window."""

from __future__ import annotations

import html
import re
from collections.abc import Callable

from PySide6.QtCore import QSize, Qt, QUrl
from PySide6.QtGui import QKeySequence, QShortcut
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QHBoxLayout,
    QTextBrowser,
    QVBoxLayout,
    QWidget,
)

from cpm_app.model.parameters.controls import build_controls
from cpm_app.model.text.assets import find_asset, read_guide_page
from cpm_app.model.text.keys import key_or_title
from cpm_app.model.text.language import tr, translate_core_text
from cpm_app.model.text.wording import format_symbol
from cpm_app.views.widgets.actions import native_key_text
from cpm_app.views.widgets.containers import PageList, fill_layout
from cpm_app.views.window.shortcuts import Shortcuts

KEYS_PAGE = "keys"
"""Name of the page that lists all keys, and of the action that opens and closes it."""

GUIDE_PAGES = ("first", "artery", "nuclei", "hand", "vessels", "stacks", "further", "canvas", KEYS_PAGE)
"""Names of the pages, in the order of the table of contents."""

_GUIDE_SIZE = QSize(780, 640)
"""Preferred size of the dialog [px]."""

_GUIDE_PICTURE_WIDTH = 300
"""Width of a picture [px]."""

_PARAMETER_LABELS = {
    control.name: f"“{control.title}” ({format_symbol(control.symbol)})" for control in build_controls()
}
"""Labels of parameters by their names."""


class Guide(QDialog):
    """Dialog with the pages; links open samples and other pages.

    The pages mention names and keys of the actions of `shortcuts`; `open_sample` opens a sample by its file name.
    """

    def __init__(self, parent: QWidget, shortcuts: Shortcuts, open_sample: Callable[[str], None]) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(tr("Guide"))
        self._shortcuts = shortcuts
        self._open_sample = open_sample
        for key in shortcuts.find_keys(KEYS_PAGE):
            QShortcut(QKeySequence(key), self, self.close)
        self.contents = PageList(
            tr("Pages"), [translate_core_text(read_guide_page(name)[0].text) for name in GUIDE_PAGES]
        )
        self.text = QTextBrowser(openLinks=False)
        self.text.document().setDocumentMargin(14)
        self.text.anchorClicked.connect(self._on_link_clicked)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.rejected.connect(self.close)
        columns = fill_layout(QHBoxLayout(), self.contents, self.text, wide=self.text)
        layout = QVBoxLayout(self)
        layout.addLayout(columns, 1)
        layout.addWidget(buttons)
        self.contents.currentRowChanged.connect(self._show_page)
        shortcuts.changed.connect(self._show_page)
        self.resize(_GUIDE_SIZE.boundedTo(self.screen().availableSize()))
        self.turn_to(GUIDE_PAGES[0])

    @property
    def page(self) -> str:
        """Name of the open page."""
        return GUIDE_PAGES[self.contents.currentRow()]

    def turn_to(self, name: str) -> None:
        """Open a page by its name."""
        self.contents.setCurrentRow(GUIDE_PAGES.index(name))

    def _show_page(self, _: int = 0) -> None:
        parts = []
        for mark, text, picture in read_guide_page(self.page):
            tag = {"# ": "h2", "1. ": "li", "": "p"}[mark]
            address = QUrl.fromLocalFile(str(find_asset(f"guide/{picture}"))).toString() if picture else ""
            image = f"<br><img src='{address}' width='{_GUIDE_PICTURE_WIDTH}'><br>" if picture else ""
            parts.append(f"<{tag}>{self._replace_names(translate_core_text(text))}{image}</{tag}>")
        whole = re.sub(r"((?:<li>.*?</li>)+)", r"<ol>\1</ol>", "".join(parts), flags=re.DOTALL)
        self.text.setHtml(whole + (self._format_keys() if self.page == KEYS_PAGE else ""))

    def _on_link_clicked(self, link: QUrl) -> None:
        if link.scheme() == "page":
            self.turn_to(link.path())
        elif link.scheme() == "sample":
            self._open_sample(link.path())

    def _replace_names(self, text: str) -> str:
        """Replace actions in braces by name and key, and parameters (``{=beta}``) by label and symbol."""
        text = re.sub(r"\{=(\w+)\}", lambda found: _PARAMETER_LABELS[found.group(1)], text)
        text = re.sub(r"\{key:(\w+)\}", lambda found: html.escape(key_or_title(found.group(1))), text)
        actions = self._shortcuts.describe_actions()

        def format_action(found: re.Match[str]) -> str:
            action = actions[found.group(1)]
            key = f" ({html.escape(action.key)})" if action.key else ""
            return f"<b>{html.escape(action.title)}</b>{key}"

        return re.sub(r"\{(\w+)\}", format_action, text)

    def _format_keys(self) -> str:
        """Format the keys of all actions and panels by group, as HTML."""
        groups: dict[str, str] = {}
        for action in self._shortcuts.actions:
            keys = self._shortcuts.find_keys(action.name)
            if keys:
                cells = f"<b>{html.escape('  '.join(map(native_key_text, keys[:2])))}</b>", html.escape(action.title)
                row = "".join(f"<td style='padding: 2px 14px 2px 0'>{cell}</td>" for cell in cells)
                groups[action.group] = f"{groups.get(action.group, '')}<tr>{row}</tr>"
        return "".join(f"<h3>{title}</h3><table>{rows}</table>" for title, rows in groups.items())
