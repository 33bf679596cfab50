"""Contours, surfaces and points of files and of the clipboard, read on a thread, and pictures of the clipboard."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QBuffer, QIODevice, QStandardPaths
from PySide6.QtGui import QImage

from app.model.document.imported import Imported
from app.model.text.language import tr
from app.session.exchange.messages import Report
from app.session.session import Session
from app.session.tasks.tasks import Task
from cpm_core import Image, load_centerlines, load_points
from cpm_core.formats import (
    CONTOURS_READABLE,
    FOR_CENTERLINES,
    Plane,
    decode_contours,
    plane_of,
    read_contours,
    read_surface,
    write_together,
)
from cpm_core.shapes import Points

MOST_POINTS = 100_000
"""Largest number of points that can be drawn."""

_TABLE = ".csv"


@dataclass(frozen=True, slots=True)
class PointsRead(Report):
    """Points have been read."""

    path: Path
    points: Points


@dataclass(frozen=True, eq=False, slots=True)
class ContoursRead(Report):
    """What was read for the image opened as `generation`, from a file or, without a path, the clipboard."""

    generation: int
    imported: Imported
    path: Path | None = None


@dataclass(frozen=True, slots=True)
class PictureKept(Report):
    """A picture of the clipboard has been written to a file, because a session needs one."""

    path: Path


def read_file(session: Session, path: Path) -> None:
    """Start to read contours, a surface or points; reports `ContoursRead`, `PointsRead` or an error."""
    image, plane, generation = session.image, _plane(session), session.image_generation

    def work(task: Task) -> Report:
        if image is not None and image.ndim == 3:
            if path.suffix.lower() == _TABLE:
                return _points(path, 3)
            return ContoursRead(generation, _in_volume(path, image), path)
        try:
            return ContoursRead(generation, Imported.of(read_contours(path, plane), path.name), path)
        except ValueError as error:
            if path.suffix.lower() != _TABLE or _names_contours(path):
                raise
            try:
                return _points(path)
            except ValueError as other:
                raise other from error

    session.tasks.start(tr("Reading {name}…").format(name=path.name), work, f"reading {path.name}")


def read_pasted(session: Session, content: bytes) -> None:
    """Start to read contours of the clipboard; reports `ContoursRead` or an error."""
    plane, generation, name = _plane(session), session.image_generation, tr("the clipboard")

    def work(task: Task) -> Report:
        return ContoursRead(generation, Imported.of(decode_contours(content, name, plane), name))

    session.tasks.start(tr("Reading {name}…").format(name=name), work, "reading the clipboard")


def keep_picture(session: Session, picture: QImage) -> None:
    """Start to write a picture of the clipboard to a file; reports `PictureKept` or an error."""

    def work(task: Task) -> Report:
        buffer = QBuffer()
        buffer.open(QIODevice.OpenModeFlag.WriteOnly)
        if not picture.save(buffer, "PNG"):  # type: ignore[call-overload]  # bytes are refused
            raise ValueError(tr("The picture on the clipboard cannot be used: copy it again."))
        content = bytes(buffer.data().data())
        folder = folder_of_pasted()
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"pasted-{hashlib.sha256(content).hexdigest()[:8]}.png"
        write_together([(path, content)])
        return PictureKept(path)

    session.tasks.start(tr("Reading {name}…").format(name=tr("the clipboard")), work, "keeping the picture")


def folder_of_pasted() -> Path:
    """The folder of pasted pictures among the user's data."""
    return Path(QStandardPaths.writableLocation(QStandardPaths.StandardLocation.GenericDataLocation)) / "cpm/pasted"


def _plane(session: Session) -> Plane:
    return plane_of(session.scene.image)


def _in_volume(path: Path, volume: Image) -> Imported:
    """A surface or center lines in a volume."""
    suffix, notes = path.suffix.lower(), list[str]()
    if suffix in CONTOURS_READABLE:
        raise ValueError(tr("{name} has contours for an image, but a volume is open.").format(name=path.name))
    if suffix in FOR_CENTERLINES:
        lines = load_centerlines(path, volume, warn=notes.append)
        return Imported.of_lines(lines, tuple(notes))
    surface, assumed = read_surface(path, volume)
    return Imported.of_surface(surface, volume, path.name, assumed)


def _points(path: Path, axes: int = 2) -> PointsRead:
    positions = load_points(path, axes)
    if len(positions) > MOST_POINTS:
        message = tr("{name} has {count} points, but no more than {most} can be drawn.")
        raise ValueError(message.format(name=path.name, count=len(positions), most=MOST_POINTS))
    return PointsRead(path, Points(tuple(map(tuple, positions.tolist()))))


def _names_contours(path: Path) -> bool:
    """Whether the first line of a table has a column of contours or of shapes."""
    try:
        with path.open(encoding="utf-8-sig", errors="replace") as stream:
            first = stream.readline(2**14)
    except OSError:
        return False
    return any(name in first.split(",") for name in ("contour", "track", "shape-type"))
