"""Names of shapes in menus and messages."""

from __future__ import annotations

from app.model.text.language import from_core
from cpm_core.shapes import Shape


def describe(shape: Shape) -> str:
    """The kind of a shape in a few words."""
    return from_core(shape.title)
