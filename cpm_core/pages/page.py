"""The results of the pages of a stack, and of their tracks."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Literal

import numpy as np

from cpm_core.contours.contour import Contour, Contours
from cpm_core.contours.measurements import assign_labels
from cpm_core.contours.rasterize import rasterize_labels
from cpm_core.numerics.grids import rank_values
from cpm_core.numerics.types import Integers, JsonObject, frozen, record
from cpm_core.objects.outline import measure_strengths
from cpm_core.pages.tracks import EventKind, TrackEvent, find_origins
from cpm_core.parameters.formatting import format_count, format_repr
from cpm_core.results.result import Result

_VERTEX_DECIMALS = 4
"""Decimals of the vertices of contours, as files hold them [px]."""

_MEASURE_DECIMALS = 6
"""Decimals of what is measured in the image, as files hold it."""


@record
class Page:
    """The result of a page.

    Attributes
    ----------
    number : int
        The page, from 1.
    result : Result or None
        Its contours, whose numbers are their tracks, without the image; None for a page that could not be used.
    events : tuple of TrackEvent
        Which tracks begin, enter or leave the image, split, merge or end here.
    error : str
        Why the page could not be used, in one sentence; empty if it could.

    Examples
    --------
    >>> page = next(cpm.follow_pages([cpm.example("disk")], cpm.circle((32, 32), 8)))
    >>> page
    <Page 1, 1 contour>
    >>> page.number, len(page.contours), page.error
    (1, 1, '')
    """

    number: int
    result: Result | None
    events: tuple[TrackEvent, ...] = ()
    error: str = ""

    @property
    def contours(self) -> tuple[Contour, ...]:
        """Its contours; none for a page that could not be used."""
        return () if self.result is None else self.result.contours

    def __repr__(self) -> str:
        return format_repr("Page", str(self.number), self.error or format_count(len(self.contours), "contour"))


@record
class StackResult:
    """The results of a stack, or of the pages that are done.

    Attributes
    ----------
    source : str
        Name of the stack for the user.
    count : int
        Number of its pages.
    pages : tuple of Page
        The pages that have been followed, in that order.
    axis : {"z", "t", "c"}
        Meaning of the pages: planes, points in time, channels.
    alone : bool
        Whether the stack has no further axis.
    drawn : tuple of mapping
        The shapes drawn before the first page, as session files hold them.
    interval : float or None
        Time from page to page [s], if it is known.
    """

    source: str
    count: int
    pages: tuple[Page, ...]
    axis: Literal["z", "t", "c"] = "z"
    alone: bool = True
    drawn: tuple[JsonObject, ...] = ()
    interval: float | None = None

    def time_of(self, page: int) -> float | None:
        """Return the time of a page since the first one of the stack [s], if it is known."""
        return None if self.interval is None else round((page - 1) * self.interval, _MEASURE_DECIMALS)

    @property
    def results(self) -> tuple[tuple[int, Result], ...]:
        """The pages that could be used, by number, with what was found on each."""
        return tuple((page.number, page.result) for page in self.pages if page.result is not None)

    @property
    def tracks(self) -> tuple[Track, ...]:
        """The tracks, by number."""
        on: dict[int, dict[int, None]] = {}
        for page in self.pages:
            for contour in page.contours:
                on.setdefault(contour.number, {})[page.number] = None
        events = [event for page in self.pages for event in page.events]
        origins = find_origins(events)
        begun: dict[int, EventKind] = dict.fromkeys(origins, "splits")
        begun |= {event.track: event.kind for event in events if event.kind in ("begins", "enters")}
        ends = {event.track: event for event in events if event.kind in ("merges", "ends", "leaves")}
        first = min((page for pages in on.values() for page in pages), default=0)
        return tuple(
            Track(
                track,
                tuple(pages),
                origins.get(track, 0),
                None if first in pages else begun.get(track, "begins"),
                ends.get(track),
            )
            for track, pages in sorted(on.items())
        )


@frozen
class Track:
    """An object through the pages of a stack.

    Attributes
    ----------
    number : int
        Its number, from 1.
    pages : tuple of int
        Pages that it is on, in the order in which they were followed.
    origin : int
        The track that it split off; 0 for none.
    begin : {"begins", "enters", "splits"} or None
        How it came into being; None when it is on the first page that has any.
    end : TrackEvent or None
        How it came to its end; None when it is on the last page.
    """

    number: int
    pages: Integers
    origin: int
    begin: EventKind | None
    end: TrackEvent | None


def round_vertices(contours: Contours) -> tuple[Contour, ...]:
    """Round the vertices of contours as files hold them, from which the next page starts."""
    return tuple(replace(contour, points=np.round(contour.points, _VERTEX_DECIMALS)) for contour in contours)


def strip_image(result: Result) -> Result:
    """Strip a result of its image: contours as files hold them, with their contrast and gray values.

    Their strength is measured as that of objects, which may be listed beside them.
    """
    strengths, image = [contour.strength for contour in result.contours], result.image
    if image is not None:
        strengths = measure_strengths(image.gray_levels(result.channel), [one.path for one in result.contours])
    contours = tuple(
        replace(
            contour,
            strength=round(strength, _MEASURE_DECIMALS),
            measure_contrast=None
            if contour.measure_contrast is None
            else partial(round, contour.contrast, _MEASURE_DECIMALS),
            gray=gray,
        )
        for contour, strength, gray in zip(
            round_vertices(result.contours), strengths, _measure_gray_means(result), strict=True
        )
    )
    bridges = tuple(
        replace(
            bridge,
            points=np.round(bridge.points, _VERTEX_DECIMALS),
            length=round(bridge.length, _VERTEX_DECIMALS),
            strength=round(bridge.strength, _MEASURE_DECIMALS),
        )
        for bridge in result.bridges
    )
    return replace(result, contours=contours, bridges=bridges, image=None)


def _measure_gray_means(result: Result) -> list[float | None]:
    """Measure the mean gray value of each closed contour as in the label mask, if there is an image."""
    labels = assign_labels(result.contours)
    if result.image is None:
        return [contour.gray for contour in result.contours]
    painted, ranks = rank_values(rasterize_labels(result.contours, result.shape))
    means = np.bincount(ranks.ravel(), result.image.values.ravel()) / np.bincount(ranks.ravel())
    known = dict(zip(painted.tolist(), means.tolist(), strict=True))
    return [round(known[label], _MEASURE_DECIMALS) if label and label in known else None for label in labels]
