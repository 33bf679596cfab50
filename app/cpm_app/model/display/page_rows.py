"""Rows of the table of all pages of a stack: one for each contour on each page."""

from __future__ import annotations

from dataclasses import replace

from cpm_app.model.text.language import tr, translate_core_text
from cpm_core import Page, measure
from cpm_core.contours import Measures, compute_centroid
from cpm_core.numerics.types import record
from cpm_core.pages import StackResult, Track

_EVENT_TEXTS = {
    "begins": tr("begins"),
    "enters": tr("enters the image"),
    "splits": tr("splits off track {track}"),
    "ends": tr("ends here"),
    "leaves": tr("leaves the image"),
    "merges": tr("merges into track {track}"),
}
"""Events at the beginning and the end of a track, in words."""


@record
class PageRow:
    """A contour on a page, or a page that could not be used.

    Attributes
    ----------
    page, track : int
        Page and track; track 0 for a page that could not be used.
    measures : Measures or None
        Measures of the contour.
    is_object : bool
        Whether it is an object that has been accepted.
    index : int
        Index of the contour on its page.
    time : float or None
        Time since the first page [s].
    row, col : float
        Its center [px].
    gray : float or None
        Mean gray value inside.
    event : str
        What happens to the track, or why the page could not be used; empty for nothing.
    """

    page: int
    track: int
    measures: Measures | None
    row: float
    col: float
    gray: float | None
    event: str
    is_object: bool = False
    index: int = 0
    time: float | None = None


def collect_page_rows(found: StackResult) -> tuple[PageRow, ...]:
    """Build the rows of all pages, in their order."""
    tracks = {track.number: track for track in found.tracks}
    rows = (row for page in found.pages for row in _build_rows_of_page(page, tracks))
    return tuple(replace(row, time=found.time_of(row.page)) for row in rows)


def _build_rows_of_page(page: Page, tracks: dict[int, Track]) -> list[PageRow]:
    if page.result is None:
        return [PageRow(page.number, 0, None, 0.0, 0.0, None, translate_core_text(page.error))]
    rows = []
    for index, measures in enumerate(measure(page.contours, page.result.spacing)):
        contour = page.contours[index]
        if contour.hole:
            continue
        track, happens = tracks[contour.number], []
        if page.number == track.pages[0] and track.begin is not None:
            happens.append(_EVENT_TEXTS[track.begin].format(track=track.origin))
        if page.number == track.pages[-1] and track.end is not None:
            happens.append(_EVENT_TEXTS[track.end.kind].format(track=" ".join(map(str, track.end.others))))
        row, col = compute_centroid(contour)
        said, gray = ", ".join(happens), contour.gray
        rows.append(PageRow(page.number, contour.number, measures, row, col, gray, said, contour.group > 0, index))
    return rows
