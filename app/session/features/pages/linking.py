"""What has been found on all pages as one result: tracks through pages that were run in any order."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from app.session.features.pages.stack_source import StackSource
from cpm_core.contours.result import Result
from cpm_core.pages.follow import Follower
from cpm_core.pages.page import Page, StackResult, without_image

Found = Result | str
"""What was found on a page, or why it could not be used."""


def linked(
    source: StackSource, found: Mapping[int, Found], before: Mapping[int, Found], drawn: tuple[Mapping[str, Any], ...]
) -> StackResult:
    """Number the contours of all pages by their tracks, page by page.

    `before` is what was known of the pages: where the same contours were found again, it stays.
    """
    follower, pages = Follower(), []
    for number in sorted(found):
        one = found[number]
        if isinstance(one, str):
            pages.append(Page(number, None, trouble=one))
            continue
        light, known = without_image(one), before.get(number)
        same = isinstance(known, Result) and _alike(light, known)
        pages.append(follower.take(number, known if same and isinstance(known, Result) else light))
    stack = source.pages
    return StackResult(stack.name, source.count, tuple(pages), stack.axis, stack.alone, drawn)


def _alike(one: Result, other: Result) -> bool:
    """Whether two results have the same contours, whatever their numbers."""
    return len(one.contours) == len(other.contours) and all(
        a.closed == b.closed and a.points.shape == b.points.shape and np.array_equal(a.points, b.points)
        for a, b in zip(one.contours, other.contours, strict=True)
    )
