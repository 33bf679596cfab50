"""The dialog of the comparison."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QRectF, QSize, Qt
from PySide6.QtGui import QCloseEvent, QKeyEvent
from PySide6.QtWidgets import QDialog, QHBoxLayout, QLabel, QProgressBar, QPushButton, QTabWidget, QVBoxLayout, QWidget

from app.model.display.comparison import Tile, pick
from app.model.display.display_image import DisplayImage
from app.model.document.objects import add_region
from app.model.state.situation import remaining_text
from app.model.text.keys import with_keys
from app.model.text.language import reason, tr
from app.session.features.comparison import Comparison, Done
from app.session.session import Session
from app.views.comparison.board import Board, Lines, Picture
from app.views.comparison.choices import MethodChoice, ParameterChoice
from app.views.theme import theme
from cpm_core.contours.contour import Contour
from cpm_core.contours.ground_truth import Truth
from cpm_core.shapes.outlines import outlines_of

_SIDE = 290


class CompareDialog(QDialog):
    """Runs the image with several values of parameters, or by several methods, and takes over what is selected.

    `display` is the image as it is shown, `crop` the part of it that tiles show [px of the image]; `ask` asks for the
    file of an export. Its runs end when it is closed.
    """

    def __init__(
        self,
        parent: QWidget,
        session: Session,
        comparison: Comparison,
        display: DisplayImage,
        crop: QRectF,
        ask: Callable[[QWidget], Path | None],
    ) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowFlag(Qt.WindowType.WindowMaximizeButtonHint)  # to be shown to many on a wall
        self.setWindowTitle(tr("Compare runs"))
        self._session, self._comparison, self._ask = session, comparison, ask
        self._display, self._crop = display, crop
        self.parameters, self.methods = ParameterChoice(session), MethodChoice(session)
        self.choices = QTabWidget()
        self.choices.addTab(self.parameters, tr("Parameters"))
        self.choices.addTab(self.methods, tr("Methods"))
        self.choices.setFixedWidth(_SIDE)
        self.board, self.words, self.bar = Board(), QLabel(), QProgressBar()
        self.start_button, self.cancel_button = QPushButton(tr("Run")), QPushButton(tr("Cancel"))
        self.take_button, self.enlarge_button = QPushButton(tr("Use these values")), QPushButton(tr("Enlarge"))
        self.export_button = QPushButton(tr("Export…"))
        self.export_button.setToolTip(
            tr("Write the figures as a table, a picture of the methods side by side, or the contours of each method.")
        )
        self._lay_out()
        self._connect()
        self._refresh()
        self.resize(QSize(1180, 860).boundedTo(self.screen().availableSize() - QSize(40, 60)))

    def closeEvent(self, event: QCloseEvent) -> None:
        """End the runs."""
        self._comparison.cancel()
        super().closeEvent(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Close on Esc; Enter takes over the tile with the keyboard."""
        if event.key() == Qt.Key.Key_Escape:
            self.close()
        elif event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter) and self.focusWidget() in self.board.tiles:
            self._take()
        else:
            super().keyPressEvent(event)

    # Internal

    def _lay_out(self) -> None:
        upper, foot, layout = QHBoxLayout(), QHBoxLayout(), QVBoxLayout(self)
        upper.addWidget(self.board, 1)
        upper.addWidget(self.choices)
        self.words.setMinimumWidth(120)
        self.words.setWordWrap(True)
        foot.addWidget(self.words, 1)
        self.bar.setMaximumWidth(160)
        self.bar.setTextVisible(False)
        foot.addWidget(self.bar)
        for button in (self.enlarge_button, self.take_button, self.export_button, self.cancel_button):
            button.setAutoDefault(False)
            foot.addWidget(button)
        self.start_button.setDefault(True)
        foot.addWidget(self.start_button)
        layout.addLayout(upper, 1)
        layout.addLayout(foot)

    def _connect(self) -> None:
        comparison = self._comparison
        self.start_button.clicked.connect(self._start)
        self.cancel_button.clicked.connect(comparison.cancel)
        self.take_button.clicked.connect(self._take)
        self.enlarge_button.clicked.connect(self._enlarge)
        self.export_button.clicked.connect(self._export)
        self.board.taken.connect(self._take)
        self.board.selected.connect(self._select)
        comparison.began.connect(self._begin)  # a partial would keep the dialog when it is closed
        comparison.finished.connect(self._finish)
        comparison.ended.connect(self._end)
        self._session.tasks.advanced.connect(self._refresh)
        self._session.document_changed.connect(self._mark)
        self._session.image_changed.connect(self.close)

    def _start(self) -> None:
        try:
            of_methods = self.choices.currentWidget() is self.methods
            tiles = (self.methods if of_methods else self.parameters).tiles()
            self._comparison.start(tiles)
        except ValueError as error:
            self._say(reason(error))
            return
        self.board.lay(tiles, Picture(self._display, self._crop, self._below() if of_methods else ()))
        self._mark()
        self._refresh()

    def _below(self) -> Lines:
        """The boundaries of the ground truth, and the start."""
        truth = self._session.scene.truth
        true = truth.contours if isinstance(truth, Truth) else ()
        starts = (Contour(outline, closed=True) for outline in outlines_of(self._session.document.shapes))
        return [*((contour, theme.TRUTH) for contour in true), *((start, theme.MOVING) for start in starts)]

    def _show_state(self, tile: Tile, state: str) -> None:
        view = self.board.view_of(tile)
        if view is not None and view.done is None:
            view.show_state(state)

    def _begin(self, tile: Tile) -> None:
        self._show_state(tile, tr("running…"))

    def _finish(self, done: Done) -> None:
        self.board.finish(done)
        self._mark()
        self._refresh()

    def _end(self) -> None:
        for view in self.board.tiles:
            self._show_state(view.tile, tr("canceled"))
        self._refresh()

    def _select(self) -> None:
        view = self.board.current
        if view is not None and view.tile.method:
            self.methods.mark(view.tile.method)
        self._refresh()

    def _take(self) -> None:
        """Use the values of the selected tile, or keep what its method has found as an object."""
        view = self.board.current
        if view is None:
            return
        caption, tile, result = view.tile.caption, view.tile, view.done.result if view.done else None
        if not tile.method:
            self._session.edit(tr("use {values}").format(values=caption), lambda document: pick(document, tile))
            self._say(
                with_keys(
                    tr("Now using {values}. Undo ({key:undo}) in the window restores the previous values."),
                    values=caption,
                )
            )
        elif result is not None:
            self._session.edit(tr("keep what {method} has found").format(method=caption),
                               lambda document: add_region(document, result.contours, caption))  # fmt: skip
            self._say(tr("{method} is an object of the window now.").format(method=caption))

    def _enlarge(self) -> None:
        view = self.board.current
        if view is not None and view.done is not None and view.done.result is not None:
            large, label = QDialog(self), QLabel()
            large.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
            large.setWindowTitle(", ".join((view.tile.caption, *view.state.splitlines())))
            room = self.screen().availableSize() * 0.8
            label.setPixmap(view.picture.drawn(room, self.devicePixelRatioF(), view.done.result.contours))
            QVBoxLayout(large).addWidget(label)
            large.open()

    def _export(self) -> None:
        path = self._ask(self)
        if path is not None:
            self._comparison.write([view.done for view in self.board.tiles if view.done is not None], path)

    def _mark(self) -> None:
        """Mark the tile whose parameters are those of the document, if any."""
        document = self._session.document
        for view in self.board.tiles:
            view.mark(not view.tile.method and pick(document, view.tile) == document)

    def _refresh(self) -> None:
        task, tiles, current = self._comparison.task, self.board.tiles, self.board.current
        done = sum(view.done is not None for view in tiles)
        of_methods = bool(tiles) and bool(tiles[0].tile.method)
        self.bar.setVisible(task is not None)
        self.bar.setRange(0, max(1, len(tiles)))
        self.bar.setValue(done)
        self.cancel_button.setEnabled(task is not None)
        found = current is not None and current.done is not None and current.done.result is not None
        self.enlarge_button.setEnabled(found)
        self.take_button.setEnabled(found or (current is not None and not of_methods))
        self.take_button.setText(tr("Keep as object") if of_methods else tr("Use these values"))
        self.export_button.setEnabled(task is None and of_methods and done > 0)
        if task is not None:
            progress = tr("{done} of {count} tiles").format(done=done, count=len(tiles))
            self._say(", ".join(filter(None, (progress, remaining_text(task.seconds_left)))))
        elif tiles and done < len(tiles):
            self._say(tr("Canceled after {done} of {count} tiles.").format(done=done, count=len(tiles)))
        elif tiles:
            self._say(self._comparison.left_out if of_methods else tr("Select a tile to use its values."))
        else:
            self._say(tr("Choose parameters or methods and press Run. Each tile is a separate run."))

    def _say(self, sentence: str) -> None:
        self.words.setText(sentence)
        self.words.setToolTip(sentence)
