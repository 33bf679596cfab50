"""The guide: pages that explain real tasks in a dialog beside the window."""

from __future__ import annotations

import html
import re
from collections.abc import Callable, Iterable

from PySide6.QtCore import QSize, Qt, QUrl
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QHBoxLayout, QListWidget, QTextBrowser, QVBoxLayout, QWidget

from app.model.parameters.controls import controls
from app.model.text.assets import asset
from app.model.text.keys import key_of
from app.model.text.language import tr
from app.views.help.guide_pages import PAGES, Page
from app.views.widgets.action_spec import ActionSpec
from app.views.widgets.key_text import native

_SIZE = QSize(780, 640)
_PICTURE = 300
"""Width of a picture [px]."""

_LABELS = {control.name: f"“{control.title}” ({control.rich_symbol})" for control in controls()}
"""Labels of parameters by their names."""

KEYS = "keys"
"""Name of the page that lists all keys."""


class Guide(QDialog):
    """Shows the pages beside the window; links open samples and other pages.

    `specs` are all actions, whose names and keys the pages mention; `open_sample` opens a sample by its file name.
    """

    def __init__(self, parent: QWidget, specs: Iterable[ActionSpec], open_sample: Callable[[str], None]) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(tr("Guide"))
        self._specs: dict[str, ActionSpec] = {}
        self._open_sample = open_sample
        self.contents = QListWidget()
        self.contents.setObjectName("contents")
        self.contents.setAccessibleName(tr("Pages"))
        self._names = [*(page.name for page in PAGES), KEYS]
        self.contents.addItems([*(page.title for page in PAGES), tr("All keys")])
        self.contents.setFixedWidth(self.contents.sizeHintForColumn(0) + 28)
        self.text = QTextBrowser()
        self.text.setOpenLinks(False)
        self.text.document().setDocumentMargin(14)
        self.text.anchorClicked.connect(self._follow)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.rejected.connect(self.close)
        beside = QHBoxLayout()
        beside.addWidget(self.contents)
        beside.addWidget(self.text, 1)
        layout = QVBoxLayout(self)
        layout.addLayout(beside, 1)
        layout.addWidget(buttons)
        self.contents.currentRowChanged.connect(self._turn)
        self.resize(_SIZE.boundedTo(self.screen().availableSize()))
        self.use_actions(specs)
        self.turn_to(self._names[0])

    @property
    def page(self) -> str:
        """Name of the page that is open."""
        return self._names[self.contents.currentRow()]

    def use_actions(self, specs: Iterable[ActionSpec]) -> None:
        """Name actions and their keys as they are now."""
        self._specs = {spec.name: spec for spec in specs}
        if self.contents.currentRow() >= 0:
            self._turn(self.contents.currentRow())

    def turn_to(self, name: str) -> None:
        """Open a page by its name."""
        self.contents.setCurrentRow(self._names.index(name))

    def _turn(self, row: int) -> None:
        name = self._names[row]
        page = next((page for page in PAGES if page.name == name), None)
        self.text.setHtml(self._keys() if page is None else self._written(page))

    def _follow(self, link: QUrl) -> None:
        if link.scheme() == "page":
            self.turn_to(link.path())
        elif link.scheme() == "sample":
            self._open_sample(link.path())

    def _written(self, page: Page) -> str:
        steps = "".join(f"<li>{self._named(step.text)}{_picture(step.picture)}</li>" for step in page.steps)
        remarks = "".join(f"<p>{self._named(remark)}</p>" for remark in page.remarks)
        numbered = f"<ol>{steps}</ol>" if steps else ""
        return f"<h2>{page.title}</h2><p>{self._named(page.opening)}</p>{numbered}{remarks}"

    def _named(self, text: str) -> str:
        """A text with actions in braces replaced by name and key, and parameters (``{=beta}``) by label and symbol."""
        text = re.sub(r"\{=(\w+)\}", lambda found: _LABELS[found.group(1)], text)
        text = re.sub(r"\{key:(\w+)\}", lambda found: html.escape(key_of(found.group(1))), text)
        return re.sub(r"\{(\w+)\}", lambda found: self._action(found.group(1)), text)

    def _action(self, name: str) -> str:
        spec = self._specs[name]
        words = html.escape(spec.title)
        keys = f" ({html.escape(native(spec.shortcuts[0]))})" if spec.shortcuts else ""
        return f"<b>{words}</b>{keys}"

    def _keys(self) -> str:
        cell = "<td style='padding: 2px 14px 2px 0'>"
        rows = [
            f"<tr>{cell}<b>{html.escape(tr(' or ').join(map(native, spec.shortcuts[:2])))}</b></td>"
            f"{cell}{html.escape(spec.said)}</td></tr>"
            for spec in self._specs.values()
            if spec.shortcuts
        ]
        return f"<h2>{tr('All keys')}</h2><table>{''.join(rows)}</table>"


def _picture(file: str) -> str:
    if not file:
        return ""
    address = QUrl.fromLocalFile(str(asset(f"guide/{file}"))).toString()
    return f"<br><img src='{address}' width='{_PICTURE}'><br>"
