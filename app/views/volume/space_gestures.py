"""What a drag of the mouse and the keys do to the camera of the view in space."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import pi, radians

from PySide6.QtCore import Qt

from app.model.display.space.camera import Camera
from cpm_core.numerics.types import Array

Gesture = Callable[[Camera, float, float, int], Camera]
"""Follows the pointer, which moves to the right and down [px], in a picture whose shorter side is given [px]."""

WHOLE = (Qt.Key.Key_0, Qt.Key.Key_Home)
"""Keys that show everything."""

_STEP, _ZOOM = radians(5.0), 1.2
"""What a press of a key turns and enlarges."""

_TURNS = {
    Qt.Key.Key_Left: (-_STEP, 0.0),
    Qt.Key.Key_Right: (_STEP, 0.0),
    Qt.Key.Key_Up: (0.0, -_STEP),
    Qt.Key.Key_Down: (0.0, _STEP),
}


def turn(camera: Camera, right: float, down: float, side: int) -> Camera:
    """Turn: a drag across the picture by half a turn."""
    return camera.turned(pi * right / side, pi * down / side)


def move(camera: Camera, right: float, down: float, side: int) -> Camera:
    """Move with the pointer."""
    return camera.moved(right, down)


def roll(camera: Camera, right: float, down: float, side: int) -> Camera:
    """Roll: a drag across the picture by half a turn."""
    return camera.rolled(pi * right / side)


def gesture(button: Qt.MouseButton, keys: Qt.KeyboardModifier) -> Gesture:
    """What a drag with this button and these keys does."""
    if button != Qt.MouseButton.LeftButton or keys & Qt.KeyboardModifier.ShiftModifier:
        return move
    return roll if keys & Qt.KeyboardModifier.ControlModifier else turn


def by_key(camera: Camera, key: int, directions: Sequence[Array]) -> Camera | None:
    """The camera after a press of a key: turned, enlarged, or along an axis; None for any other key.

    `directions` are the axes of cameras that look along those of the volume.
    """
    if key in _TURNS:
        return camera.turned(*_TURNS[Qt.Key(key)])
    if key in (Qt.Key.Key_Plus, Qt.Key.Key_Equal):
        return camera.zoomed(_ZOOM)
    if key == Qt.Key.Key_Minus:
        return camera.zoomed(1.0 / _ZOOM)
    if key in (Qt.Key.Key_1, Qt.Key.Key_2, Qt.Key.Key_3):
        return camera.along(directions[key - Qt.Key.Key_1])
    return None
