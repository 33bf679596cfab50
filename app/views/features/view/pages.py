"""The pages of a stack, each an image of its own: going through them, running all, and what was found on all."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from app.model.preferences.table import UNIT
from app.model.state.situation import Situation
from app.model.text.language import tr
from app.session.features.pages.stack_pages import WantedContour
from app.session.storage.session_file import DocumentFile
from app.views.panels.pages.page_bar import PageBar
from app.views.panels.pages.panel import PagePanel
from app.views.widgets.action_spec import STATE, ActionSpec
from app.views.window.feature import Feature, FeatureContext, Panel
from app.views.window.file_dialogs import Files
from cpm_core.formats.contours.pages.files import FOR_STACKS, stack_suffix_of

_MENU = "Run>" + tr("Pages of a &stack")


class PagesFeature(Feature):
    """The line that chooses a page, the actions for all pages, and their table."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self._pages = pages = context.workspace.pages
        self.bar = PageBar()
        self.panel = PagePanel(pages, WantedContour(pages, context.workspace.review).show)
        self.bar.moved.connect(pages.open)
        self.bar.asked.connect(self._run_or_stop)
        self.bar.followed.connect(self._follow)
        self.panel.export.clicked.connect(self.export)
        context.canvas_area.controls.addWidget(self.bar)
        pages.changed.connect(self._show)
        pages.found.connect(context.refresh)
        context.session.document_changed.connect(lambda _: self._show_bar())
        context.preferences.follow(UNIT, self.panel.show_rows)

    def keep(self, document_file: DocumentFile) -> None:
        """Save the pages with the session file."""
        self._pages.keep(document_file)

    def action_specs(self) -> Sequence[ActionSpec]:
        """Run all pages, or those from this one on; follow; export."""
        pages = self._pages
        return (
            ActionSpec(name="run_pages", menu=_MENU, text=tr("&Run all pages"), do=pages.run,
                       shortcuts=("Ctrl+Shift+Return",), when=self._can_run,
                       tip=tr("Run every page of the stack, one after the other, in the background.")),
            ActionSpec(name="run_pages_on", menu=_MENU, text=tr("Run from this page &on"),
                       do=lambda: pages.run(pages.number), when=self._can_run,
                       tip=tr("Run this page and all after it, one after the other, in the background.")),
            ActionSpec(name="follow_pages", menu=_MENU, text=tr("&Follow from page to page"), group=STATE, gap=True,
                       do=lambda: self._follow(not pages.following), when=lambda _: pages.count > 1,
                       holds=lambda _: pages.following,
                       tip=tr("Start each page from the contours of the one before.")),
            ActionSpec(name="export_pages", menu="File", text=tr("Export all pa&ges…"), do=self.export,
                       tip=tr("Write the contours, labels or measures of all pages that are done."),
                       when=lambda _: pages.result is not None and bool(pages.result.results)),
        )  # fmt: skip

    def panels(self) -> Sequence[Panel]:
        """The table of all pages."""
        return (
            Panel(name="pages", title=tr("Pages"), widget=self.panel, area="bottom", tab="below", shown=False,
                  height=250, shortcut="Shift+F11"),
        )  # fmt: skip

    def use_keys(self) -> None:
        """Name the keys as they are now."""
        self.bar.show_keys()

    def export(self) -> None:
        """Ask where to write what was found on all pages, and write it."""
        found = self._pages.result
        if found is None:
            return
        kinds = [
            Files(text[:1].upper() + text[1:], (suffix,)) for suffix, text in FOR_STACKS.items() if suffix != ".tiff"
        ]
        name = f"{Path(found.source).stem}_pages.measures.csv"
        path = self.context.files.ask_where_to_save("export", tr("Export all pages"), name, kinds)
        if path is not None and stack_suffix_of(path):
            self._pages.export(path)

    # Internal

    def _can_run(self, situation: Situation) -> bool:
        pages = self._pages
        return pages.count > 1 and not pages.running and situation.document.mode != "skeleton"

    def _run_or_stop(self) -> None:
        if self._pages.running:
            self._pages.cancel()
        else:
            self._pages.run()

    def _follow(self, following: bool) -> None:
        self._pages.following = following
        self._show()

    def _show(self) -> None:
        self._show_bar()
        self.context.refresh()

    def _show_bar(self) -> None:
        pages, session = self._pages, self.context.session
        possible = session.document.mode != "skeleton" and bool(session.document.starts)
        self.bar.show_pages(
            pages.number, pages.count, following=pages.following, running=pages.running, possible=possible
        )
