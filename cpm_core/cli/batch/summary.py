"""The summary of a batch: a table with a row for each image, by which a later batch knows what has been done."""

from __future__ import annotations

import csv
import io
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from cpm_core.formats.common.atomic import append, write_together
from cpm_core.formats.common.content import fingerprint_if_read
from cpm_core.formats.common.printable import cell, printable, text_of_cell
from cpm_core.formats.common.provenance import VERSION

NAME = "summary.csv"
"""Name of the table in the folder of a batch."""

_SEPARATOR = "; "
_FACTS = ("contours", "closed", "particles", "steps", "converged", "stop_reason", "seconds")
_VALUES: dict[str, Callable[[str], object]] = {
    **dict.fromkeys(("contours", "closed", "particles", "steps"), int),
    "converged": "True".__eq__,
    "seconds": float,
}
_COLUMNS = (
    "image",
    *_FACTS,
    "trouble",
    "notes",
    "files",
    "image_sha256",
    "session_sha256",
    "settings",
    "version",
    "finished",
)


_HEADER = f"{','.join(_COLUMNS)}\n".encode()


@dataclass(frozen=True, slots=True)
class Row:
    """What has been done with one image.

    Attributes
    ----------
    image : str
        The image as it was named.
    facts : mapping
        As ``cpm run --json`` tells them; empty when it failed.
    files : tuple of str
        Names of the files that were written, in the folder of the batch.
    trouble : str
        Why it failed, or empty.
    notes : tuple of str
        What was changed on reading, or left out of a file.
    image_sha256, session_sha256 : str
        Hashes of the image and the session file.
    settings : str
        What is asked in addition to the session.
    version : str
        Version of the program.
    finished : str
        When it was finished, in UTC.
    """

    image: str
    facts: dict[str, object] = field(default_factory=dict)
    files: tuple[str, ...] = ()
    trouble: str = ""
    notes: tuple[str, ...] = ()
    image_sha256: str = ""
    session_sha256: str = ""
    settings: str = ""
    version: str = VERSION
    finished: str = ""


def now() -> str:
    """The present time in UTC, to a second."""
    return time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())


class Summary:
    """The table of a folder, with the rows of earlier batches; each new row is appended as soon as it is there.

    Parameters
    ----------
    folder : Path
        Where the files of the batch are.
    images : sequence of str
        The images of this batch, in the order of their rows.

    Raises
    ------
    ValueError
        When there is a table that cannot be read, or is none of a batch.
    """

    def __init__(self, folder: Path, images: Sequence[str]) -> None:
        self._path = folder / NAME
        self._images = images
        self._earlier = _rows(self._path)
        self._rows: dict[int, Row] = {}

    def done(self, session_sha256: str, settings: str) -> dict[int, Row]:
        """Rows of the images that an earlier batch has done in the same way, by their number, and adopts them.

        Session, image, settings and version must be the same, and the files still there.
        """
        names = {Path(row.image).name for row in self._earlier}
        for number, image in enumerate(self._images):
            name = printable(Path(image).name)
            if name not in names:
                continue
            wanted = (fingerprint_if_read(Path(image)), session_sha256, settings, VERSION)
            for row in self._earlier:
                known = (row.image_sha256, row.session_sha256, row.settings, row.version)
                if not row.trouble and wanted == known and Path(row.image).name == name and self._has(row):
                    self._earlier.remove(row)
                    self._rows[number] = row
                    break
        return dict(self._rows)

    def taken(self) -> set[str]:
        """Names of files, in lower case, that belong to other images than those of this batch, or are done."""
        own = {Path(printable(image)).absolute() for image in self._images}
        others = [row for row in self._earlier if Path(row.image).absolute() not in own]
        return {name.lower() for row in (*others, *self._rows.values()) for name in row.files}

    def release(self, names: Iterable[str]) -> None:
        """Drop earlier rows of files that are about to be replaced: no row ever tells of files that are others now."""
        replaced = {name.lower() for name in names}
        kept = [row for row in self._earlier if replaced.isdisjoint(name.lower() for name in row.files)]
        if len(kept) < len(self._earlier):
            self._earlier = kept
            self.write()

    def add(self, number: int, row: Row) -> None:
        """Add the row of an image to the table, which has been written before."""
        self._rows[number] = row
        append(self._path, _lines([row]))

    def write(self) -> None:
        """Write the whole table: the rows of this batch in its order, and earlier ones of other images."""
        own = {printable(self._images[number]) for number in self._rows}
        rows = [row for row in self._earlier if row.image not in own]
        write_together([(self._path, _HEADER + _lines([*rows, *self.rows.values()]))])

    @property
    def rows(self) -> dict[int, Row]:
        """Rows of this batch, by the number of the image."""
        return dict(sorted(self._rows.items()))

    def _has(self, row: Row) -> bool:
        return all((self._path.parent / name).is_file() for name in row.files)


def _rows(path: Path) -> list[Row]:
    """Rows of a table; none where there is no table yet."""
    try:
        content = path.read_bytes()
        text = content[: content.rfind(b"\n") + 1].decode()  # a row that was cut short is that of an image not done
    except FileNotFoundError:
        return []
    except OSError as error:
        raise ValueError(f"{path} cannot be read: {error.strerror or error}.") from error
    except UnicodeDecodeError:
        raise ValueError(f"{path} is damaged: remove it, or choose another folder.") from None
    lines = list(csv.DictReader(io.StringIO(text, newline="")))
    if lines and "image" not in lines[0]:
        raise ValueError(f"{path} is not the table of a batch, and would be replaced: choose another folder.")
    try:
        return [
            _row({name: text_of_cell(value or "") for name, value in line.items() if name in _COLUMNS})
            for line in lines
        ]
    except ValueError:
        raise ValueError(f"{path} is damaged: remove it, or choose another folder.") from None


def _row(line: dict[str, str]) -> Row:
    facts = {name: _VALUES.get(name, str)(line[name]) for name in _FACTS if line.get(name)}
    lists = {name: tuple(filter(None, line.pop(name, "").split(_SEPARATOR))) for name in ("files", "notes")}
    others = {name: line.get(name, "") for name in _COLUMNS if name not in (*_FACTS, "files", "notes")}
    return Row(facts=facts, **lists, **others)  # type: ignore[arg-type]  # the names are those of the columns


def _lines(rows: Iterable[Row]) -> bytes:
    text = io.StringIO()
    table = csv.DictWriter(text, _COLUMNS, restval="", lineterminator="\n")
    for row in rows:
        lists = {"files": _SEPARATOR.join(row.files), "notes": _SEPARATOR.join(row.notes)}
        plain = {name: getattr(row, name) for name in _COLUMNS if name not in (*_FACTS, *lists)}
        line = {**plain, **lists, **row.facts}
        table.writerow({name: cell(value) if isinstance(value, str) else value for name, value in line.items()})
    return text.getvalue().encode()
