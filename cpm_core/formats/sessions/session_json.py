"""JSON of session files: laid out for people to read and edit, and read with care, for it may have been edited."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from typing import Any, NoReturn

from cpm_core.formats.sessions.plain_values import shown

VERSION = 1

MARK = "cpm-session"
"""The key that tells a session file from other JSON; its value is the version."""

Plain = Mapping[str, Any]

_DEEPEST = 64
_UNPAIRED = re.compile("[\ud800-\udfff]")


def parsed(content: bytes, name: str) -> Plain:
    """The JSON of a session file; `name` is for sentences.

    Raises
    ------
    ValueError
        When the content is damaged, none of a session file, or of a version that is not known.
    """

    def refuse(constant: str) -> NoReturn:
        raise ValueError(f"it holds {constant}")

    def finite(text: str) -> float:
        value = float(text)
        return value if math.isfinite(value) else refuse(text)

    try:
        plain = json.loads(content.decode("utf-8-sig"), parse_constant=refuse, parse_float=finite)
    except (ValueError, RecursionError) as error:
        place = f" (line {error.lineno})" if isinstance(error, json.JSONDecodeError) else ""
        raise ValueError(f"{name} is no session file, or a damaged one{place}: get a sound copy of it.") from error
    if not isinstance(plain, dict) or MARK not in plain:
        raise ValueError(f"{name} is no session file: it does not say {MARK}.")
    if _depth(plain) > _DEEPEST:
        raise ValueError(f"{name} is no session file: its values lie within each other too deeply.")
    version = plain[MARK]
    if version != VERSION or isinstance(version, bool):
        raise ValueError(
            f"{name} is a session file of version {shown(version)}, but only version {VERSION} is known here: "
            "get a newer CPM for it."
        )
    return plain


def text_of(plain: Plain) -> str:
    """JSON with one line for each shape, mark and parameter, as a person would set it."""
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
    # Names of files may hold bytes that are no text; they survive as escapes only.
    return text if text.isascii() or not _UNPAIRED.search(text) else json.dumps(value, allow_nan=False, default=dict)


def _depth(plain: object) -> int:
    """How deeply values lie within each other."""
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
