"""How a document is looked at: what a session file keeps of it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from app.views.canvas.canvas import Canvas


def view_state(canvas: Canvas) -> dict[str, Any]:
    """Where one looks and how each layer is shown, as plain JSON."""
    return {"place": canvas.view_state(), "layers": {layer.name: layer.view_state() for layer in canvas.layers}}


def use_view_state(canvas: Canvas, state: Mapping[str, Any]) -> None:
    """Look at it so; what a file does not say, or says wrongly, stays as it is."""
    place, layers = state.get("place"), state.get("layers")
    canvas.use_view_state(place if isinstance(place, dict) else {})
    for layer in canvas.layers:
        kept = layers.get(layer.name) if isinstance(layers, dict) else None
        if isinstance(kept, dict):
            layer.use_view_state(kept)
