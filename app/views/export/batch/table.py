"""The table of a batch: its images, and what has been done with each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from app.model.text.language import from_core, tr, written
from app.views.panels.item_table.columns import NONE, Column, place
from app.views.panels.item_table.model import Sorted
from app.views.panels.item_table.row_model import RowModel
from app.views.panels.item_table.row_table import RowTable

if TYPE_CHECKING:  # the command line is loaded when there is a batch
    from cpm_core.cli.batch import Row


@dataclass(frozen=True, slots=True)
class ImageRow:
    """An image with its place among all, and what has been done with it; None while it waits."""

    number: int
    image: Path
    done: Row | None

    def fact(self, name: str) -> float:
        """A number of the run; below 0 where there is none."""
        found = None if self.done is None else self.done.facts.get(name)
        return float(found) if isinstance(found, int | float) else -1.0

    @property
    def state(self) -> str:
        """How it stands with it."""
        if self.done is None:
            return tr("waiting")
        return tr("failed") if self.done.trouble else tr("done")

    @property
    def remarks(self) -> str:
        """Why it failed, or what was changed or left out."""
        said = () if self.done is None else (self.done.trouble, *self.done.notes)
        return " ".join(from_core(sentence) for sentence in said if sentence)


def _number(name: str, title: str, tip: str, sample: str) -> Column[ImageRow]:
    def text(row: ImageRow) -> str:
        return NONE if row.fact(name) < 0.0 else written(f"{row.fact(name):g}")

    return Column(name, title, tip, text, lambda row: row.fact(name), sample)


COLUMNS: tuple[Column[ImageRow], ...] = (
    Column("image", tr("Image"), tr("Name of the image file."), lambda row: row.image.name,
           lambda row: row.number, "image_0000.tif", False),
    Column("state", tr("State"), tr("Whether it waits, is done or has failed."), lambda row: row.state,
           lambda row: row.state, "waiting", False),
    _number("contours", tr("Contours"), tr("How many contours were found."), "0000"),
    _number("closed", tr("Closed"), tr("How many of them are closed."), "0000"),
    Column("remarks", tr("Remarks"), tr("Why it failed, or what was changed or left out."), lambda row: row.remarks,
           lambda row: row.remarks or "\uffff", "a longer remark on an image", False),
    _number("steps", tr("Steps"), tr("Steps of the run."), "0000"),
    _number("seconds", tr("Seconds"), tr("Time that the run took [s]."), "00.0"),
)  # fmt: skip
"""All columns in the order shown."""


class ImageTable(RowTable):
    """Shows the images of a batch."""

    def __init__(self) -> None:
        self.rows = RowModel[ImageRow](COLUMNS)
        super().__init__(self.rows, Sorted(self.rows), COLUMNS, place(COLUMNS, "remarks"), tr("Images"))

    def show_images(self, images: Sequence[Path], done: Mapping[int, Row]) -> None:
        """Show images with what has been done."""
        self.rows.show_rows([ImageRow(number, image, done.get(number)) for number, image in enumerate(images)])
