"""JSON: layout and rounding that all formats based on it share."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

PIXEL = 0.5
"""Where the center of the first pixel lies for formats that count from its corner [px]."""


def text(content: dict[str, Any]) -> bytes:
    """Encode an object as UTF-8 with one line for each entry of its lists, so that versions of a file can be compared.

    ValueError when a number is not finite, which JSON cannot express.
    """
    parts = [f"{json.dumps(key)}: {_value(value)}" for key, value in content.items()]
    return ("{\n" + ",\n".join(parts) + "\n}\n").encode()


def pairs(points: NDArray[np.float64]) -> list[list[float]]:
    """Points (row, col) as pairs [x, y] from the corner of the image, the usual origin in graphics [px]."""
    return rounded(points[:, ::-1] + PIXEL)


def rounded(values: NDArray[np.float64]) -> list[Any]:
    """Numbers to a ten thousandth of a pixel, in nested lists."""
    return list(np.round(values, 4).tolist())


def _value(value: Any) -> str:
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return "[\n" + ",\n".join(_plain(entry) for entry in value) + "\n]"
    return _plain(value)


def _plain(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False)
