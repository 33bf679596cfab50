"""Session files: everything that is needed to continue work, or to repeat it without a window.

A session file is JSON that can be read and edited by hand: the image file, the shapes drawn on it, the parameters, the
review of the contours, and the view. The image stays in its own file; a hash shows whether it has changed.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path, PurePath
from typing import Any

from cpm_core.contours.contour import present_names
from cpm_core.contours.hand_edits import HandEdit
from cpm_core.contours.review import Mark
from cpm_core.formats.common.atomic import check_place, write_together
from cpm_core.formats.common.content import differ, fingerprint_if_read
from cpm_core.formats.common.provenance import PROGRAM
from cpm_core.formats.images.reading import DEFAULT, Reading
from cpm_core.formats.sessions.beside_document import TruthFile, beside_document, place_to_plain
from cpm_core.formats.sessions.compared_methods import compared_to_plain
from cpm_core.formats.sessions.plain_values import (
    from_plain,
    mapping,
    number,
    parameters_from_plain,
    shape_from_plain,
    shape_to_plain,
    to_plain,
)
from cpm_core.formats.sessions.session_json import MARK, VERSION, Plain, parsed, text_of
from cpm_core.medial_axis.outlines import Outlined
from cpm_core.objects.methods import Compared
from cpm_core.objects.segmented.segmented_object import SegmentedObjects
from cpm_core.parameters import Parameters
from cpm_core.parameters.quotation import shown
from cpm_core.shapes import Shape
from cpm_core.shapes.document_shapes import check_axes

SUFFIX = ".cpm"
"""Ending of the name of a session file."""

_KNOWN = (
    *(MARK, "program", "image", "shapes", "parameters", "marks", "mode"),
    *("objects", "outlined", "view", "hand_edits", "runs", "truth", "pages", "comparison"),
)
_LARGEST = 64 * 2**20
_LARGEST_SIDE = 10**6


@dataclass(frozen=True, slots=True)
class ImageFile:
    """The image that a session belongs to.

    Attributes
    ----------
    path : str
        Its file; a relative path starts at the folder of the session file.
    sha256 : str
        Hash of that file, as `fingerprint` makes it; empty where it is not known.
    shape : tuple of int
        (rows, cols), or (planes, rows, cols); empty where it is not known.
    elsewhere : tuple of str
        Other paths where it may be.
    reading : Reading
        Which part of the file it is, and the size of a pixel where it was said by hand.
    """

    path: str
    sha256: str = ""
    shape: tuple[int, ...] = ()
    elsewhere: tuple[str, ...] = ()
    reading: Reading = DEFAULT


@dataclass(frozen=True, slots=True)
class SessionFile:
    """Content of a session file.

    Attributes
    ----------
    image : ImageFile or None
        The image; None for a session that is for any image.
    shapes : tuple of Shape
        Starts, regions of interest, barriers and placed charges.
    parameters : Parameters
        Parameters of the run.
    marks : tuple of Mark
        Review of the contours.
    mode : str
        Mode of the window; empty for the default.
    objects : SegmentedObjects
        The objects that have been selected, with their classes.
    outlined : Outlined
        What has a skeleton in place of what is found in the image.
    view : mapping
        View of the window, as plain JSON; without effect on a run.
    extra : mapping
        Entries of other versions, kept when the file is written again.
    notes : tuple of str
        Messages from reading, one sentence each.
    hand_edits : tuple of HandEdit
        Edits of the contours by hand, in the order in which they were made.
    runs : mapping
        Recorded runs of the window, as plain JSON; without effect on a run.
    truth : TruthFile or None
        The ground truth that contours are compared with.
    pages : mapping
        The other pages of a stack, as plain JSON of the window; without effect on a run.
    comparison : Compared
        The methods that are compared.
    """

    image: ImageFile | None = None
    shapes: tuple[Shape, ...] = ()
    parameters: Parameters = field(default_factory=Parameters)
    marks: tuple[Mark, ...] = ()
    mode: str = ""
    objects: SegmentedObjects = field(default_factory=SegmentedObjects)
    outlined: Outlined = field(default_factory=Outlined)
    view: Plain = field(default_factory=dict)
    extra: Plain = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    hand_edits: tuple[HandEdit, ...] = ()
    runs: Plain = field(default_factory=dict)
    truth: TruthFile | None = None
    pages: Plain = field(default_factory=dict)
    comparison: Compared = field(default_factory=Compared)


def save_session(session: SessionFile, path: Path) -> None:
    """Write a session file atomically.

    Parameters
    ----------
    session : SessionFile
        Content. The path of its image is written as an absolute path, and relative to the file when it is in the folder
        of the file or below.
    path : Path
        Target; an existing file is replaced.

    Raises
    ------
    ValueError
        When it cannot be written, or could not be read again.
    """
    path = Path(path)
    check_place(path)
    content = encode(session, path.parent)
    if len(content) > _LARGEST:
        raise ValueError(
            f"{path.name} would take {len(content) >> 20} MB, but at most {_LARGEST >> 20} MB can be read again: "
            "delete runs or objects, and save it then."
        )
    write_together([(path, content)])


def encode(session: SessionFile, folder: Path) -> bytes:
    """The bytes of a session file that lies in a folder; ValueError for shapes that could not be read again."""
    check_axes(session.shapes, session.image.shape if session.image else ())
    plain: dict[str, Any] = {MARK: VERSION, "program": PROGRAM}
    if session.image is not None:
        plain["image"] = _image_to_plain(session.image, folder)
    plain["shapes"] = [shape_to_plain(shape) for shape in session.shapes]
    plain["parameters"] = to_plain(session.parameters)
    plain["marks"] = [to_plain(mark) for mark in session.marks]
    if session.hand_edits:
        plain["hand_edits"] = [to_plain(edit) for edit in session.hand_edits]
    if session.comparison != Compared():
        plain["comparison"] = compared_to_plain(session.comparison)
    plain["mode"] = session.mode
    plain |= {"objects": to_plain(session.objects), "outlined": to_plain(session.outlined), "view": dict(session.view)}
    if session.truth is not None:
        plain["truth"] = {**to_plain(session.truth), **place_to_plain(session.truth.path, folder)}
    plain.update(session.extra)
    if session.runs:
        plain["runs"] = dict(session.runs)
    if session.pages:
        plain["pages"] = dict(session.pages)
    return text_of(plain).encode()


def load_session(path: Path) -> SessionFile:
    """Read a session file.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    SessionFile
        Its content, checked; the path of its image is not looked up yet, see `find_image`.

    Raises
    ------
    ValueError
        When there is no such file, or it is not a valid session file; one sentence that says what is wrong.
    """
    path = Path(path)
    try:
        if path.is_dir():
            raise ValueError(f"{path} is a folder: choose a session file in it.")
        if path.stat().st_size > _LARGEST:
            raise ValueError(f"{path.name} is too large to be a session file.")
        content = path.read_bytes()
    except FileNotFoundError:
        raise ValueError(f"{path} does not exist: check its name and folder.") from None
    except OSError as error:
        raise ValueError(f"{path} cannot be read: {error.strerror or error}.") from error
    return decode(content, path.name)


def decode(content: bytes, name: str) -> SessionFile:
    """Content of the bytes of a session file; `name` is its name in error messages."""
    plain = parsed(content, name)
    try:
        parameters, unknown = parameters_from_plain(plain.get("parameters", {}))
        runs, pages, truth, comparison, faults = beside_document(plain)
        left_out = f"Parameters that are not known here were left out: {shown(', '.join(unknown))}."
        image = _image(plain["image"]) if plain.get("image") is not None else None
        shapes = tuple(shape_from_plain(shape, f"shape {index}") for index, shape in _listed(plain, "shapes"))
        check_axes(shapes, image.shape if image else ())
        return SessionFile(
            image=image,
            shapes=shapes,
            parameters=parameters,
            marks=tuple(_mark(mark, f"mark {index}") for index, mark in _listed(plain, "marks")),
            mode=_text_of(plain.get("mode", ""), "mode"),
            objects=from_plain(SegmentedObjects, plain.get("objects", {}), "objects"),
            outlined=from_plain(Outlined, plain.get("outlined", {}), "outlined"),
            view=mapping(plain.get("view", {}), "view"),
            extra={key: value for key, value in plain.items() if key not in _KNOWN},
            notes=(*((left_out,) if unknown else ()), *faults),
            runs=runs,
            truth=truth,
            pages=pages,
            comparison=comparison,
            hand_edits=tuple(
                from_plain(HandEdit, edit, f"edit {index} by hand") for index, edit in _listed(plain, "hand_edits")
            ),
        )
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from error


def _mark(plain: object, where: str) -> Mark:
    return from_plain(Mark, present_names(mapping(plain, where)), where)


def find_image(
    image: ImageFile, folder: Path, go_on: Callable[[], None] = lambda: None
) -> tuple[Path, tuple[str, ...]]:
    """Find the image of a session.

    Parameters
    ----------
    image : ImageFile
        Entry of the session file.
    folder : Path
        Folder of the session file.
    go_on : callable, optional
        Called while the image is compared with the one that the session knows; raises to stop.

    Returns
    -------
    path : Path
        Its file.
    notes : tuple of str
        A warning when the image has changed since.

    Raises
    ------
    ValueError
        When it is not found; the sentence names the paths that were tried.
    """
    candidates = dict.fromkeys(folder / place for place in (image.path, *image.elsewhere, PurePath(image.path).name))
    for candidate in candidates:
        if _is_file(candidate):
            found = candidate.resolve()
            if image.sha256 and differ(image.sha256, fingerprint_if_read(found, go_on)):
                return found, (f"{found.name} has changed since the session was saved: shapes may be misplaced.",)
            return found, ()
    looked = " or ".join(str(candidate) for candidate in candidates)
    raise ValueError(f"The image of the session was not found at {looked}: put it there, or name it.")


def _image(plain: object) -> ImageFile:
    given = mapping(plain, "image")
    path = _text_of(given.get("path"), "path of image")
    absolute = _text_of(given.get("absolute", ""), "absolute of image")
    sha256 = _text_of(given.get("sha256", ""), "sha256 of image").lower()
    if not path or "\0" in path + absolute:
        raise ValueError(f"path of image is {shown(path)} but must name a file.")
    if sha256 and not re.fullmatch("(sampled:)?[0-9a-f]{64}", sha256):
        raise ValueError(f"sha256 of image is {shown(sha256)} but must be 64 hexadecimal digits.")
    shape = given.get("shape", [])
    listed = shape if isinstance(shape, list) else [0]
    sides = tuple(int(number(side, "shape of image", _LARGEST_SIDE)) for side in listed)
    if len(sides) not in (0, 2, 3) or any(side < 1 for side in sides):
        raise ValueError(f"shape of image is {shown(shape)} but must be rows and columns.")
    reading = Reading.of(mapping(given.get("reading", {}), "reading of image"))
    return ImageFile(path, sha256, sides, (absolute,) if absolute else (), reading)


def _image_to_plain(image: ImageFile, folder: Path) -> dict[str, Any]:
    plain = place_to_plain(image.path, folder)
    if not Path(image.path).is_absolute() and image.elsewhere:
        plain["absolute"] = image.elsewhere[0]
    plain |= {"sha256": image.sha256, "shape": list(image.shape)}
    chosen = {name: to_plain(given) for name, given in image.reading.arguments.items()}
    return {**plain, "reading": chosen} if chosen else plain


def _listed(plain: Plain, name: str) -> list[tuple[int, object]]:
    """The items of a list with their numbers, counted from one; empty where the entry is missing."""
    items = plain.get(name, [])
    if not isinstance(items, list):
        raise ValueError(f"{name} is {shown(items)} but must be a list.")
    return list(enumerate(items, start=1))


def _text_of(value: object, where: str) -> str:
    if not isinstance(value, str):
        raise ValueError(f"{where} is {shown(value)} but must be text.")
    return value


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # names that no file can have
        return False
