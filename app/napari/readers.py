"""Reader for napari: files of contours as layers of shapes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from app.napari.layers import LayerData, layer_of_contours, layer_of_points
from cpm_core.formats import CONTOURS_READABLE
from cpm_core.formats.contours.reading.contour_file import read_contours


def reader_of(path: str | Sequence[str]) -> Callable[[str | Sequence[str]], list[LayerData]] | None:
    """The function that reads these files; None for files of other kinds."""
    paths = _all(path)
    return _read if paths and all(one.suffix.lower() in CONTOURS_READABLE for one in paths) else None


def _read(path: str | Sequence[str]) -> list[LayerData]:
    layers: list[LayerData] = []
    for file in _all(path):
        found = read_contours(file)
        if found.contours:
            layers.append(layer_of_contours(found.contours, file.stem, found.shape or ()))
        if len(found.places):
            layers.append(layer_of_points(found.places, file.stem))
    return layers


def _all(path: str | Sequence[str]) -> list[Path]:
    return [Path(path)] if isinstance(path, str) else [Path(one) for one in path]
