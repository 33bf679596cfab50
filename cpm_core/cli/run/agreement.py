"""Agreement of the contours of ``cpm run`` with a ground truth."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping
from typing import Any

from cpm_core.contours.agreement import compare
from cpm_core.contours.ground_truth import Truth
from cpm_core.contours.result import Result
from cpm_core.formats.ground_truth_file import load_truth
from cpm_core.image.image import Image


def truth_for(arguments: argparse.Namespace, image: Image) -> Truth | None:
    """The ground truth that is named, of this image."""
    if arguments.truth is None:
        return None
    return load_truth(arguments.truth, image.shape, spacing=image.spacing, unit=image.unit)


def agreement(result: Result, truth: Truth | None) -> dict[str, Any]:
    """How well contours agree with a ground truth, as values by name; empty where there is none."""
    if truth is None:
        return {}
    found = compare(result.contours, truth)
    values = {name: getattr(found, name) for name in ("dice", "jaccard", "precision", "recall", "f")}
    values |= {"hausdorff": found.hausdorff, "mean_distance": found.mean_boundary_distance}
    plain = {name: round(value, 6) if math.isfinite(value) else None for name, value in values.items()}
    return {"truth": {"source": truth.source, **plain}}


def sentence_on(facts: Mapping[str, Any]) -> str:
    """What a person is told of it."""
    far = "" if facts["hausdorff"] is None else f", farthest apart {facts['hausdorff']:.1f} px"
    return f"Beside {facts['source']}: Dice {facts['dice']:.3f}, F of the boundaries {facts['f']:.3f}{far}"
