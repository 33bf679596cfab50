"""Session files: everything needed to continue work, or to repeat it without a window.

A session file is JSON that can be read and edited by hand: the image file, the shapes drawn on it, the parameters, the
objects, and the view. The image stays in its own file; a hash shows whether it has changed.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import field, fields, replace
from functools import partial
from pathlib import Path, PurePath
from typing import Annotated, Any, TypeVar

from cpm_core.formats.common.atomic import check_writable, write_together
from cpm_core.formats.common.content import read_content, try_fingerprint
from cpm_core.formats.common.json_values import (
    encode_json,
    expect_list,
    expect_mapping,
    expect_text,
    from_json,
    parameters_from_json,
    shape_from_json,
    shape_to_json,
    to_json,
)
from cpm_core.formats.common.provenance import PROGRAM_NAME
from cpm_core.formats.images.readers import open_stack
from cpm_core.formats.images.reading import DEFAULT_READING, Reading
from cpm_core.medial_axis.outlines import SkeletonTarget
from cpm_core.numerics.types import Callback, Integers, JsonDict, JsonObject, Texts, frozen
from cpm_core.objects.segmented.segmented_object import SegmentedObjects
from cpm_core.parameters import Parameters
from cpm_core.parameters.formatting import quote_value
from cpm_core.shapes import Shape
from cpm_core.shapes.document_shapes import check_axes

Entry = TypeVar("Entry")

SESSION_MARK = "cpm-session"
"""Key that distinguishes a session file from other JSON."""

SESSION_VERSION = 3
"""Version of the format: value of this entry."""

SESSION_SUFFIX = ".cpm"
"""Suffix of session files."""

_MAX_SESSION_SIZE = 64 * 2**20
"""Largest size of a session file [bytes]."""


@frozen
class ImageFile:
    """An image of a session: the one that it belongs to, or a second one that lies over it.

    Attributes
    ----------
    path : str
        Its file; a relative path starts at the folder of the session file.
    sha256 : str
        Hash of that file, as returned by `compute_fingerprint`; empty if unknown.
    shape : tuple of int
        (rows, cols), or (planes, rows, cols); empty if unknown.
    absolute : str
        Another path where it may be.
    reading : Reading
        Part of the file, and the pixel size if it was entered by hand.
    """

    path: str
    sha256: str = ""
    shape: Annotated[Integers, 0, 2, 3] = ()
    absolute: str = ""
    reading: Reading = DEFAULT_READING


@frozen
class TruthFile:
    """The ground truth of a session.

    Attributes
    ----------
    path : str
        Its file; a relative path starts at the folder of the session file.
    absolute : str
        Another path where it may be.
    tolerance : float
        Distance up to which boundaries count as the same [px].
    holes : bool
        Whether a contour inside another one is a hole.
    """

    path: str
    absolute: str = ""
    tolerance: float = 2.0
    holes: bool = True


def locate_file(file: TruthFile | ImageFile, folder: Path) -> Path:
    """Return where a file of a session in a folder is: beside it, or else at its absolute path."""
    beside = folder / file.path
    return beside if beside.exists() or not file.absolute else Path(file.absolute)


@frozen
class SessionFile:
    """Content of a session file.

    Attributes
    ----------
    image : ImageFile or None
        The image; None for a session that applies to any image.
    shapes : tuple of Shape
        Starts, regions of interest, barriers and placed charges.
    parameters : Parameters
        Parameters of the run.
    mode : str
        Mode of the window; empty for the default.
    objects : SegmentedObjects
        The objects that have been selected, with their classes.
    outlined : SkeletonTarget
        Outlines that have a skeleton in place of structures found in the image.
    view : mapping
        View of the window, as JSON; no effect on a run.
    extra : mapping
        Entries of other versions, kept when the file is written again.
    notes : tuple of str
        Messages from reading, one sentence each.
    runs : mapping
        Recorded runs of the window, as JSON; no effect on a run.
    truth : TruthFile or None
        The ground truth that contours are compared with.
    second : ImageFile or None
        The second image; no effect on a run.
    pages : mapping
        The other pages of a stack, as JSON of the window; no effect on a run.
    """

    image: ImageFile | None = None
    shapes: tuple[Shape, ...] = ()
    parameters: Parameters = field(default_factory=Parameters)
    mode: str = ""
    objects: SegmentedObjects = field(default_factory=SegmentedObjects)
    outlined: SkeletonTarget = field(default_factory=SkeletonTarget)
    view: JsonObject = field(default_factory=dict)
    extra: JsonObject = field(default_factory=dict)
    notes: Texts = ()
    runs: JsonObject = field(default_factory=dict)
    truth: TruthFile | None = None
    second: ImageFile | None = None
    pages: JsonObject = field(default_factory=dict)


_KNOWN_ENTRIES = {SESSION_MARK, "program", *(one.name for one in fields(SessionFile))} - {"extra", "notes"}
"""Keys that this version knows; others are kept in `SessionFile.extra`."""


def save_session(session: SessionFile, path: Path) -> None:
    """Write a session file atomically.

    Parameters
    ----------
    session : SessionFile
        Content. The path of its image is written as an absolute path, and also relative to the file if it is in or
        below the folder of the file, or in the folder around it.
    path : Path
        Target; an existing file is replaced.

    Raises
    ------
    ValueError
        When it cannot be written, or could not be read again.
    """
    path = Path(path)
    check_writable(path)
    content = encode_session(session, path.parent)
    if len(content) > _MAX_SESSION_SIZE:
        raise ValueError(
            f"{path.name} would take {len(content) >> 20} MB, but at most {_MAX_SESSION_SIZE >> 20} MB can be read "
            "again: delete runs or objects, and save it then."
        )
    write_together([(path, content)])


def encode_session(session: SessionFile, folder: Path) -> bytes:
    """Encode a session file in a folder; ValueError for shapes that could not be read again."""
    check_axes(session.shapes, session.image.shape if session.image else ())
    plain: JsonDict = {SESSION_MARK: SESSION_VERSION, "program": PROGRAM_NAME}
    if session.image is not None:
        plain["image"] = _part_to_json(session.image, folder)
    plain["shapes"] = [shape_to_json(shape) for shape in session.shapes]
    plain["parameters"] = to_json(session.parameters)
    plain["mode"] = session.mode
    plain |= {"objects": to_json(session.objects), "outlined": to_json(session.outlined), "view": dict(session.view)}
    if session.truth is not None:
        plain["truth"] = {**to_json(session.truth), **_place_to_json(session.truth.path, folder)}
    if session.second is not None:
        plain["second"] = _part_to_json(session.second, folder)
    plain.update(session.extra)
    if session.runs:
        plain["runs"] = dict(session.runs)
    if session.pages:
        plain["pages"] = dict(session.pages)
    return encode_json(plain)


def load_session(path: Path) -> SessionFile:
    """Read a session file.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    SessionFile
        Its content, checked; the image is not located yet, see `find_session_image`.

    Raises
    ------
    ValueError
        When there is no such file, or it is not a valid session file; one sentence that says what is wrong.
    """
    path = Path(path)
    return decode_session(read_content(path, _MAX_SESSION_SIZE), path.name)


def decode_session(content: bytes, name: str) -> SessionFile:
    """Decode a session file; `name` is its name in messages."""
    plain = _parse_session(content, name)
    notes: list[str] = []

    def read_optional(key: str, words: str, read: Callable[[Any, str], Entry], otherwise: Entry) -> Entry:
        """Read an optional entry; if it is damaged, it is left out with a note."""
        try:
            return read(plain[key], key) if plain.get(key) is not None else otherwise
        except (ValueError, TypeError, KeyError) as error:
            notes.append(f"The {words} left out: {error}")
            return otherwise

    try:
        parameters, unknown = parameters_from_json(plain.get("parameters", {}))
        if unknown:
            notes.append(f"Parameters that are not known here were left out: {quote_value(', '.join(unknown))}.")
        image = None if plain.get("image") is None else from_json(ImageFile, plain["image"], "image")
        drawn = enumerate(expect_list(plain.get("shapes", []), "shapes"), start=1)
        shapes = tuple(shape_from_json(one, f"shape {number}") for number, one in drawn)
        check_axes(shapes, image.shape if image else ())
        return SessionFile(
            image=image,
            shapes=shapes,
            parameters=parameters,
            mode=expect_text(plain.get("mode", ""), "mode"),
            objects=from_json(SegmentedObjects, plain.get("objects", {}), "objects"),
            outlined=from_json(SkeletonTarget, plain.get("outlined", {}), "outlined"),
            view=_expect_finite_entries(plain.get("view", {}), "view"),
            extra=_expect_finite_entries(
                {key: value for key, value in plain.items() if key not in _KNOWN_ENTRIES}, "the session"
            ),
            runs=read_optional("runs", "recorded runs were", _expect_finite_entries, {}),
            truth=read_optional("truth", "ground truth was", partial(from_json, TruthFile), None),
            second=read_optional("second", "second image was", partial(from_json, ImageFile), None),
            pages=read_optional("pages", "other pages of the stack were", _expect_finite_entries, {}),
            notes=tuple(notes),
        )
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from error


def _expect_finite_entries(given: object, where: str) -> JsonObject:
    """Return an object that is kept as it is; ValueError for infinite numbers, which Python reads and JSON lacks."""
    entries = expect_mapping(given, where)
    try:
        json.dumps(entries, allow_nan=False)
    except ValueError as error:
        raise ValueError(f"{where} holds a number that is not finite.") from error
    return entries


def find_session_image(image: ImageFile, folder: Path, check_cancelled: Callback = lambda: None) -> tuple[Path, Texts]:
    """Find the image of a session.

    Parameters
    ----------
    image : ImageFile
        Entry of the session file.
    folder : Path
        Folder of the session file.
    check_cancelled : callable, optional
        Called while the image is hashed to compare it with that of the session; raises to stop.

    Returns
    -------
    path : Path
        Its file, or its folder.
    notes : tuple of str
        A warning when the image has changed since.

    Raises
    ------
    ValueError
        When it is not found; the sentence names the paths that were tried.
    """
    candidates = dict.fromkeys(
        folder / place for place in (image.path, image.absolute or image.path, PurePath(image.path).name)
    )
    for candidate in candidates:
        if candidate != folder and os.path.exists(candidate):  # noqa: PTH110 - raises nothing
            found = candidate.resolve()
            if image.sha256 not in ("", try_fingerprint(found, check_cancelled)):
                return found, (f"{found.name} has changed since the session was saved: shapes may be misplaced.",)
            return found, ()
    looked = " or ".join(str(candidate) for candidate in candidates)
    raise ValueError(f"The image of the session was not found at {looked}: put it there, or name it.")


def _part_to_json(part: ImageFile, folder: Path) -> JsonDict:
    """Convert a part of a file to JSON, with those options of its reading that are not the default."""
    read = {name: to_json(given) for name, given in part.reading.arguments.items()}
    return {**to_json(part), **_place_to_json(part.path, folder), "reading": read}


def _place_to_json(place: str, folder: Path) -> JsonDict:
    """Convert a path to JSON: absolute, and relative to a folder if it is in or below it, or in the one around it."""
    path, folder = Path(place), folder.resolve()
    if path.is_absolute() and path.is_relative_to(folder):
        return {"path": path.relative_to(folder).as_posix(), "absolute": str(path)}
    if path.is_absolute() and path.parent == folder.parent:
        return {"path": f"../{path.name}", "absolute": str(path)}
    return {"path": place}


def _parse_session(content: bytes, name: str) -> JsonObject:
    """Parse the JSON of a session file; ValueError when it is damaged, of another kind, or of an unknown version."""
    try:
        plain = json.loads(content.decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        place = f" (line {error.lineno})" if isinstance(error, json.JSONDecodeError) else ""
        raise ValueError(f"{name} is not a session file, or a damaged one{place}: get a sound copy of it.") from error
    if not isinstance(plain, dict) or SESSION_MARK not in plain:
        raise ValueError(f"{name} is not a session file: it has no entry {SESSION_MARK}.")
    version = plain[SESSION_MARK]
    if version != SESSION_VERSION or isinstance(version, bool):
        raise ValueError(
            f"{name} is a session file of version {quote_value(version)}, but only version {SESSION_VERSION} is known "
            "here: open it with the version of CPM that saved it."
        )
    return plain


def adapt_reading(path: Path, reading: Reading) -> JsonDict:
    """Return the arguments of `load_image` that read another file as a session reads its own.

    Page, channel and point in time are selected in a file that holds several. A pixel size set by hand applies if the
    file has none.

    Raises
    ------
    ValueError
        When the file cannot be used, or has no such series.
    """
    if reading == DEFAULT_READING:
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
