"""Following: a run on each page of a stack, from the contours of the page before or from the same start each time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, TypeGuard

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.contours.contour import Contours
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.image.image import Image, as_plane
from cpm_core.image.pyramid import max_scales
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.model.state import State
from cpm_core.numerics.types import Extent, JsonDict
from cpm_core.objects.segmented import object_label
from cpm_core.pages.page import Page, round_vertices, strip_image
from cpm_core.pages.tracks import Tracker
from cpm_core.parameters import Parameters, choose_parameters
from cpm_core.parameters.formatting import quote_value
from cpm_core.results import find_objects, replace_by_objects
from cpm_core.results.result import Result
from cpm_core.segmentation.evolve import segment
from cpm_core.shapes import Start, collect_seeds, starts_from_contours

Seeds = ArrayLike | Callable[[Image], ArrayLike]
"""Positions of particles, shape (N, 2), or a function that gives them for an image."""


def follow_pages(
    pages: Sequence[ArrayLike | Image],
    seeds: Seeds,
    parameters: Parameters | str | None = None,
    *,
    numbers: Sequence[int] | None = None,
    fresh: bool = False,
    objects: bool = False,
    max_steps: int | None = None,
    regions: AnyRegions | None = None,
    charges: Sequence[PlacedCharge] = (),
    progress: Callable[[State], object] | None = None,
) -> Iterator[Page]:
    """Find the contours on each page of a stack, and follow objects from page to page.

    Parameters
    ----------
    pages : sequence of array_like or Image
        The pages, each an image; those of `load_pages` are read one at a time.
    seeds : array_like, shape (N, 2), or callable
        Where particles start on the first page, (row, col) [px], or a function that gives it for an image.
    parameters : Parameters or str, optional
        As for `segment`; pages too small for all scales use fewer.
    numbers : sequence of int, optional
        Which pages, from 1, in the order in which they are followed; all by default.
    fresh : bool
        Whether each page starts from `seeds` rather than from the contours of the last page that has any.
    objects : bool
        Whether the objects that the run of each page proposes are followed, each once, rather than its contours.
    max_steps, regions, charges, progress
        As for `segment`, on every page.

    Yields
    ------
    Page
        Each page as soon as it is done. The numbers of its contours are their tracks. A page that cannot be used has an
        error message and no result.

    Raises
    ------
    ValueError
        When there are no such pages.

    Examples
    --------
    >>> pages = [cpm.example("disk").values, np.roll(cpm.example("disk").values, 3, axis=1)]
    >>> for page in cpm.follow_pages(pages, cpm.circle((32, 32), 8)):
    ...     print(page.number, [contour.number for contour in page.contours])
    1 [1]
    2 [1]
    """
    if not _is_sequence(pages):
        raise ValueError(f"pages is {quote_value(pages)} but must be a sequence of images, such as load_pages(path).")
    count, given = len(pages), choose_parameters(parameters, Parameters())
    wanted = range(1, count + 1) if numbers is None else numbers
    if not _is_sequence(wanted):
        raise ValueError(f"numbers is {quote_value(numbers)} but must be a sequence of the numbers of pages.")
    for number in wanted:
        if not isinstance(number, int | np.integer) or not 1 <= number <= count:
            raise ValueError(f"page is {quote_value(number)}, but there are {count} pages: choose 1 to {count}.")

    def iterate_pages() -> Iterator[Page]:
        follower = PageFollower()
        for number in wanted:
            try:
                image = as_plane(pages[number - 1])
                continues = bool(follower.next_starts) and not fresh
                start = seeds(image) if callable(seeds) else seeds
                if continues:
                    start = collect_seeds(follower.next_starts)
                chosen = limit_scales(given, image.shape)
                limits: JsonDict = {"max_steps": max_steps, "regions": regions, "charges": charges}
                found = segment(image, start, chosen, progress=progress, **limits)
            except (ValueError, MemoryError) as error:
                yield Page(number, None, error=describe_error(error))
            else:
                yield follower.add_objects(number, found, continues) if objects else follower.add_page(number, found)

    return iterate_pages()


def _is_sequence(given: object) -> TypeGuard[Sequence[Any]]:
    """Return whether something is a sequence; an array without axes is none."""
    return isinstance(given, Sequence) or (isinstance(given, np.ndarray) and given.ndim > 0)


class PageFollower:
    """Follows what is found from page to page: its tracks, and where the next page starts."""

    def __init__(self, known: Sequence[Page] = (), taken: int = 0) -> None:
        """Continue after the pages `known`, which have been followed before; new tracks are above those `taken`."""
        self._last = next((page.contours for page in reversed(known) if page.contours), ())
        tracks = max((taken, *(contour.number for page in known for contour in page.contours)))
        self._tracker = Tracker(_select_outlines(self._last), tracks)

    @property
    def next_starts(self) -> tuple[Start, ...]:
        """Where the next page starts: along the contours of the last page that has any."""
        return starts_from_contours(self._last)

    def add_page(self, number: int, found: Result, *, numbered: bool = True) -> Page:
        """Add the next page, with what was found on it; the numbers of its contours are their tracks.

        Objects are followed by their outer contours. Their number is the group of their contours, and they keep it if
        they are `numbered`; else it becomes that of their track.
        """
        light = strip_image(found)
        outlines = _select_outlines(light.contours)
        followed = outlines if numbered else tuple(replace(one, group=0) for one in outlines)
        contours, events = self._tracker.assign_tracks(number, followed, light.shape)
        tracks = {one.group: known.number for one, known in zip(outlines, contours, strict=True) if one.group}
        if tracks:
            named = ((one, tracks[one.group]) for one in light.contours)
            contours = tuple(replace(one, number=track, group=track) for one, track in named)
        self._last = contours or self._last
        return Page(number, replace(light, contours=contours), events)

    def add_objects(self, number: int, run: Result, continues: bool) -> Page:
        """Add the next page, with the objects that its run proposes; the page after it starts from its contours.

        A run `continues` if it began along the contours of the page before.
        """
        start = round_vertices(run.contours) or self._last
        chosen = replace_by_objects(run, find_objects(run, continues=continues))
        found = replace(run, contours=chosen.contours, bridges=chosen.bridges, provenance=chosen.provenance)
        page = self.add_page(number, found, numbered=False)
        self._last = start
        contours = tuple(replace(one, name=object_label(one.number)) for one in page.contours)
        return replace(page, result=page.result and replace(page.result, contours=contours))


def _select_outlines(contours: Contours) -> Contours:
    """Select the outer contour of each object; contours of no object are left as they are."""
    outer = {one.group: one for one in sorted(contours, key=lambda one: one.area) if one.group}
    return tuple(outer[group] for group in sorted(outer)) or contours


def limit_scales(parameters: Parameters, shape: Extent) -> Parameters:
    """Limit the scales of parameters to those that an image of a shape has room for."""
    most = max_scales(shape)
    return replace(parameters, scales=most) if parameters.scales > most else parameters


def describe_error(error: Exception) -> str:
    """Describe in one sentence why a page could not be used."""
    return "There is not enough memory for this page." if isinstance(error, MemoryError) else str(error)
