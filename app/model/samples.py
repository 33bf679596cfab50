"""The sample images that come with the program, and what is drawn on them so that they are ready to run."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from app.model.assets import asset
from cpm_core.parameters import PRESETS, Parameters
from cpm_core.shapes import Circle, Shape


@dataclass(frozen=True, slots=True)
class Sample:
    """A sample image.

    Attributes
    ----------
    title, about : str
        Name, and one sentence on what it shows.
    path : Path
        Its file.
    shapes : tuple of Shape
        What is drawn on it.
    parameters : Parameters
        What it is run with.
    """

    title: str
    about: str
    path: Path
    shapes: tuple[Shape, ...]
    parameters: Parameters


@cache
def samples() -> tuple[Sample, ...]:
    """All samples, the one that the program starts on first."""
    listed = json.loads(asset("samples/samples.json").read_text(encoding="utf-8"))
    return tuple(
        Sample(
            title=entry["title"],
            about=entry["about"],
            path=asset(f"samples/{entry['file']}"),
            shapes=tuple(Circle((float(row), float(col)), float(radius)) for row, col, radius in entry["circles"]),
            parameters=PRESETS[entry["preset"]],
        )
        for entry in listed
    )


def sample_at(path: Path) -> Sample | None:
    """The sample with this file, or None when it is an image of the user's own."""
    return next((sample for sample in samples() if sample.path == path.resolve()), None)
