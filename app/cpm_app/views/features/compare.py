"""Comparison of results: its panel, and the divider on the canvas."""

from __future__ import annotations

from cpm_app.model.display.differences import Difference
from cpm_app.model.state.situation import has_image
from cpm_app.model.text.language import tr
from cpm_app.session.exchange.messages import FilesExported, Report
from cpm_app.session.features.comparison import CURRENT_KEY, TRUTH_KEY
from cpm_app.session.tasks.tasks import BackgroundTask
from cpm_app.views.comparison.divider import Wipe
from cpm_app.views.comparison.panel import ComparePanel
from cpm_app.views.features.animation import start_writing_task
from cpm_app.views.widgets.actions import ActionSpec
from cpm_app.views.window.dialogs import ALL_FILES, FileKind
from cpm_app.views.window.docks import Panel
from cpm_app.views.window.window import Feature
from cpm_core.formats import CONTOURS_READABLE, IMAGES_READABLE, SURFACES_READABLE, TABLE_SUFFIX, write_together
from cpm_core.formats.common.printable import escape_cell
from cpm_core.formats.contours.contour_csv import encode_csv_rows

_MIN_DIFFERENCE_SPAN = 48.0
"""Smallest side of the region shown around a difference [px]."""


class CompareFeature(Feature):
    """Comparison of runs and a ground truth."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        window = self.window
        self._compared = compared = window.workspace.comparison

        def export_table() -> None:
            kinds = {TABLE_SUFFIX: tr("Table of all results")}
            path = window.files.ask_where_to_export(tr("Export the comparison"), ".compared.csv", kinds)
            if path is not None:
                rows: list[dict[str, object]] = [
                    {**row, "name": escape_cell(str(row["name"]))} for row in self.panel.result_records
                ]

                def write_table(_: BackgroundTask) -> Report:
                    write_together([(path, encode_csv_rows(rows))])
                    return FilesExported(path)

                start_writing_task(self.session, path, write_table)

        self.panel = ComparePanel(
            self.session,
            compared,
            self._ask_for_truth,
            export_table,
            self._show_difference,
        )
        self.panels = (Panel("compare", "Compare", self.panel, "F12", shown_at_start=False),)
        self.panel.table.zoom_wanted.connect(self.panel.jump_to_next)
        self.wipe = Wipe(self.canvas)
        self.wipe.ended.connect(lambda: compared.select_row(CURRENT_KEY))
        compared.selection_changed.connect(self._show_divider)
        compared.changed.connect(window.refresh_actions)
        compared.changed.connect(self._show_tab_of_truth)
        self.session.store.drawing_wanted.connect(self._draw_right_side)
        self.actions = (
            ActionSpec("compare", "Run", "Com&pare…",
                       "Compare what is shown with other runs or a ground truth.",
                       lambda: window.docks.enter_panel("compare"), "Ctrl+D", gap=True, when=has_image),
            ActionSpec("next_difference", ">" + tr("Compare"), "Show next &difference",
                       "Show the differences from the reference one after the other, the largest first.",
                       self.panel.jump_to_next, "Shift+W", when=lambda _: bool(self.session.scene.differences)),
        )  # fmt: skip

    def _show_tab_of_truth(self) -> None:
        """Add the tab once there is a ground truth, such as that of a session, without bringing it to the front."""
        if TRUTH_KEY in self._compared.rows:
            self.window.docks.set_tab_available("compare", True)

    def _show_divider(self) -> None:
        if self._compared.selected == CURRENT_KEY:
            self.wipe.end_comparison()
        else:
            rows = self._compared.rows
            self.wipe.start_comparison(rows[CURRENT_KEY].title, rows[self._compared.selected].title)
            self._draw_right_side()

    def _draw_right_side(self) -> None:
        if self._compared.selected != CURRENT_KEY:
            self.wipe.draw_right_scene(self._compared.scene_beyond_divider())

    def _ask_for_truth(self) -> None:
        kinds = (
            (FileKind(tr("Label volumes and surfaces"), (*IMAGES_READABLE, *SURFACES_READABLE)), ALL_FILES)
            if self._compared.in_volume
            else (
                FileKind(tr("Masks and contours"), tuple(dict.fromkeys((*IMAGES_READABLE, *CONTOURS_READABLE)))),
                FileKind(tr("Masks"), tuple(IMAGES_READABLE)),
                FileKind(tr("Contours"), tuple(CONTOURS_READABLE)),
                ALL_FILES,
            )
        )
        chosen = self.window.files.ask_for_file("truth", tr("Compare with ground truth"), kinds)
        if chosen is not None:
            self._compared.load_truth_file(str(chosen))

    def _show_difference(self, difference: Difference) -> None:
        slices = self.window.workspace.slices
        slices.go_through(difference.place)
        points = (
            difference.points if slices.current is None else slices.current.current.project_points(difference.points)
        )
        low, high = points.min(axis=0), points.max(axis=0)
        span = max(_MIN_DIFFERENCE_SPAN, 1.4 * float((high - low).max()))
        row, col = (0.5 * (low + high)).tolist()
        if slices.current is not None:
            row, col = slices.current.current.drop_axis(difference.place)
        self.canvas.look_at((row, col), span)
