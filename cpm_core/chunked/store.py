"""The folder of a run chunk by chunk: the results so far, so that a run that was interrupted continues."""

from __future__ import annotations

import io
import json
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cpm_core.contours.contour import Contour
from cpm_core.formats.common.atomic import write_together
from cpm_core.numerics.types import NO_POINTS, JsonDict, frozen

_SETTINGS_FILE = "settings.json"

_PLAIN_FIELDS = ("closed", "strength", "hole", "group")
"""Fields of a contour that are stored as one value for each."""


@frozen
class RunStore:
    """Files of a run, each written atomically: a file is complete or absent."""

    folder: Path

    def open_run(self, settings: JsonDict) -> bool:
        """Prepare the folder for a run, and return whether it holds files of a run with the same settings."""
        known = self.folder / _SETTINGS_FILE
        text = json.dumps(settings, sort_keys=True).encode()
        if known.is_file() and known.read_bytes() == text:
            return True
        if self.folder.exists():
            shutil.rmtree(self.folder)
        self.folder.mkdir(parents=True)
        write_together([(known, text)])
        return False

    def has_file(self, name: str) -> bool:
        """Return whether a file exists."""
        return (self.folder / name).is_file()

    def save(self, name: str, **arrays: Any) -> None:
        """Write arrays by name."""
        content = io.BytesIO()
        np.savez(content, **arrays)
        write_together([(self.folder / name, content.getvalue())])

    def load(self, name: str, *keys: str) -> JsonDict:
        """Read arrays, all or those of some names."""
        with np.load(self.folder / name, allow_pickle=False) as known:
            return {key: known[key] for key in keys or known.files}

    def remove(self) -> None:
        """Remove the folder."""
        shutil.rmtree(self.folder, ignore_errors=True)


def pack_contours(contours: Sequence[Contour], prefix: str = "own") -> JsonDict:
    """Pack contours into arrays whose names have a prefix."""
    arrays = {
        "points": np.concatenate([NO_POINTS, *(one.points for one in contours)]),
        "counts": np.array([len(one.points) for one in contours], np.int64),
        "junctions": np.array([one.junctions for one in contours], bool).reshape(-1, 2),
        **{name: np.array([getattr(one, name) for one in contours]) for name in _PLAIN_FIELDS},
    }
    return {f"{prefix}_{name}": values for name, values in arrays.items()}


def unpack_contours(arrays: JsonDict, prefix: str = "own") -> list[Contour]:
    """Unpack the contours of arrays whose names have a prefix."""
    known = {name: arrays[f"{prefix}_{name}"] for name in ("points", "counts", "junctions", *_PLAIN_FIELDS)}
    points = np.split(known["points"], np.cumsum(known["counts"]))
    junctions = map(tuple, known["junctions"].tolist())
    rows = zip(*(known[name].tolist() for name in _PLAIN_FIELDS), strict=True)
    return [
        Contour(points[n], junctions=at, **dict(zip(_PLAIN_FIELDS, row, strict=True)))
        for n, (at, row) in enumerate(zip(junctions, rows, strict=True))
    ]
