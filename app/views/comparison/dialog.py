"""The dialog of the comparison: a picture of each run with its figures, and what is run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from PySide6.QtCore import QRectF, QSize, Qt, Signal
from PySide6.QtGui import QCloseEvent, QIcon, QKeyEvent
from PySide6.QtWidgets import (
    QButtonGroup,
    QDialog,
    QGridLayout,
    QHBoxLayout,
    QProgressBar,
    QPushButton,
    QScrollArea,
    QTabWidget,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from app.model.display.comparison import Tile, pick
from app.model.display.display_image import DisplayImage
from app.model.document.objects import add_region
from app.model.state.situation import remaining_text
from app.model.text.keys import with_keys
from app.model.text.language import from_core, reason, tr, written
from app.session.features.comparison import Comparison, Done
from app.session.session import Session
from app.views.comparison.choices import MethodChoice, ParameterChoice
from app.views.export.picture import Line, Picture
from app.views.theme import theme
from app.views.widgets.containers import arrange, wrapped
from cpm_core import Contour, Truth
from cpm_core.shapes import outlines_of

_SIDE = 290
_LEAST_WIDTH, _MOST_WIDTH = 130, 420
"""Limits of the width of a tile [px]."""
_PALE = 0.35
"""Opacity of the image of a run that has not ended."""


class TileView(QToolButton):
    """One run: its picture, and below it what it is, how far it has come, and what it has found."""

    def __init__(self, tile: Tile, picture: Picture, below: Sequence[Line], width: int) -> None:
        super().__init__()
        self.tile = tile
        self.done: Done | None = None
        self._picture, self._below = picture, below
        self.setCheckable(True)
        self.setAutoRaise(True)
        self.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextUnderIcon)
        self.setIconSize(QSize(width, width))
        self.setAccessibleName(tile.caption)
        self.show_state(tr("waiting"))

    def show_state(self, state: str) -> None:
        """Show how far the run has come."""
        self.state = state
        found = self.done.result if self.done else None
        lines = [*self._below, *map(Line, found.contours if found else ())]
        opacity = _PALE if found is None else 1.0
        self.setIcon(QIcon(self._picture.drawn(self.iconSize(), self.devicePixelRatioF(), lines, opacity)))
        width = max(self.iconSize().width(), _LEAST_WIDTH)
        texts = [self.tile.caption, *state.splitlines(), "", ""][:3]
        shown = (self.fontMetrics().elidedText(text, Qt.TextElideMode.ElideRight, width) for text in texts)
        # An ampersand in a text of a button would mark a key.
        self.setText("\n".join(shown).replace("&", "&&"))
        self.setAccessibleDescription(state)

    def finish(self, done: Done) -> None:
        """Show a finished run."""
        self.done = done
        self.setToolTip(_details(done))
        self.show_state(figures_text(done))


def figures_text(done: Done) -> str:
    """Number of contours and steps, and on a second line the agreement with the ground truth, if any."""
    facts = done.facts
    if facts is None:
        return done.trouble
    found = tr("1 contour") if facts.contours == 1 else tr("{count} contours").format(count=facts.contours)
    text = tr("{found}, {steps} steps").format(found=found, steps=facts.steps)
    return text if facts.dice is None else "\n".join((text, tr("Dice {dice:.4f}").format(dice=facts.dice)))


def _details(done: Done) -> str:
    """All figures of a run, one in each line."""
    facts = done.facts
    if facts is None:
        return done.trouble
    figures: tuple[tuple[str, float | None, str], ...] = (
        (tr("Time [s]"), facts.seconds, ".2f"),
        (tr("Closed"), facts.closed, "d"),
        ("F", facts.f, ".3f"),
        (tr("Hausdorff") + " [px]", facts.hausdorff, ".1f"),
        (tr("Mean distance") + " [px]", facts.mean_distance, ".2f"),
    )
    known = ((title, value, form) for title, value, form in figures if value is not None and np.isfinite(value))
    lines = [f"{title}: {written(format(value, form))}" for title, value, form in known]
    return "\n".join([from_core(facts.stop_reason), *lines])


class Board(QScrollArea):
    """The tiles of the present comparison in rows and columns."""

    selected = Signal()
    """Another tile has been selected."""

    def __init__(self) -> None:
        super().__init__()
        self.tiles: tuple[TileView, ...] = ()
        self.setWidgetResizable(True)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)

    @property
    def current(self) -> TileView | None:
        """The selected tile."""
        return next((view for view in self.tiles if view.isChecked()), None)

    def show_tiles(self, tiles: Sequence[Tile], picture: Picture, below: Sequence[Line]) -> None:
        """Replace the tiles."""
        body = QWidget()
        grid, group = QGridLayout(body), QButtonGroup(body)
        across = 1 + max(tile.col for tile in tiles)
        width = min(max((self.width() - 40) // across - 16, _LEAST_WIDTH), _MOST_WIDTH)
        self.tiles = tuple(TileView(tile, picture, below, width) for tile in tiles)
        for view in self.tiles:
            group.addButton(view)
            grid.addWidget(view, view.tile.row, view.tile.col)
            view.toggled.connect(self.selected)
        grid.setAlignment(Qt.AlignmentFlag.AlignTop | Qt.AlignmentFlag.AlignLeft)
        self.setWidget(body)
        self.tiles[0].setChecked(True)
        self.tiles[0].setFocus()


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
        self._picture = Picture(display, crop)
        self.parameters, self.methods = ParameterChoice(session), MethodChoice(session)
        self.choices = QTabWidget()
        self.choices.addTab(self.parameters, tr("Parameters"))
        self.choices.addTab(self.methods, tr("Methods"))
        self.choices.setFixedWidth(_SIDE)
        self.board, self.words, self.bar = Board(), wrapped(), QProgressBar()
        self.bar.setMaximumWidth(160)
        self.bar.setTextVisible(False)
        self.words.setMinimumWidth(120)
        self.take_button = self._button(tr("Use these values"), self._take)
        self.export_button = self._button(tr("Export…"), self._export)
        self.export_button.setToolTip(
            tr("Write the figures as a table, a picture of the methods side by side, or the contours of each method.")
        )
        self.cancel_button = self._button(tr("Cancel"), comparison.cancel)
        self.start_button = self._button(tr("Run"), self._start)
        buttons = (self.take_button, self.export_button, self.cancel_button, self.start_button)
        layout = QVBoxLayout(self)
        layout.addLayout(arrange(QHBoxLayout(), self.board, self.choices, wide=self.board), 1)
        layout.addLayout(arrange(QHBoxLayout(), self.words, self.bar, *buttons, wide=self.words))
        self.start_button.setDefault(True)
        self.board.selected.connect(self._select)
        comparison.began.connect(self._begin)  # a partial would keep the dialog when it is closed
        comparison.finished.connect(self._finish)
        comparison.ended.connect(self._end)
        session.tasks.advanced.connect(self._refresh)
        session.image_changed.connect(self.close)
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

    def _button(self, text: str, do: Callable[[], None]) -> QPushButton:
        button = QPushButton(text)
        button.setAutoDefault(False)
        button.clicked.connect(do)
        return button

    def _start(self) -> None:
        try:
            of_methods = self.choices.currentWidget() is self.methods
            tiles = (self.methods if of_methods else self.parameters).tiles()
            self._comparison.start(tiles)
        except ValueError as error:
            self._say(reason(error))
            return
        self.board.show_tiles(tiles, self._picture, self._below() if of_methods else ())
        self._refresh()

    def _below(self) -> list[Line]:
        """The boundaries of the ground truth, and the start."""
        truth = self._session.scene.truth
        true = truth.contours if isinstance(truth, Truth) else ()
        starts = (Contour(outline, closed=True) for outline in outlines_of(self._session.document.shapes))
        return [*(Line(one, theme.TRUTH) for one in true), *(Line(start, theme.MOVING) for start in starts)]

    def _begin(self, tile: Tile) -> None:
        for view in self.board.tiles:
            if view.tile is tile:  # and not one of a previous comparison
                view.show_state(tr("running…"))

    def _finish(self, done: Done) -> None:
        for view in self.board.tiles:
            if view.tile is done.tile:
                view.finish(done)
        self._refresh()

    def _end(self) -> None:
        for view in self.board.tiles:
            if view.done is None:
                view.show_state(tr("canceled"))
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
        tile, caption, result = view.tile, view.tile.caption, view.done.result if view.done else None
        if not tile.method:
            self._session.edit(tr("use {values}").format(values=caption), lambda document: pick(document, tile))
            text = tr("Now using {values}. Undo ({key:undo}) in the window restores the previous values.")
            self._say(with_keys(text, values=caption))
        elif result is not None:
            self._session.edit(tr("keep what {method} has found").format(method=caption),
                               lambda document: add_region(document, result.contours, caption))  # fmt: skip
            self._say(tr("{method} is an object of the window now.").format(method=caption))

    def _export(self) -> None:
        path = self._ask(self)
        if path is not None:
            self._comparison.write([view.done for view in self.board.tiles if view.done is not None], path)

    def _refresh(self) -> None:
        task, tiles, current = self._comparison.task, self.board.tiles, self.board.current
        done = sum(view.done is not None for view in tiles)
        of_methods = bool(tiles) and bool(tiles[0].tile.method)
        self.bar.setVisible(task is not None)
        self.bar.setRange(0, max(1, len(tiles)))
        self.bar.setValue(done)
        self.cancel_button.setEnabled(task is not None)
        found = current is not None and current.done is not None and current.done.result is not None
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
