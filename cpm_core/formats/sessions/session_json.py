"""JSON of session files: laid out to be read and edited by hand, and therefore checked when it is read."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from typing import Any, NoReturn

from cpm_core.parameters.quotation import shown

VERSION = 1

MARK = "cpm-session"
"""Key that distinguishes a session file from other JSON; its value is the version."""

Plain = Mapping[str, Any]

_DEEPEST = 64
_UNPAIRED = re.compile("[\ud800-\udfff]")


def parsed(content: bytes, name: str) -> Plain:
    """The JSON of a session file; ValueError, with `name`, when it is damaged or of an unknown kind or version."""

    def refuse(constant: str) -> NoReturn:
        raise ValueError(f"it holds {constant}")

    def finite(text: str) -> float:
        value = float(text)
        return value if math.isfinite(value) else refuse(text)

    try:
        plain = json.loads(content.decode("utf-8-sig"), parse_constant=refuse, parse_float=finite)
    except (ValueError, RecursionError) as error:
        place = f" (line {error.lineno})" if isinstance(error, json.JSONDecodeError) else ""
        raise ValueError(f"{name} is not a session file, or a damaged one{place}: get a sound copy of it.") from error
    if not isinstance(plain, dict) or MARK not in plain:
        raise ValueError(f"{name} is not a session file: it has no entry {MARK}.")
    if _depth(plain) > _DEEPEST:
        raise ValueError(f"{name} is not a session file: its values are nested too deeply.")
    version = plain[MARK]
    if version != VERSION or isinstance(version, bool):
        raise ValueError(
            f"{name} is a session file of version {shown(version)}, but only version {VERSION} is known here: "
            "get a newer CPM for it."
        )
    return plain


def text_of(plain: Plain) -> str:
    """JSON with one line for each shape, mark and parameter."""
    lines = []
    for key, value in plain.items():
        items: list[str]
        if isinstance(value, list) and value:
            items, ends = [_line(item) for item in value], "[]"
        elif isinstance(value, Mapping) and value and key != "image":
            items, ends = [f"{_line(name)}: {_line(item)}" for name, item in value.items()], "{}"
        else:
            lines.append(f"  {_line(key)}: {_line(value)}")
            continue
        inner = ",\n".join(f"    {item}" for item in items)
        lines.append(f"  {_line(key)}: {ends[0]}\n{inner}\n  {ends[1]}")
    return "{\n" + ",\n".join(lines) + "\n}\n"


def _line(value: object) -> str:
    text = json.dumps(value, ensure_ascii=False, allow_nan=False, default=dict)
    # Names of files may hold bytes that are not text, which only escapes preserve.
    return text if text.isascii() or not _UNPAIRED.search(text) else json.dumps(value, allow_nan=False, default=dict)


def _depth(plain: object) -> int:
    """Depth of nested values."""
    depth, layer = 0, [plain]
    while layer and depth <= _DEEPEST:
        depth += 1
        inner: list[object] = []
        for value in layer:
            if isinstance(value, dict):
                inner += value.values()
            elif isinstance(value, list):
                inner += value
        layer = inner
    return depth
