"""Agreement of the contours or the surface of ``cpm run`` with a ground truth."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from cpm_core.contours.agreement import Comparison, compare
from cpm_core.contours.ground_truth import Truth
from cpm_core.contours.result import Result
from cpm_core.contours.surface.agreement import SurfaceComparison, compare_surface
from cpm_core.contours.surface.ground_truth import VolumeTruth


def agreement(result: Result, truth: Truth | VolumeTruth | None) -> dict[str, Any]:
    """How well contours, or a surface, agree with a ground truth, as values by name; empty where there is none."""
    if isinstance(truth, VolumeTruth):
        surface = compare_surface(result.surface, truth)
        more = {"unit": truth.unit, "hausdorff95": _finite(surface.hausdorff95)}
        return {"truth": {"source": truth.source, **_measures(surface), **more}}
    return {} if truth is None else {"truth": {"source": truth.source, **_measures(compare(result.contours, truth))}}


def _measures(found: Comparison | SurfaceComparison) -> dict[str, float | None]:
    values = {name: _finite(getattr(found, name)) for name in ("dice", "jaccard", "precision", "recall", "f")}
    return values | {"hausdorff": _finite(found.hausdorff), "mean_distance": _finite(found.mean_boundary_distance)}


def _finite(value: float) -> float | None:
    return round(value, 6) if math.isfinite(value) else None


def sentence_on(facts: Mapping[str, Any]) -> str:
    """What a person is told of it."""
    unit = facts.get("unit", "px") or "voxels"
    boundaries = "surfaces" if "unit" in facts else "boundaries"
    dice = "not known" if facts["dice"] is None else f"{facts['dice']:.3f}"
    away = ""
    if facts["hausdorff"] is not None:
        away = f", farthest apart {facts['hausdorff']:.1f} {unit}"
        if "hausdorff95" in facts:
            away = (
                f", {facts['mean_distance']:.2g} {unit} apart on average, 95 % within {facts['hausdorff95']:.2g}{away}"
            )
    return f"Beside {facts['source']}: Dice {dice}, F of the {boundaries} {facts['f']:.3f}{away}"
