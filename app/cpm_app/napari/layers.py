"""Layers of napari from contours, surfaces and labels, and contours from shapes drawn there."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from cpm_core import Contour, Result, measure
from cpm_core.contours import assign_numbers
from cpm_core.formats import flatten_ellipse, parse_color
from cpm_core.formats.contours.contents import DEFAULT_COLOR
from cpm_core.numerics import Array, Index
from cpm_core.numerics.types import Integers, JsonDict, JsonObject

LayerData = tuple[Any, dict[str, Any], str]
"""Layer as napari takes it: data, settings, and kind."""

Frame = tuple[int, ...]
"""Where an image or a volume lies in a stack: indices along the axes before its own."""

_CLOSED_KINDS = ("polygon", "rectangle", "ellipse")
"""Kinds of closed shapes in napari."""

_SHAPE_KEY = "image_shape"
"""Key of the shape of the image in the metadata of a layer."""


def build_contour_layer(contours: Sequence[Contour], name: str, shape: Sequence[int], **settings: Any) -> LayerData:
    """Build a layer of shapes with a polygon or a path for each contour, and its measures as features."""
    lines = [contour for contour in contours if len(contour.points) > 1]
    rows = measure(lines, contrast=False)
    features = {
        "number": list(assign_numbers(lines)),
        "name": [contour.name for contour in lines],
        "closed": [contour.closed for contour in lines],
        "length": [row.length for row in rows],
        "net_area": [row.net_area for row in rows],
        "strength": [row.strength for row in rows],
    }
    look = {
        "shape_type": ["polygon" if contour.closed else "path" for contour in lines],
        "edge_color": [contour.color or DEFAULT_COLOR for contour in lines] or DEFAULT_COLOR,
        "face_color": "transparent",
        "edge_width": 1,
        "features": features,
        "metadata": {_SHAPE_KEY: tuple(shape)},
    }
    return [contour.points for contour in lines], {"name": name, **look, **settings}, "shapes"


def build_result_layers(result: Result, name: str, **settings: Any) -> list[LayerData]:
    """Build layers of labels with their measures and of contours, or in a volume the surface.

    The `settings` place them like their image.
    """
    measures = dict(result.table())
    features = {"index": measures.pop("label"), **measures}
    layers: list[LayerData] = [
        (result.labels.copy(), {"name": f"{name} labels", "features": features, **settings}, "labels")
    ]
    if result.surface is not None:
        look = {"name": f"{name} surface", **settings}
        return [*layers, ((result.surface.vertices, result.surface.faces), look, "surface")]
    return [*layers, build_contour_layer(result.contours, f"{name} contours", result.shape, **settings)]


def place_in_stack(
    layers: Sequence[LayerData], frame: Frame, shape: tuple[int, ...], known: Mapping[str, LayerData]
) -> list[LayerData]:
    """Place layers of one frame of a stack in it, beside what layers of the same names show in other frames.

    Labels are numbered on from those of other frames. `shape` is that of the stack; `known` are the layers, by name.
    """
    placed: list[LayerData] = []
    for data, settings, kind in layers:
        before = known.get(settings["name"])
        if not frame:
            placed.append((data, settings, kind))
        elif kind == "labels":
            placed.append(_place_labels(data, settings, frame, shape, before))
        elif kind == "shapes":
            placed.append(_place_contours(data, settings, frame, before))
        else:
            placed.append(((prepend_frame(data[0], frame), data[1]), settings, kind))
    return placed


def _place_labels(
    labels: Index, settings: JsonDict, frame: Frame, shape: tuple[int, ...], before: LayerData | None
) -> LayerData:
    """Put labels into those of a stack, and their measures below the measures there."""
    features: JsonDict = settings["features"]
    others: JsonDict = {name: [] for name in features}
    stack = np.zeros(shape, labels.dtype)
    if before is not None and before[0].shape == shape:
        stack = put_into(before[0], 0, frame)
        table = before[1]["features"]
        if set(features) <= set(table):
            stays = np.isin(table["index"], stack)
            others = {name: table[name][stays].tolist() for name in features}
    first = int(stack.max(initial=0))
    features = features | {"index": [first + number for number in features["index"]]}
    stack[frame] = np.where(labels, labels + first, 0)
    return stack, settings | {"features": {name: others[name] + list(features[name]) for name in features}}, "labels"


def _place_contours(lines: Sequence[Array], settings: JsonDict, frame: Frame, before: LayerData | None) -> LayerData:
    """Add contours of a frame to those of others."""
    new = [prepend_frame(line, frame) for line in lines]
    if before is None or not len(before[0]):
        return new, settings, "shapes"
    known, look, _ = before
    stays = [number for number, line in enumerate(known) if (np.round(line[:, : len(frame)]) != frame).any()]
    colors = [_find_color(look["edge_color"][number]) for number in stays] + (settings["edge_color"] if new else [])
    joined = {
        "shape_type": [look["shape_type"][number] for number in stays] + settings["shape_type"],
        "edge_color": colors or DEFAULT_COLOR,
        "features": {
            name: look["features"][name].iloc[stays].tolist() + list(new_values)
            for name, new_values in settings["features"].items()
        },
    }
    return [known[number] for number in stays] + new, settings | joined, "shapes"


def put_into(stack: Index, values: Index | int, frame: Frame) -> Index:
    """Return a stack of labels with other values in one frame."""
    stack = np.array(stack)
    stack[frame] = values
    return stack


def prepend_frame(positions: Array, frame: Frame) -> Array:
    """Return positions (N, D) in a frame as positions in its stack."""
    return np.hstack([np.tile(np.array(frame, float), (len(positions), 1)), positions])


def _find_color(shade: Array) -> str:
    """Return the color ``#rrggbb`` of parts between 0 and 1."""
    return parse_color([round(255 * float(part)) for part in shade])


def contours_from_layer(data: Sequence[Array], settings: JsonObject) -> tuple[tuple[Contour, ...], Integers]:
    """Return the contours of a layer of shapes in a plane, with names and colors, and the shape of their image.

    `data` are vertices of each shape, shape (K, D); the last two axes are rows and columns [px].
    """
    drawn = lines_from_shapes([np.asarray(corners)[:, -2:] for corners in data], settings["shape_type"])
    names = settings["features"].get("name", [""] * len(drawn))
    shades = [_find_color(shade) for shade in settings["edge_color"]]
    contours = tuple(
        replace(line, name=name if isinstance(name, str) else "", color="" if color == DEFAULT_COLOR else color)
        for line, name, color in zip(drawn, names, shades, strict=True)
    )
    known = settings["metadata"].get(_SHAPE_KEY)
    if not known:
        far = np.concatenate([np.zeros((1, 2)), *(line.points for line in drawn)]).max(axis=0)
        known = (np.ceil(far) + 1).astype(int).tolist()
    return contours, tuple(known)


def lines_from_shapes(data: Iterable[Array], kinds: Iterable[str]) -> list[Contour]:
    """Convert drawn shapes, each with vertices (K, D), to lines.

    napari represents an ellipse by the corners of its box.
    """
    lines = []
    for corners, kind in zip(data, kinds, strict=True):
        points = np.asarray(corners, dtype=float)
        if kind == "ellipse":
            one, two, three = points[:3]
            points = flatten_ellipse(points.mean(axis=0), 0.5 * (two - one), 0.5 * (three - two))
        lines.append(Contour(points, kind in _CLOSED_KINDS and len(points) > 2))
    return lines
