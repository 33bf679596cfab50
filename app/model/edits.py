"""Edits: pure functions from a document to the next one."""

from __future__ import annotations

from dataclasses import replace

from app.model import controls
from app.model.document import Document
from cpm_core.parameters import PRESETS, Parameters
from cpm_core.paths import Position
from cpm_core.shapes import Everywhere, Kind, Shape


def add_shape(document: Document, shape: Shape) -> Document:
    """The document with one more shape, drawn last."""
    return replace(document, shapes=(*document.shapes, shape))


def replace_shape(document: Document, index: int, shape: Shape) -> Document:
    """The document with `shape` in place of the one at `index`."""
    shapes = list(document.shapes)
    shapes[index] = shape
    return replace(document, shapes=tuple(shapes))


def move_shape(document: Document, index: int, by: Position) -> Document:
    """The document with one shape displaced by (rows, cols)."""
    return replace_shape(document, index, document.shapes[index].moved(by))


def lead_shape(document: Document, index: int, handle: Position, to: Position) -> Document:
    """The document with one shape led by its handle to a position."""
    return replace_shape(document, index, document.shapes[index].led(handle, to))


def delete_shape(document: Document, index: int) -> Document:
    """The document without the shape at `index`."""
    return replace(document, shapes=document.shapes[:index] + document.shapes[index + 1 :])


def toggle_everywhere(document: Document, kind: Kind) -> Document:
    """The document that starts all over the image in this way if it did not before, else without."""
    start = Everywhere(kind)
    if start in document.shapes:
        return delete_shape(document, document.shapes.index(start))
    return add_shape(document, start)


def clear_shapes(document: Document) -> Document:
    """The document with nothing drawn."""
    return replace(document, shapes=())


def set_parameter(document: Document, name: str, value: float | str) -> Document:
    """The document with one control set; see `app.model.controls.with_value`."""
    return replace(document, parameters=controls.with_value(document.parameters, name, value))


def set_parameters(document: Document, parameters: Parameters) -> Document:
    """The document with all parameters replaced."""
    return replace(document, parameters=parameters)


def use_preset(document: Document, name: str) -> Document:
    """The document with the parameters of a preset."""
    return set_parameters(document, PRESETS[name])
