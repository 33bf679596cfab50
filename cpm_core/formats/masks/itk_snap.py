"""Label descriptions of ITK-SNAP: a text file next to a label volume with name and color of each label."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from cpm_core.formats.common.content import read_content
from cpm_core.formats.common.printable import build_label
from cpm_core.image.surface import Label

DESCRIPTION_SUFFIX = ".txt"
"""Suffix of the descriptions that are written."""

_DESCRIPTION_SUFFIXES = (DESCRIPTION_SUFFIX, ".label")
"""Suffixes of the descriptions that ITK-SNAP saves."""

_HEADER_LINE = "# labels for ITK-SNAP: number, red, green, blue, opacity, shown in slices, shown in space, name\n"
"""First line of a description."""

_LABEL_LINE = re.compile(r'\s*(\d+)\s+(\d+)\s+(\d+)\s+(\d+)\s+[\d.eE+-]+\s+[01]\s+[01]\s+"(.*)"\s*')
"""Line of a label: number, red, green, blue, opacity, two visibilities, name."""

_MAX_DESCRIPTION_SIZE = 2**22
"""Size up to which a file is read [bytes]."""


def encode_label_description(labels: Sequence[Label]) -> bytes:
    """Encode a description of labels, which all have a color; label 0 is the background."""
    lines = [f'{0:5d}{0:6d}{0:5d}{0:5d}{0:9d}{0:3d}{0:3d}    "Clear Label"\n']
    for label in labels:
        red, green, blue = bytes.fromhex(label.color[1:])
        name = (label.name or f"Label {label.number}").replace('"', "'")  # which would end the name
        lines.append(f'{label.number:5d}{red:6d}{green:5d}{blue:5d}{1:9d}{1:3d}{1:3d}    "{name}"\n')
    return "".join([_HEADER_LINE, *lines]).encode()


def read_label_description(path: Path) -> tuple[Label, ...]:
    """Read the labels of a description; empty for other files, or if there is no such file."""
    text = read_content(path, head_size=_MAX_DESCRIPTION_SIZE).decode("utf-8", "replace") if path.is_file() else ""
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    found = [match for line in lines if (match := _LABEL_LINE.fullmatch(line))]
    if len(found) < len(lines):
        return ()
    return tuple(
        build_label(int(match[1]), match[5], bytes(min(int(part), 255) for part in match.group(2, 3, 4)))
        for match in found
        if int(match[1])
    )


def read_sibling_description(path: Path, suffix: str) -> tuple[Label, ...]:
    """Read the labels of a volume, whose name ends in a suffix, from the description next to it; empty without one."""
    stem = path.name[: len(path.name) - len(suffix)]
    return next(
        (found for other in _DESCRIPTION_SUFFIXES if (found := read_label_description(path.with_name(stem + other)))),
        (),
    )
