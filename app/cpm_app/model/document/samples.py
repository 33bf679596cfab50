"""The sample images of the program, with shapes that make them ready to run."""

from __future__ import annotations

import filecmp
import json
from dataclasses import replace
from functools import cache
from pathlib import Path

from cpm_app.model.document.document import Mode
from cpm_app.model.text.assets import find_asset
from cpm_app.model.text.language import translate_core_text
from cpm_core import PRESETS, Parameters
from cpm_core.formats import shape_from_json
from cpm_core.numerics.types import frozen
from cpm_core.shapes import Shape


@frozen
class Sample:
    """A sample image with its shapes, parameters and mode."""

    title: str
    about: str
    path: Path
    shapes: tuple[Shape, ...]
    parameters: Parameters
    mode: Mode = "shape"

    @property
    def picture(self) -> Path:
        """File of its thumbnail: the image itself, or a picture next to a volume."""
        return self.path.with_suffix(".png")


@cache
def load_samples() -> tuple[Sample, ...]:
    """Load the list of samples; the program starts with the first one."""
    listed = json.loads(find_asset("samples/samples.json").read_text(encoding="utf-8"))
    return tuple(
        Sample(
            title=translate_core_text(entry["title"]),
            about=translate_core_text(entry["about"]),
            path=find_asset(f"samples/{entry['file']}"),
            shapes=tuple(shape_from_json(drawn, entry["title"]) for drawn in entry["shapes"]),
            parameters=replace(PRESETS[entry["preset"]], **entry.get("parameters", {})),
            mode=entry.get("mode", "shape"),
        )
        for entry in listed
    )


def find_sample_at(path: Path) -> Sample | None:
    """Return the sample with this file, or None for any other image."""
    return next((sample for sample in load_samples() if sample.path == path.resolve()), None)


def find_copied_sample(path: Path) -> Sample | None:
    """Return the sample that a file is a copy of, by name and content; a copy starts as the sample does."""
    sample = find_sample_named(path.name)
    return sample if sample and path.is_file() and filecmp.cmp(path, sample.path, shallow=False) else None


def find_sample_named(file: str) -> Sample | None:
    """Return the sample whose file has this name, or None."""
    return next((sample for sample in load_samples() if sample.path.name == file), None)
