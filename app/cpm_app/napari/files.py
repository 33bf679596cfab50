"""Readers and writers for napari: contour files as layers of shapes, layers as files of contours and meshes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cpm_app.napari.layers import LayerData, build_contour_layer, contours_from_layer
from cpm_core import Result, Surface, example, export
from cpm_core.formats import CONTOURS_READABLE, read_contours
from cpm_core.numerics.types import JsonObject
from cpm_core.results import boundaries_result


def reader_of(path: str | Sequence[str]) -> Callable[[str | Sequence[str]], list[LayerData]] | None:
    """Return the function that reads these files; None for files of other kinds."""
    paths = _list_paths(path)
    return _read_layers if paths and all(one.suffix.lower() in CONTOURS_READABLE for one in paths) else None


def _read_layers(path: str | Sequence[str]) -> list[LayerData]:
    from napari.utils.notifications import show_info  # only here, because napari itself takes long to import

    layers: list[LayerData] = []
    for file in _list_paths(path):
        found = read_contours(file)
        for note in found.notes:
            show_info(f"{file.name}: {note}")
        if found.contours:
            layers.append(build_contour_layer(found.contours, file.stem, found.shape or ()))
        if len(found.points):
            layers.append((found.points, {"name": f"{file.stem} points", "size": 3}, "points"))
    return layers


def _list_paths(path: str | Sequence[str]) -> list[Path]:
    return [Path(path)] if isinstance(path, str) else [Path(one) for one in path]


def sample_disks() -> list[LayerData]:
    """Draw an image of two disks."""
    return _draw_sample("disks")


def sample_ball() -> list[LayerData]:
    """Draw a volume with a ball."""
    return _draw_sample("ball")


def _draw_sample(name: str) -> list[LayerData]:
    return [(example(name).values, {"name": name}, "image")]


def write_shapes(path: str, data: Any, settings: JsonObject) -> list[str]:
    """Write a layer of shapes in the format that the suffix names."""
    contours, shape = contours_from_layer(data, settings)
    return _export_result(boundaries_result(shape, settings["name"], contours=tuple(contours)), path)


def write_surface(path: str, data: Any, settings: JsonObject) -> list[str]:
    """Write a surface, in the coordinates of its layer."""
    vertices, faces = np.asarray(data[0], dtype=float), np.asarray(data[1])
    spacing = tuple(np.asarray(settings["scale"], dtype=float).tolist())
    shape = tuple((np.ceil(vertices.max(axis=0)) + 1).astype(int).tolist())
    surface = Surface(vertices, faces, spacing)
    return _export_result(boundaries_result(shape, settings["name"], spacing, surface=surface), path)


def _export_result(result: Result, path: str) -> list[str]:
    try:
        export(result, path)
    except ValueError as error:  # napari takes a ValueError to mean that there is no writer
        raise RuntimeError(str(error)) from error
    return [path]
