"""The part that a session shows of its file, of other files to which the session is applied."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from cpm_core.formats.images.readers import open_stack
from cpm_core.formats.images.reading import DEFAULT, Reading


def part_for(path: Path, reading: Reading) -> dict[str, Any]:
    """What `load_image` is told beside the path to read another file as a session reads its own.

    Page, channel and point in time are chosen of a file that holds several. The size of a pixel that was set by hand
    holds where a file tells none.

    Raises
    ------
    ValueError
        When the file cannot be used, or has no such series.
    """
    if reading == DEFAULT:
        return {}
    stack = open_stack(path, reading.series)
    pages = stack.shape[0] if stack.shape[0] > 1 else stack.times
    return replace(
        reading,
        page=reading.page if pages > 1 else None,
        channel=reading.channel if stack.channels > 1 else None,
        time=reading.time if stack.times > 1 else None,
        spacing=reading.spacing if stack.unit is None else None,
        unit=reading.unit if stack.unit is None else None,
    ).arguments
