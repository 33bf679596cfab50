"""Names of shapes in menus and messages."""

from __future__ import annotations

from app.model.text.language import tr
from cpm_core.shapes import Shape


def describe(shape: Shape) -> str:
    """The kind of a shape in a few words."""
    return tr(shape.title)
