"""The board on which the tiles of a mosaic lie."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtWidgets import QGridLayout, QWidget

from app.model.display.mosaic import Plan, Tile
from app.views.mosaic.picture import Picture
from app.views.mosaic.tile import TileView


class Board(QWidget):
    """The tiles of the last mosaic, in rows and columns."""

    def __init__(self) -> None:
        super().__init__()
        self.tiles: dict[tuple[int, int], TileView] = {}
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setSpacing(6)

    def lay(self, plan: Plan, picture: Picture, lines: int) -> Iterable[TileView]:
        """Lay out the tiles of a plan instead of those there are.

        Parameters
        ----------
        plan : Plan
            The mosaic.
        picture : Picture
            What is shown below the contours.
        lines : int
            Lines of text below a tile.
        """
        for view in self.tiles.values():
            self._grid.removeWidget(view)
            view.hide()
            view.deleteLater()
        self.tiles.clear()
        for tile in plan.tiles:
            view = self.tiles[tile.row, tile.col] = TileView(tile, plan.caption(tile), picture, lines)
            view.left.connect(self._go_to)
            self._grid.addWidget(view, tile.row, tile.col)
        return self.tiles.values()

    def view_of(self, tile: Tile) -> TileView | None:
        """The view of a tile, unless it belongs to a mosaic before."""
        view = self.tiles.get((tile.row, tile.col))
        return view if view is not None and view.tile is tile else None

    def _go_to(self, row: int, col: int) -> None:
        if (row, col) in self.tiles:
            self.tiles[row, col].setFocus()
