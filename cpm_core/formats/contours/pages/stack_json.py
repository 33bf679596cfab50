"""JSON: everything that was found in a stack, for scripts, and for going on with the pages that are not done."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from cpm_core.contours.contour import Bridge, Contour
from cpm_core.contours.result import Result
from cpm_core.formats.common.provenance import ENTRY, facts_of, facts_on
from cpm_core.formats.contours.contour_json import found_in, image_of
from cpm_core.formats.contours.json_text import text
from cpm_core.formats.images.decoded import MAXIMUM_PIXELS
from cpm_core.pages.page import MeasuredContrast, Page, StackResult
from cpm_core.pages.tracks import TrackEvent
from cpm_core.parameters.provenance import Provenance

FORMAT = "cpm-pages"
"""Value of the entry ``format`` of such a file."""

_MOST_PARTICLES = 10**7
"""Most particles that a page is believed to have had."""

_FARTHEST = 1e100
"""Distance of a vertex from the first pixel up to which lengths and areas can be computed [px]."""


def encode(found: StackResult) -> bytes:
    """Write an object with the stack, its tracks and its pages; `load_stack_result` reads it back.

    ``stack`` has its ``name``, the number of its ``pages``, as ``axis`` z, t or c, and what was ``drawn``. Each of
    ``tracks`` has its number, its ``pages``, as ``origin`` the track that it split off, 0 for none, and how it
    ``ends``, null for those that do not. Each of ``pages`` has its number, ``trouble`` where it could not be used,
    ``events``, and what `contour_json.encode` writes of an image; the number of a contour is its track.
    """
    stack: dict[str, Any] = {"name": found.source, "pages": found.count, "axis": found.axis, "alone": found.alone}
    stack |= {"drawn": facts_on(found.source, Provenance(), found.drawn).get("shapes", [])}
    tracks = [
        {"track": one.number, "pages": list(one.pages), "origin": one.origin, "ends": one.end and one.end.kind}
        for one in found.tracks
    ]
    pages = list(map(page_to_plain, found.pages))
    return text({"format": FORMAT, "version": 1, "stack": stack, "tracks": tracks, "pages": pages})


def page_to_plain(page: Page) -> dict[str, Any]:
    """A page as an entry of ``pages``; see `encode`."""
    events = [
        {"kind": event.kind, "page": event.page, "track": event.track, "others": list(event.others)}
        for event in page.events
    ]
    plain: dict[str, Any] = {"page": page.number, "trouble": page.trouble, "events": events}
    if page.result is not None:
        plain |= {"image": image_of(page.result), ENTRY: facts_of(page.result), **found_in(page.result)}
        for entry in plain["contours"]:
            entry["label"] = entry["number"] if entry["label"] else 0
    return plain


def load_stack_result(path: Path) -> StackResult:
    """Read what has been found in a stack, as `encode` has written it, so that the other pages can follow.

    Raises
    ------
    ValueError
        When there is no such file, or it was not written so; one sentence that says what to do.
    """
    try:
        plain = json.loads(Path(path).read_text(encoding="utf-8"))
        if plain["format"] != FORMAT:
            raise ValueError("another format")
        stack = plain["stack"]
        pages = tuple(page_from_plain(entry) for entry in plain["pages"])
        drawn = tuple(stack["drawn"])
        return StackResult(str(stack["name"]), int(stack["pages"]), pages, stack["axis"], bool(stack["alone"]), drawn)
    except OSError as error:
        raise ValueError(f"{path} cannot be read: {error.strerror or error}.") from error
    except (KeyError, TypeError, ValueError, IndexError, AttributeError, RecursionError) as error:
        raise ValueError(
            f"{Path(path).name} holds no pages of a stack: choose a .json file that was written of all pages, or name "
            "another one."
        ) from error


def page_from_plain(plain: Mapping[str, Any]) -> Page:
    """The page of an entry; an exception of some kind for one that is damaged."""
    events = tuple(
        TrackEvent(event["kind"], int(event["page"]), int(event["track"]), tuple(map(int, event["others"])))
        for event in plain["events"]
    )
    result = _result_from(plain) if "contours" in plain else None
    return Page(int(plain["page"]), result, events, str(plain["trouble"]))


def _result_from(plain: Mapping[str, Any]) -> Result:
    image, run = plain["image"], plain["run"]
    shape, particles = tuple(map(int, image["shape"])), int(run["particles"])
    if not (0 <= particles <= _MOST_PARTICLES and min(shape) > 0 and math.prod(shape) <= MAXIMUM_PIXELS):
        raise ValueError("a page is larger than any image")
    spacing = tuple(map(float, image["spacing"]))
    if len(shape) != 2 or len(spacing) != 2 or not all(0.0 < side < math.inf for side in spacing):
        raise ValueError("a page has other axes than an image")
    bridges = [Bridge(_points(one), float(one["length"]), float(one["strength"])) for one in plain["bridges"]]
    return Result(
        np.zeros((particles, 2)),  # only their number is in the file
        tuple(map(_contour_from, plain["contours"])),
        None,
        int(run["steps"]),
        bool(run["converged"]),
        str(run["stop_reason"]),
        shape,
        spacing,
        image["unit"],
        str(image["name"]),
        tuple(bridges),
        channel=image.get("channel", "luminance"),
        provenance=_provenance_from(plain[ENTRY]),
    )


def _contour_from(plain: Mapping[str, Any]) -> Contour:
    first, last = plain["junctions"]
    contrast = plain["contrast"]
    return Contour(
        _points(plain),
        bool(plain["closed"]),
        float(plain["strength"]),
        (bool(first), bool(last)),
        None if contrast is None else MeasuredContrast(float(contrast)),
        str(plain["name"]),
        str(plain["color"]),
        int(plain["number"]),
        reached=plain.get("reached", ""),
    )


def _points(plain: Mapping[str, Any]) -> np.ndarray[Any, np.dtype[np.float64]]:
    points = np.array(plain["points"], dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 2 or not (np.abs(points) <= _FARTHEST).all():
        raise ValueError("vertices are not pairs of numbers that can be measured")
    return points


def _provenance_from(facts: Mapping[str, Any]) -> Provenance:
    image = facts["image"]
    return Provenance(
        facts.get("method", ""),
        facts.get("parameters", {}),
        facts.get("seeds"),
        tuple(facts.get("shapes", ())),
        facts.get("scale"),
        facts.get("steered", False),
        image.get("sha256", image.get("array_sha256", "")),
        "array_sha256" not in image,
    )
