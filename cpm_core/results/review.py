"""The user's review of contours, applied to a result."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from cpm_core.contours.contour import Contour, select_bridges_on
from cpm_core.contours.hand_edits import HandEdit, apply_hand_edits
from cpm_core.contours.review import Mark, pair_with_marks
from cpm_core.field.scale_field import ScaleField
from cpm_core.numerics import polyline
from cpm_core.numerics.types import Integers
from cpm_core.reconstruction.curve.hysteresis import measure_contours
from cpm_core.results.result import Result, keep_contours

_SAME_EDGE_DISTANCE = 2.0
"""Distance up to which two contours run along the same edge [px]."""

_SAME_CONTOUR_SHARE = 0.8
"""Share of a contour that has to run along another one to be it, or a part of it."""

_OVERLAP_SAMPLES = 24
"""Number of places along a contour that are compared."""


def apply_marks(result: Result, marks: Sequence[Mark]) -> Result:
    """Apply marks to a result: leave out rejected contours, and set names and colors.

    Parameters
    ----------
    result : Result
        Outcome of a run.
    marks : sequence of Mark
        Marks of its contours.

    Returns
    -------
    Result
        The result itself without marks.
    """
    if not marks:
        return result
    every = pair_with_marks(result.contours, marks)
    named = replace(result, contours=tuple(one.contour for one in every))
    return keep_contours(named, [not one.rejected for one in every])


def restore_kept_contours(result: Result, marks: Sequence[Mark]) -> Result:
    """Restore each kept contour that is not in a result, or only in parts, as it was when it was kept.

    A contour is found again when another one runs along most of it. Otherwise the kept one is added,
    last, and takes the place of the contours that run along it for most of their length.

    Parameters
    ----------
    result : Result
        Outcome of a run.
    marks : sequence of Mark
        Marks of contours of this image; only kept ones with an outline count.

    Returns
    -------
    Result
        The result itself when all kept contours are in it.
    """
    kept = [mark for mark in marks if mark.verdict == "kept" and mark.outline.points]
    if not kept:
        return result
    lost = []
    for mark in kept:
        outline = mark.outline.to_contour(mark.name, mark.color)
        if not any(_runs_along(outline, contour) for contour in result.contours):
            lost.append(outline)
    if not lost:
        return result
    rest = [contour for contour in result.contours if not any(_runs_along(contour, one) for one in lost)]
    taken = {contour.number for contour in rest}
    for index, contour in enumerate(lost):
        if contour.number in taken:  # a number of another session
            lost[index] = replace(contour, number=0)
        taken.add(contour.number)
    return replace(result, contours=(*rest, *lost))


def apply_edits_to_result(
    result: Result, edits: Sequence[HandEdit], scale_field: ScaleField | None
) -> tuple[Result, Integers]:
    """Apply edits by hand to a result, without the bridges they have removed; also return the missed edits.

    Contours that have changed are measured in the fields of the image, where these are given.
    """
    if not edits:
        return result, ()
    contours, missed = apply_hand_edits(result.contours, edits)
    if scale_field is not None:
        same = set(map(id, result.contours))
        contours = tuple(one if id(one) in same else measure_contours([one], scale_field)[0] for one in contours)
    return replace(result, contours=contours, bridges=select_bridges_on(result.bridges, contours)), missed


def _runs_along(contour: Contour, other: Contour) -> bool:
    """Return whether a contour runs along another one for most of its length."""
    low, high = other.box
    if (contour.box[0] > high + _SAME_EDGE_DISTANCE).any() or (contour.box[1] < low - _SAME_EDGE_DISTANCE).any():
        return False
    away = polyline.distances_to_path(other.path, polyline.path_midpoints(contour.path, _OVERLAP_SAMPLES))
    return bool((away <= _SAME_EDGE_DISTANCE).mean() >= _SAME_CONTOUR_SHARE)
