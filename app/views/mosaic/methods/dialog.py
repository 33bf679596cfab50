"""The window of the comparison."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from PySide6.QtCore import QSize, Qt, QTimer
from PySide6.QtWidgets import (
    QCheckBox,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QScrollArea,
    QVBoxLayout,
    QWidget,
)

from app.model.display.display_image import DisplayImage
from app.model.text.language import from_core, tr
from app.model.text.reasons import reason
from app.session.features.side_by_side.method_comparison import PLACES, MethodComparison
from app.session.session import Session
from app.views.mosaic.methods.pane import Pane
from app.views.mosaic.methods.settings_form import SettingsForm
from app.views.mosaic.run_dialog import RunDialog
from cpm_core.segmentation.methods import CONTOUR_METHODS
from cpm_core.shapes.outlines import outlines_of

FIRST = ("cpm", "gvf", "gac", "chan_vese")
"""The methods that are chosen at first."""

_PATIENCE = 300
"""Time after the last change of a parameter until its method runs again [ms]."""

_SIDE = 260


class CompareDialog(RunDialog):
    """Up to four methods side by side, each running; `ask` asks for the file of an export."""

    def __init__(
        self,
        parent: QWidget,
        session: Session,
        comparison: MethodComparison,
        display: DisplayImage,
        ask: Callable[[QWidget], Path | None],
    ) -> None:
        super().__init__(parent, tr("Compare methods"))
        self._session, self._comparison, self._ask = session, comparison, ask
        self._settings: dict[str, Any] = {}
        self._focus = 0
        self.panes = [Pane(number + 1) for number in range(PLACES)]
        self.form = SettingsForm()
        self.heading = QLabel()
        self.around = QCheckBox(tr("The start lies around the object"))
        self.around.setToolTip(tr("Balloons and pressures then drive contours inwards."))
        self.run_button, self.stop_button = QPushButton(tr("Run")), QPushButton(tr("Stop"))
        self.export_button = QPushButton(tr("Export…"))
        self.export_button.setToolTip(tr("Write the figures as a table, or a picture of the methods side by side."))
        self.words = QLabel()
        self._later = QTimer(self)
        self._later.setSingleShot(True)
        self._later.setInterval(_PATIENCE)
        self._lay_out()
        for pane, name in zip(self.panes, FIRST, strict=True):
            pane.choose(name)
            pane.show_image(display, outlines_of(session.document.shapes))
        for pane in self.panes[1:]:
            pane.link(self.panes[0])
        self._connect()
        self.look_at(0)
        self._refresh()
        self.resize(QSize(1180, 860).boundedTo(self.screen().availableSize() - QSize(40, 60)))

    def run(self) -> None:
        """Run all chosen methods from the beginning."""
        self._comparison.around = self.around.isChecked()
        try:
            for place, pane in enumerate(self.panes):
                if pane.method:
                    self._comparison.run(place, pane.method, self._settings_of(pane.method))
                else:
                    self._comparison.clear(place)
        except ValueError as error:
            self.words.setText(reason(error))
        else:
            self.words.setText("")

    def look_at(self, place: int) -> None:
        """Show the parameters of the method in a place."""
        self._focus = place
        for number, pane in enumerate(self.panes):
            pane.mark(number == place)
        name = self.panes[place].method
        self.heading.setText(from_core(CONTOUR_METHODS[name].title) if name else "")
        ours = tr("These are the parameters of the window: change them there and run again.")
        self.form.show_settings(None if name in ("", "cpm") else self._settings_of(name), ours if name else "")

    def end_runs(self) -> None:
        """End all runs."""
        self._later.stop()
        self._comparison.cancel()

    # Internal

    def _lay_out(self) -> None:
        grid = QGridLayout()
        for place, pane in enumerate(self.panes):
            grid.addWidget(pane, place // 2, place % 2)
        area = QScrollArea()
        area.setWidgetResizable(True)
        area.setWidget(self.form)
        area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        area.setFixedWidth(_SIDE)
        self.heading.setStyleSheet("font-weight: bold")
        side = QVBoxLayout()
        side.addWidget(self.heading)
        side.addWidget(area, 1)
        upper = QHBoxLayout()
        upper.addLayout(grid, 1)
        upper.addLayout(side)
        foot = QHBoxLayout()
        foot.addWidget(self.around)
        self.words.setWordWrap(True)
        foot.addWidget(self.words, 1)
        for button in (self.export_button, self.stop_button, self.run_button):
            button.setAutoDefault(False)  # Enter in a field takes its value, and is no order to run all
            foot.addWidget(button)
        layout = QVBoxLayout(self)
        layout.addLayout(upper, 1)
        layout.addLayout(foot)

    def _connect(self) -> None:
        for place, pane in enumerate(self.panes):
            pane.focused.connect(lambda place=place: self.look_at(place))
            pane.chosen.connect(lambda place=place: self._choose(place))
        self.form.changed.connect(self._set)
        self.run_button.clicked.connect(self.run)
        self.stop_button.clicked.connect(self._comparison.cancel)
        self.export_button.clicked.connect(self._export)
        self._later.timeout.connect(self._run_focused)
        self._comparison.advanced.connect(self._draw)
        self._comparison.changed.connect(self._refresh)
        self._session.image_changed.connect(self.close)

    def _settings_of(self, method: str) -> Any:
        if method == "cpm":
            return self._session.document.parameters
        return self._settings.setdefault(method, CONTOUR_METHODS[method].settings())

    def _choose(self, place: int) -> None:
        self._comparison.clear(place)
        self.look_at(place)

    def _set(self, settings: Any) -> None:
        self._settings[self.panes[self._focus].method] = settings
        self._later.start()

    def _run_focused(self) -> None:
        """Run the method again whose parameters have changed."""
        name = self.panes[self._focus].method
        if not name or self._comparison.frames[self._focus] is None:
            return
        try:
            self._comparison.run(self._focus, name, self._settings_of(name))
        except ValueError as error:
            self.words.setText(reason(error))

    def _draw(self, place: int) -> None:
        self.panes[place].show_frame(self._comparison.frames[place])

    def _refresh(self) -> None:
        running = self._comparison.running
        self.stop_button.setEnabled(running)
        self.export_button.setEnabled(
            not running and any(frame is not None and frame.over for frame in self._comparison.frames)
        )

    def _export(self) -> None:
        path = self._ask(self)
        if path is not None:
            self._comparison.write((path,))
