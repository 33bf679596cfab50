"""Skeletons of binary and gray shapes: the experiment of Fig. 14."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cpm_core.contours.agreement import compare_boundaries
from cpm_core.contours.contour import Contour
from cpm_core.medial_axis.skeleton import Skeleton
from cpm_core.medial_axis.skeleton_method import skeleton
from cpm_core.numerics.types import Array
from docs.gallery.outlines import Distance, Rings, coverage, ellipse, limb, rings, union
from docs.gallery.pages import Page, Picture
from docs.gallery.runs import Facts
from docs.gallery.scenes import blurred, closed, grain, paint, texture
from docs.gallery.silhouettes import SIDE, hand

_SIZE = (SIDE, SIDE)
_TOLERANCE = 1.0


@dataclass(frozen=True, eq=False)
class Shape:
    """An image (H, W), the outline of its shape, and the medial axis of that where it is known exactly."""

    values: Array
    outline: Rings
    axis: tuple[Contour, ...] = ()


def skeletons() -> Page:
    """Fig. 14: skeletons of two black and white shapes and two gray ones, and the shapes rebuilt from them."""
    above, below, measured = [], [], []
    for name, shape in shapes().items():
        found = skeleton(shape.values)
        facts = _measure(shape, found)
        measured.append(facts)
        above.append(Picture(name, shape.values, contours=found.contours, caption=_agreement(facts), facts=facts))
        overlap = f"overlap with the true shape {facts['overlap']:.3f}"
        rebuilt, outline = found.rebuild_shape().astype(float), closed(shape.outline)
        below.append(Picture("rebuilt from its skeleton", rebuilt, contours=outline, caption=[overlap]))
    words = {"open contour": "skeleton", "closed contour": "true outline", "boundary": "medial axis"}
    return Page([above, below], note=_note(measured), alike=False, words=words)


def shapes() -> dict[str, Shape]:
    """Draw the shapes of Fig. 14."""
    return {"ellipse": _ellipse(), "hand": _hand(), "grey starfish": _starfish(), "grey cross in noise": _cross()}


def _measure(shape: Shape, found: Skeleton) -> Facts:
    true, rebuilt = coverage(shape.outline, _SIZE) >= 0.5, found.rebuild_shape()
    facts: dict[str, object] = {
        "branches": len(found.contours),
        "length_px": round(found.length, 2),
        "overlap": round(float((true & rebuilt).sum() / (true | rebuilt).sum()), 4),
    }
    if not shape.axis:
        return facts
    seen = compare_boundaries(found.contours, shape.axis, _TOLERANCE)
    return {
        "recall": round(seen.recall, 4),
        "precision": round(seen.precision, 4),
        "mean_distance_px": round(seen.mean_boundary_distance, 3),
        "tolerance_px": _TOLERANCE,
        **facts,
    }


def _agreement(facts: Facts) -> list[str]:
    branches = f"{facts['branches']} branch{'' if facts['branches'] == 1 else 'es'}, {facts['length_px']:.0f} px long"
    if "recall" not in facts:
        return [branches]
    shares = f"recall {facts['recall']:.3f} · precision {facts['precision']:.3f}"
    return [f"{shares} · {facts['mean_distance_px']:.3f} px", branches]


def _note(measured: Sequence[Facts]) -> str:
    known = [facts for facts in measured if "recall" in facts]
    low = {key: min(float(str(facts[key])) for facts in known) for key in ("recall", "precision")}
    overlap = min(float(str(facts["overlap"])) for facts in measured)
    return (
        f"where the medial axis is known, recall at least {low['recall']:.3f} and precision at least "
        f"{low['precision']:.3f} within {_TOLERANCE:.1f} px; rebuilt shapes overlap the true ones by at least "
        f"{overlap:.3f}"
    )


def _line(*points: tuple[float, float]) -> Contour:
    return Contour(np.array(points), closed=False)


def _ellipse() -> Shape:
    """Draw an ellipse; its medial axis ends at the centers of curvature of its vertices."""
    center, short, long = (72.2, 71.7), 28.0, 58.0
    reach = (long * long - short * short) / long
    outline = ellipse(center, short, long)
    axis = _line((center[0], center[1] - reach), (center[0], center[1] + reach))
    return Shape(paint(_SIZE, 0.0, (outline, 255.0)), outline, (axis,))


def _hand() -> Shape:
    return Shape(paint(_SIZE, 0.0, (hand(), 255.0)), hand())


def _arms(count: int, length: float, wide: float, thin: float, turn: float) -> tuple[Distance, tuple[Contour, ...]]:
    """Equal limbs from one center at equal angles; by symmetry the medial axis is their middle lines."""
    center = (72.3, 71.6)
    angle = turn + 2.0 * np.pi * np.arange(count) / count
    tips = [(center[0] + length * float(np.sin(a)), center[1] + length * float(np.cos(a))) for a in angle]
    return union(*(limb(center, tip, wide, thin) for tip in tips)), tuple(_line(center, tip) for tip in tips)


def _starfish() -> Shape:
    shape, axis = _arms(5, 54.0, 15.0, 6.0, 0.3)
    outline = rings(shape, _SIZE)
    values = blurred(paint(_SIZE, 60.0, (outline, 110.0)), 1.0) + texture(_SIZE, 16.0, 6.0, 141)
    return Shape(values, outline, axis)


def _cross() -> Shape:
    shape, axis = _arms(4, 50.0, 11.0, 11.0, 0.5)
    outline = rings(shape, _SIZE)
    return Shape(paint(_SIZE, 70.0, (outline, 110.0)) + grain(_SIZE, 25.0, 142), outline, axis)
