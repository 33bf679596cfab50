"""The dialog of the mosaic."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import QObject, QRectF, QSize, Qt, Signal
from PySide6.QtWidgets import (
    QComboBox,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QProgressBar,
    QPushButton,
    QScrollArea,
    QVBoxLayout,
    QWidget,
)

from app.model.display.display_image import DisplayImage
from app.model.display.mosaic import (
    COUNTS,
    FIRST_AXES,
    Axis,
    Plan,
    Tile,
    in_text,
    pick,
    plan,
    read_values,
    sensible_values,
)
from app.model.document.document import NOTHING_TO_START_FROM
from app.model.document.modes import acting_in
from app.model.parameters.controls import Control, controls
from app.model.state.time_left import in_words
from app.model.text.keys import with_keys
from app.model.text.language import tr
from app.model.text.reasons import reason
from app.session.features.side_by_side.parameter_sweep import Done, Sweep
from app.session.session import Session
from app.views.mosaic.picture import Picture
from app.views.mosaic.run_dialog import RunDialog
from app.views.mosaic.tile import Board, EnlargedTile
from cpm_core.parameters import Parameters


class MosaicDialog(RunDialog):
    """Runs the image with several values of two parameters, and uses those of the tile that the user chooses.

    `display` is the image as it is shown, `crop` the part of it that tiles show [px of the image].
    """

    def __init__(self, parent: QWidget, session: Session, sweep: Sweep, display: DisplayImage, crop: QRectF) -> None:
        super().__init__(parent, tr("Mosaic of two parameters"))
        self._session = session
        self._sweep = sweep
        self._picture = Picture(display, crop)
        self._plan: Plan | None = None
        offered = tuple(control for control in controls() if control.name in acting_in("shape"))
        self.down = AxisRow(self, tr("Rows"), offered, FIRST_AXES[0])
        self.across = AxisRow(self, tr("Columns"), offered, FIRST_AXES[1])
        self.count = QComboBox()
        self.start_button = QPushButton(tr("Run"))
        self.cancel_button = QPushButton(tr("Cancel"))
        self.bar = QProgressBar()
        self.words = QLabel()
        self._board = Board()
        self.tiles = self._board.tiles
        self._lay_out()
        self._connect()
        self._suggest()
        self._show_progress()
        self.resize(self.sizeHint())

    def sizeHint(self) -> QSize:
        """Space for five by five tiles, within the screen."""
        return QSize(1000, 820).boundedTo(self.screen().availableSize() - QSize(40, 60))

    def end_runs(self) -> None:
        """Cancel the runs that are left."""
        self._sweep.cancel()

    # Internal

    def _lay_out(self) -> None:
        form = QGridLayout()
        form.setHorizontalSpacing(10)
        self.down.add_to(form, 0)
        self.across.add_to(form, 1)
        for number in COUNTS:
            self.count.addItem(tr("{count} values each").format(count=number), number)
        self.count.setAccessibleName(tr("Number of values"))
        form.addWidget(self.count, 0, 3)
        form.addWidget(self.start_button, 1, 3)
        form.setColumnStretch(2, 1)
        self.start_button.setDefault(True)
        foot = QHBoxLayout()
        self.words.setMinimumWidth(120)
        foot.addWidget(self.words, 1)
        self.bar.setMaximumWidth(240)
        self.bar.setTextVisible(False)
        foot.addWidget(self.bar)
        foot.addWidget(self.cancel_button)
        area = QScrollArea()
        area.setWidgetResizable(True)
        area.setWidget(self._board)
        area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        layout = QVBoxLayout(self)
        layout.addLayout(form)
        layout.addWidget(area, 1)
        layout.addLayout(foot)

    def _connect(self) -> None:
        sweep, tasks = self._sweep, self._session.tasks
        self.count.currentIndexChanged.connect(self._suggest)
        for row in (self.down, self.across):
            row.changed.connect(partial(self._suggest_for, row))
        self.start_button.clicked.connect(self._start)
        self.cancel_button.clicked.connect(sweep.cancel)
        sweep.began.connect(self._begin)
        sweep.finished.connect(self._finish)
        sweep.ended.connect(self._end)
        tasks.advanced.connect(self._show_progress)
        self._session.document_changed.connect(self._mark)
        self._session.image_changed.connect(self.close)

    def _suggest(self) -> None:
        for row in (self.down, self.across):
            self._suggest_for(row)

    def _suggest_for(self, row: AxisRow) -> None:
        document = self._session.document
        contrast = document.image.contrast if document.image else 255.0
        row.suggest(document.parameters, contrast, self.count.currentData())

    def _start(self) -> None:
        document = self._session.document
        try:
            if not document.starts:
                raise ValueError(NOTHING_TO_START_FROM)
            planned = plan(document.parameters, self.down.axis(), self.across.axis())
        except ValueError as error:
            self._say(reason(error))
            return
        self._plan = planned
        lines = 2 if self._session.scene.truth is None else 3
        for view in self._board.lay(planned, self._picture, lines):
            view.picked.connect(self._choose)
            view.enlarged.connect(self._enlarge)
        self._mark()
        self.tiles[0, 0].setFocus()
        self._sweep.start(planned, document)
        self._show_progress()

    def _begin(self, tile: Tile) -> None:
        view = self._board.view_of(tile)
        if view is not None:
            view.begin()

    def _finish(self, done: Done) -> None:
        view = self._board.view_of(done.tile)
        if view is not None:
            view.finish(done)
            self._show_progress()

    def _end(self) -> None:
        for view in self.tiles.values():
            view.cancel()
        self._show_progress()

    def _choose(self, tile: Tile) -> None:
        chosen = self._plan
        if chosen is not None:
            caption = chosen.caption(tile)
            self._session.edit(tr("use {values}").format(values=caption), lambda document: pick(document, chosen, tile))
            self._say(
                with_keys(
                    tr("Now using {values}. Undo ({key:undo}) in the window restores the previous values."),
                    values=caption,
                )
            )

    def _enlarge(self, done: Done) -> None:
        if self._plan is not None:
            large = EnlargedTile(self, done, self._plan.caption(done.tile), self._picture)
            large.accepted.connect(partial(self._choose, done.tile))
            large.open()

    def _mark(self) -> None:
        """Mark the tile whose parameters are those of the document, if any."""
        chosen, document = self._plan, self._session.document
        for view in self.tiles.values():
            view.mark(chosen is not None and pick(document, chosen, view.tile) == document)

    def _show_progress(self) -> None:
        task = self._sweep.task
        done = sum(view.done is not None for view in self.tiles.values())
        self.bar.setVisible(task is not None)
        self.cancel_button.setEnabled(task is not None)
        self.bar.setRange(0, max(1, len(self.tiles)))
        self.bar.setValue(done)
        if task is not None:
            progress = tr("{done} of {count} tiles").format(done=done, count=len(self.tiles))
            self._say(", ".join(filter(None, (progress, in_words(task.seconds_left)))))
        elif not self.tiles:
            self._say(tr("Choose two parameters and press Run. Each tile is a separate run."))
        elif done < len(self.tiles):
            self._say(tr("Canceled after {done} of {count} tiles.").format(done=done, count=len(self.tiles)))
        else:
            self._say(tr("Click a tile to use its values."))

    def _say(self, sentence: str) -> None:
        self.words.setText(sentence)
        self.words.setToolTip(sentence)


class AxisRow(QObject):
    """A choice among all parameters (`first` is the name of the initial one), and a line for its values."""

    changed = Signal()
    """A different parameter has been chosen."""

    def __init__(self, parent: QObject, title: str, controls: tuple[Control, ...], first: str) -> None:
        super().__init__(parent)  # its connections keep the dialog until it is deleted
        self._controls = controls
        self._title = title
        self.choice = QComboBox()
        self.choice.addItems([f"{control.title}  {control.symbol}" for control in controls])
        self.choice.setCurrentIndex(next(i for i, control in enumerate(controls) if control.name == first))
        self.choice.setAccessibleName(title)
        self._suggested: tuple[float, ...] = ()
        self.values = QLineEdit()
        self.values.setAccessibleName(tr("Values"))
        self.values.setToolTip(tr("Values of the parameter, separated by commas."))
        self.choice.currentIndexChanged.connect(self.changed)

    @property
    def control(self) -> Control:
        """The chosen parameter."""
        return self._controls[self.choice.currentIndex()]

    def add_to(self, grid: QGridLayout, row: int) -> None:
        """Add its widgets to a grid."""
        grid.addWidget(QLabel(self._title), row, 0)
        grid.addWidget(self.choice, row, 1)
        grid.addWidget(self.values, row, 2)

    def suggest(self, parameters: Parameters, contrast: float, count: int) -> None:
        """Suggest values around the present one."""
        self._suggested = sensible_values(self.control, parameters, contrast, count)
        self.values.setText(in_text(self._suggested))

    def axis(self) -> Axis:
        """The chosen parameter and values; raises `ValueError` if the values are not valid."""
        if len(self._suggested) > 1 and self.values.text() == in_text(self._suggested):  # the text has fewer digits
            return Axis(self.control, self._suggested)
        return Axis(self.control, read_values(self.control, self.values.text()))
