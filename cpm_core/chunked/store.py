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
from cpm_core.numerics.types import JsonDict, frozen, record

_SETTINGS_FILE = "settings.json"


@record
class ContourPiece:
    """A contour that a chunk sees as a whole, or the piece of a longer one in a chunk.

    Attributes
    ----------
    contour : Contour
        In px of the image.
    cut : tuple of two bool
        Whether the contour continues in another chunk beyond the first and the last vertex.
    """

    contour: Contour
    cut: tuple[bool, bool] = (False, False)


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


def pack_pieces(pieces: Sequence[ContourPiece]) -> JsonDict:
    """Pack pieces into arrays."""
    contours = [piece.contour for piece in pieces]
    return {
        "points": np.concatenate([np.empty((0, 2)), *(one.points for one in contours)]),
        "counts": np.array([len(one.points) for one in contours], np.int64),
        "closed": np.array([one.closed for one in contours], bool),
        "strength": np.array([one.strength for one in contours]),
        "junctions": np.array([one.junctions for one in contours], bool).reshape(-1, 2),
        "hole": np.array([one.hole for one in contours], bool),
        "cut": np.array([piece.cut for piece in pieces], bool).reshape(-1, 2),
    }


def unpack_pieces(arrays: JsonDict, prefix: str = "") -> list[ContourPiece]:
    """Unpack the pieces of arrays whose names have a prefix."""
    known = {key.removeprefix(prefix): values for key, values in arrays.items() if key.startswith(prefix)}
    points = np.split(known["points"], np.cumsum(known["counts"])[:-1]) if len(known["counts"]) else []
    rows = zip(
        points,
        *(known[key].tolist() for key in ("closed", "strength", "junctions", "hole", "cut")),
        strict=True,
    )
    return [
        ContourPiece(Contour(path, closed, strength, tuple(junctions), hole=hole), tuple(cut))
        for path, closed, strength, junctions, hole, cut in rows
    ]
