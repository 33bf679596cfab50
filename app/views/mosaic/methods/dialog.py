"""The window of the comparison."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

from PySide6.QtCore import QSize, Qt, QTimer
from PySide6.QtWidgets import (
    QCheckBox,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from app.model.display.display_image import DisplayImage
from app.model.document.objects import add_region
from app.model.text.language import from_core, tr
from app.model.text.reasons import reason
from app.session.features.side_by_side.method_comparison import MethodComparison
from app.session.features.side_by_side.method_run import Frame
from app.session.session import Session
from app.views.mosaic.methods.pane import Pane
from app.views.mosaic.methods.side import Legend, Side
from app.views.mosaic.methods.transport import Transport
from app.views.mosaic.run_dialog import RunDialog
from cpm_core.contours.ground_truth import Truth
from cpm_core.objects.methods import CONTOUR_METHODS, PLACES, Compared, Settings
from cpm_core.shapes.outlines import outlines_of

_PATIENCE = 300
"""Time after the last change of a parameter until its method runs again [ms]."""


class CompareDialog(RunDialog):
    """Up to four methods side by side, each running; `ask` asks for the file of an export.

    Methods and settings are part of the document: they are saved with it, and changing them can be undone.
    """

    def __init__(
        self,
        parent: QWidget,
        session: Session,
        comparison: MethodComparison,
        display: DisplayImage,
        ask: Callable[[QWidget], Path | None],
    ) -> None:
        super().__init__(parent, tr("Compare methods"))
        self.setWindowFlag(Qt.WindowType.WindowMaximizeButtonHint)  # to be shown to many on a wall
        self._session, self._comparison, self._ask = session, comparison, ask
        self._focus = 0
        self._truth: Truth | None = None
        self.panes = [Pane(number + 1) for number in range(PLACES)]
        self.side, self.legend = Side(), Legend()
        self.form = self.side.form
        self.transport = Transport()
        self.around = QCheckBox(tr("The start lies around the object"))
        self.around.setToolTip(tr("Balloons and pressures then drive contours inwards."))
        self.keep_button, self.export_button = QPushButton(tr("Keep as object")), QPushButton(tr("Export…"))
        self.keep_button.setToolTip(
            tr("Add what the method with the frame has found to the objects of the window, to be saved and exported.")
        )
        self.export_button.setToolTip(
            tr("Write the figures as a table, a picture of the methods side by side, or the contours of each method.")
        )
        self.words = QLabel()
        self._later = QTimer(self)
        self._later.setSingleShot(True)
        self._later.setInterval(_PATIENCE)
        self._lay_out()
        for pane in self.panes:
            pane.show_image(display)
        for pane in self.panes[1:]:
            pane.link(self.panes[0])
        self._follow()
        self._show_truth()
        self._connect()
        self.look_at(0)
        self._refresh()
        self.resize(QSize(1180, 860).boundedTo(self.screen().availableSize() - QSize(40, 60)))

    def run(self) -> None:
        """Run all chosen methods from the beginning."""
        self._attempt(self._comparison.run_all)

    def look_at(self, place: int) -> None:
        """Show the parameters of the method in a place."""
        self._focus = place
        for number, pane in enumerate(self.panes):
            pane.mark(number == place)
        self.side.show_method(self.panes[place].method, self._compared)
        self._refresh()

    def end_runs(self) -> None:
        """End all runs."""
        self._later.stop()
        self._comparison.cancel()

    # Internal

    @property
    def _compared(self) -> Compared:
        return self._session.document.comparison

    def _lay_out(self) -> None:
        grid = QGridLayout()
        for place, pane in enumerate(self.panes):
            grid.addWidget(pane, place // 2, place % 2)
            grid.setColumnStretch(place % 2, 1)
        upper = QHBoxLayout()
        upper.addLayout(grid, 1)
        upper.addWidget(self.side)
        foot = QHBoxLayout()
        foot.addWidget(self.around)
        foot.addWidget(self.legend)
        self.words.setWordWrap(True)
        foot.addWidget(self.words, 1)
        for button in (self.keep_button, self.export_button):
            button.setAutoDefault(False)
            foot.addWidget(button)
        layout = QVBoxLayout(self)
        layout.addLayout(upper, 1)
        layout.addWidget(self.transport)
        layout.addLayout(foot)

    def _connect(self) -> None:
        for place, pane in enumerate(self.panes):
            pane.focused.connect(partial(self.look_at, place))
            pane.chosen.connect(partial(self._choose, place))
        self.form.changed.connect(self._set)
        self.around.toggled.connect(lambda on: self._change(lambda compared: replace(compared, around=on)))
        transport, comparison = self.transport, self._comparison
        transport.run_button.clicked.connect(self.run)
        transport.pause_button.clicked.connect(lambda: comparison.go_on() if comparison.held else comparison.hold())
        transport.step_button.clicked.connect(lambda: self._attempt(comparison.step))
        transport.stop_button.clicked.connect(comparison.cancel)
        transport.looked.connect(self._draw_all)
        self.keep_button.clicked.connect(self._keep)
        self.export_button.clicked.connect(self._export)
        self._later.timeout.connect(self._run_focused)
        comparison.advanced.connect(self._draw)
        comparison.changed.connect(self._refresh)
        self._session.document_changed.connect(self._follow)
        self._session.image_changed.connect(self.close)
        self._session.scene_changed.connect(self._show_truth)

    def _change(self, change: Callable[[Compared], Compared], gesture: str = "") -> None:
        self._session.edit(
            tr("compare methods"),
            lambda document: replace(document, comparison=change(document.comparison)),
            gesture,
        )

    def _choose(self, place: int) -> None:
        self._change(lambda compared: compared.with_method(place, self.panes[place].method))
        self.look_at(place)

    def _set(self, settings: Settings) -> None:
        name = self.panes[self._focus].method
        self._change(lambda compared: compared.with_settings(name, settings), f"settings of {name}")
        self._later.start()

    def _follow(self) -> None:
        """Show methods, settings and start of the document; a method that another has replaced runs no more."""
        document = self._session.document
        self.around.blockSignals(True)
        self.around.setChecked(document.comparison.around)
        self.around.blockSignals(False)
        for place, (pane, name) in enumerate(zip(self.panes, document.comparison.methods, strict=True)):
            frame = self._comparison.frames[place]
            if pane.method != name:
                pane.choose(name)
            if frame is not None and frame.method != name:
                self._comparison.clear(place)
            pane.show_start(outlines_of(document.shapes))
        self.look_at(self._focus)

    def _show_truth(self) -> None:
        truth = self._comparison.truth
        if truth is not self._truth:
            self._truth = truth
            self.legend.show_truth(truth is not None)
            for pane in self.panes:
                pane.show_truth(truth)

    def _run_focused(self) -> None:
        """Run the method again whose parameters have changed."""
        self._session.seal()
        if self._comparison.frames[self._focus] is not None:
            self._attempt(partial(self._comparison.run, self._focus))

    def _attempt(self, work: Callable[[], object]) -> None:
        """Do something and look at its newest states, or say why it cannot be done."""
        try:
            work()
        except ValueError as error:
            self.words.setText(reason(error))
        else:
            self.words.setText(self._comparison.left_out)
            self.transport.follow()

    def _draw(self, place: int) -> None:
        share, frame = self.transport.share, self._comparison.frames[place]
        self.panes[place].show_frame(frame if share == 1.0 else self._comparison.histories[place].at(share))

    def _draw_all(self) -> None:
        for place in range(PLACES):
            self._draw(place)

    def _found(self) -> list[Frame]:
        return [frame for frame in self._comparison.frames if frame is not None and frame.over and frame.facts]

    def _refresh(self) -> None:
        running = self._comparison.running
        self.transport.show_state(running=running, held=self._comparison.held)
        self.export_button.setEnabled(not running and bool(self._found()))
        self.keep_button.setEnabled(self._comparison.frames[self._focus] in self._found())

    def _keep(self) -> None:
        frame = self._comparison.frames[self._focus]
        if frame is not None:
            title = from_core(CONTOUR_METHODS[frame.method].title)
            self._session.edit(tr("keep what {method} has found").format(method=title),
                               lambda document: add_region(document, frame.contours, title))  # fmt: skip
            self.words.setText(tr("{method} is an object of the window now.").format(method=title))

    def _export(self) -> None:
        path = self._ask(self)
        if path is not None:
            self._comparison.write((path,))
