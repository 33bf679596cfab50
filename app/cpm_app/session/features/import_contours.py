"""Contours, surfaces and points from files and the clipboard, read on a thread, and pictures from the clipboard."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QBuffer, QIODevice, QStandardPaths
from PySide6.QtGui import QImage

from cpm_app.model.document.imported import ImportedContent
from cpm_app.model.text.language import tr
from cpm_app.session.session import Session
from cpm_app.session.tasks.tasks import BackgroundTask
from cpm_core import Image, load_centerlines, load_points
from cpm_core.formats import (
    CENTERLINES_WRITABLE,
    CONTOURS_READABLE,
    decode_contours,
    describe_plane,
    read_contours,
    read_surface,
    write_together,
)
from cpm_core.numerics.polyline import as_line
from cpm_core.shapes import Points

MAX_DRAWN_POINTS = 100_000
"""Largest number of points that can be drawn."""

_POINT_TABLE_SUFFIX = ".csv"
"""Suffix of tables, which hold contours or points."""

ImportedDrawing = ImportedContent | Points
"""Content of a file: contours, surfaces and center lines, or points."""


def read_contour_file(session: Session, path: Path, on_read: Callable[[ImportedDrawing], object]) -> None:
    """Start to read contours, a surface or points."""
    image, plane = session.image, describe_plane(session.image)

    def read_content(task: BackgroundTask) -> ImportedDrawing:
        if image is not None and image.ndim == 3:
            return _read_points(path, 3) if path.suffix.lower() == _POINT_TABLE_SUFFIX else _read_in_volume(path, image)
        try:
            return ImportedContent.from_contour_file(read_contours(path, plane), path.name)
        except ValueError as error:
            if path.suffix.lower() != _POINT_TABLE_SUFFIX or _has_contour_column(path):
                raise
            try:
                return _read_points(path)
            except ValueError as other:
                raise other from error

    _read_in_background(session, path.name, read_content, on_read)


def read_pasted(session: Session, content: bytes, on_read: Callable[[ImportedDrawing], object]) -> None:
    """Start to read contours from the clipboard."""
    plane, name = describe_plane(session.image), tr("the clipboard")

    def decode_content(task: BackgroundTask) -> ImportedDrawing:
        return ImportedContent.from_contour_file(decode_contours(content, name, plane), name)

    _read_in_background(session, name, decode_content, on_read)


def _read_in_background(
    session: Session,
    name: str,
    work: Callable[[BackgroundTask], ImportedDrawing],
    on_read: Callable[[ImportedDrawing], object],
) -> None:
    """Read on a thread, and use the content unless another image has been opened."""
    image = session.store.image_generation

    def use_if_current(drawing: ImportedDrawing) -> None:
        if image == session.store.image_generation:
            on_read(drawing)

    title, activity = tr("Reading {name}…", name=name), tr("reading {name}", name=name)
    session.tasks.start_task(title, work, activity, on_result=use_if_current)


def save_pasted_picture(session: Session, picture: QImage, on_saved: Callable[[Path], object]) -> None:
    """Start to write a picture from the clipboard to a file, because a session needs one."""

    def write_picture(task: BackgroundTask) -> Path:
        buffer = QBuffer()
        buffer.open(QIODevice.OpenModeFlag.WriteOnly)
        if not picture.save(buffer, "PNG"):  # type: ignore[call-overload]  # bytes are refused
            raise ValueError(tr("The picture on the clipboard cannot be used: copy it again."))
        content = bytes(buffer.data().data())
        folder = pasted_pictures_folder()
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"pasted-{hashlib.sha256(content).hexdigest()[:8]}.png"
        write_together([(path, content)])
        return path

    name = tr("the clipboard")
    title, activity = tr("Reading {name}…", name=name), tr("reading {name}", name=name)
    session.tasks.start_task(title, write_picture, activity, on_result=on_saved)


def pasted_pictures_folder() -> Path:
    """Return the folder of pasted pictures in the user's data folder."""
    return Path(QStandardPaths.writableLocation(QStandardPaths.StandardLocation.GenericDataLocation)) / "cpm/pasted"


def _read_in_volume(path: Path, volume: Image) -> ImportedContent:
    """Read a surface or center lines for a volume."""
    suffix, notes = path.suffix.lower(), list[str]()
    if suffix in CONTOURS_READABLE:
        raise ValueError(tr("{name} has contours for an image, but a volume is open.", name=path.name))
    if suffix in CENTERLINES_WRITABLE:
        lines = load_centerlines(path, volume, warn=notes.append)
        return ImportedContent.from_centerlines(lines, tuple(notes))
    surface, assumed = read_surface(path, volume)
    return ImportedContent.from_surface(surface, volume, path.name, assumed)


def _read_points(path: Path, axes: int = 2) -> Points:
    positions = load_points(path, axes)
    if len(positions) > MAX_DRAWN_POINTS:
        message = tr("{name} has {count} points, but at most {most} can be drawn.")
        raise ValueError(message.format(name=path.name, count=len(positions), most=MAX_DRAWN_POINTS))
    return Points(as_line(positions))


def _has_contour_column(path: Path) -> bool:
    """Return whether the first line of a table has a column of contours."""
    try:
        with path.open(encoding="utf-8-sig", errors="replace") as stream:
            first = stream.readline(2**14)
    except OSError:
        return False
    return any(name in first.split(",") for name in ("contour", "track"))
