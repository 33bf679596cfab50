"""Session files: everything that is needed to take work up again, or to repeat it without a window.

A session file is JSON that a person can read and edit: which image, what is drawn on it, the parameters, what has been
said about the contours, and how it was looked at. The image itself stays in its own file; a hash tells whether it is
still the same.
"""

from __future__ import annotations

import hashlib
import json
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path, PurePath
from types import MappingProxyType
from typing import Any, NoReturn

from cpm_core.contours.review import Mark
from cpm_core.formats.atomic import write_together
from cpm_core.formats.sessions.plain_values import LARGEST, from_plain, number, shown, to_plain
from cpm_core.parameters import Parameters
from cpm_core.shapes import SHAPES, Shape

SUFFIX = ".cpm"
"""Ending of the name of a session file."""

VERSION = 1

_MARK = "cpm-session"
"""The key that tells a session file from other JSON; its value is the version."""

_KNOWN = (_MARK, "image", "shapes", "parameters", "marks", "mode", "view")
_LARGEST = 64 * 2**20
_LARGEST_SIDE = 10**6
_DEEPEST = 64
_LEAST: Mapping[str, int] = MappingProxyType(
    {"region": 3, "polygon": 3, "grid": 3, "threshold": 3, "barrier": 2, "stroke": 1, "points": 1}
)
"""Corners without which a shape is none."""
_LIMITS: Mapping[str, tuple[float, float]] = MappingProxyType(
    {
        "radius": (0.5, 1e5),
        "radii": (0.5, 1e5),
        "spacing": (0.5, 1e5),
        "fraction": (0.0, 1.0),
        "strength": (-10.0, 10.0),
    }
)
"""Ranges of the values of shapes, by the names that they have in all of them."""

_UNPAIRED = re.compile("[\ud800-\udfff]")

Plain = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class ImageFile:
    """Which image a session belongs to.

    Attributes
    ----------
    path : str
        Its file; a relative one is meant from the folder of the session file.
    sha256 : str
        Hash of that file, 64 hexadecimal digits; empty where it is not known.
    shape : tuple of int
        (rows, cols); empty where it is not known.
    elsewhere : tuple of str
        Other places where it may be.
    """

    path: str
    sha256: str = ""
    shape: tuple[int, ...] = ()
    elsewhere: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class SessionFile:
    """What a session file holds.

    Attributes
    ----------
    image : ImageFile or None
        The image; None for a session that is meant for any.
    shapes : tuple of Shape
        What is drawn: starts, regions of interest, barriers, placed charges.
    parameters : Parameters
        Parameters of the run.
    marks : tuple of Mark
        What has been said about contours.
    mode : str
        What the window was set up for, empty for nothing in particular.
    view : mapping
        How the window looked at it, as plain JSON; of no concern to a run.
    extra : mapping
        What another version has added, kept when the file is written again.
    notes : tuple of str
        What a person should know about the reading, one sentence each.
    """

    image: ImageFile | None = None
    shapes: tuple[Shape, ...] = ()
    parameters: Parameters = field(default_factory=Parameters)
    marks: tuple[Mark, ...] = ()
    mode: str = ""
    view: Plain = field(default_factory=dict)
    extra: Plain = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def fingerprint(path: Path) -> str:
    """Hash of a file (SHA-256), 64 hexadecimal digits; empty when it cannot be read."""
    try:
        with path.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except OSError:
        return ""


def save_session(session: SessionFile, path: Path) -> None:
    """Write a session file in one stroke.

    Parameters
    ----------
    session : SessionFile
        What to keep. The path of its image is written relative to the file when it lies beside or below it, and in
        full as well.
    path : Path
        Where to; a file that exists is replaced.

    Raises
    ------
    ValueError
        When it cannot be written there.
    """
    path = Path(path)
    if path.is_dir():
        raise ValueError(f"{path} is a folder: name a file in it.")
    if not path.parent.is_dir():
        raise ValueError(f"{path} cannot be written: there is no folder {path.parent}.")
    write_together([(path, encode(session, path.parent))])


def encode(session: SessionFile, folder: Path) -> bytes:
    """The bytes of a session file that lies in a folder."""
    plain: dict[str, Any] = {_MARK: VERSION}
    if session.image is not None:
        plain["image"] = _image_to_plain(session.image, folder)
    plain["shapes"] = [shape_to_plain(shape) for shape in session.shapes]
    plain["parameters"] = to_plain(session.parameters)
    plain["marks"] = [to_plain(mark) for mark in session.marks]
    plain["mode"] = session.mode
    plain["view"] = dict(session.view)
    plain.update(session.extra)
    return _text(plain).encode()


def load_session(path: Path) -> SessionFile:
    """Read a session file.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    SessionFile
        What it holds, everything checked; the path of its image is not looked up yet, see `find_image`.

    Raises
    ------
    ValueError
        When there is no such file, or it is none that can be used; one sentence that says what is wrong.
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
    """What the bytes of a session file hold; `name` is for sentences."""
    plain = _parsed(content, name)
    try:
        parameters, notes = _parameters(plain.get("parameters", {}))
        return SessionFile(
            image=_image(plain["image"]) if plain.get("image") is not None else None,
            shapes=tuple(shape_from_plain(shape, f"shape {index}") for index, shape in _listed(plain, "shapes")),
            parameters=parameters,
            marks=tuple(from_plain(Mark, mark, f"mark {index}") for index, mark in _listed(plain, "marks")),
            mode=_text_of(plain.get("mode", ""), "mode"),
            view=_mapping(plain.get("view", {}), "view"),
            extra={key: value for key, value in plain.items() if key not in _KNOWN},
            notes=notes,
        )
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from error


def find_image(image: ImageFile, folder: Path) -> tuple[Path, tuple[str, ...]]:
    """Where the image of a session is now.

    Parameters
    ----------
    image : ImageFile
        What the session file says.
    folder : Path
        Folder of the session file.

    Returns
    -------
    path : Path
        Its file.
    notes : tuple of str
        A warning when the image is not the one that the session was made with.

    Raises
    ------
    ValueError
        When it is nowhere; the sentence says where it was looked for.
    """
    candidates = dict.fromkeys(folder / place for place in (image.path, *image.elsewhere, PurePath(image.path).name))
    for candidate in candidates:
        if _is_file(candidate):
            found = candidate.resolve()
            if image.sha256 and fingerprint(found) != image.sha256:
                return found, (f"{found.name} has changed since the session was saved: what is drawn may lie off.",)
            return found, ()
    looked = " or ".join(str(candidate) for candidate in candidates)
    raise ValueError(f"The image of the session was not found at {looked}: put it there, or name it.")


def shape_to_plain(shape: Shape) -> dict[str, Any]:
    """A shape as JSON keeps it: its kind and the values of its fields."""
    kind = next(name for name, made in SHAPES.items() if type(shape) is made)
    return {"shape": kind, **to_plain(shape)}


def shape_from_plain(plain: object, where: str) -> Shape:
    """A shape from what JSON has kept of it; ValueError when it is none, or none that could be drawn."""
    values = dict(_mapping(plain, where))
    kind = values.pop("shape", None)
    if not isinstance(kind, str) or kind not in SHAPES:
        raise ValueError(f"{where} is of the kind {shown(kind)} but must be one of {', '.join(SHAPES)}.")
    where = f"{where} ({kind})"
    for name, value in values.items():
        low, high = _LIMITS.get(name, (-LARGEST, LARGEST))
        for each in value if isinstance(value, list) else [value]:
            if isinstance(each, int | float) and not low <= each <= high:
                raise ValueError(f"{name} of {where} is {shown(each)} but must be a number from {low:g} to {high:g}.")
    shape = from_plain(SHAPES[kind], values, where)
    for name in ("points", "positions"):
        different, least = len(set(getattr(shape, name, ()))), _LEAST.get(kind, 1)
        if name in values and different < least:
            raise ValueError(f"{where} has {different} different {name} but needs at least {least}.")
    return shape


def _parsed(content: bytes, name: str) -> Plain:
    """The JSON of a session file, once it is certain to be one of a version that is known."""

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
    if not isinstance(plain, dict) or _MARK not in plain:
        raise ValueError(f"{name} is no session file: it does not say {_MARK}.")
    if _depth(plain) > _DEEPEST:
        raise ValueError(f"{name} is no session file: its values lie within each other too deeply.")
    version = plain[_MARK]
    if version != VERSION or isinstance(version, bool):
        raise ValueError(
            f"{name} is a session file of version {shown(version)}, but only version {VERSION} is known here: "
            "get a newer CPM for it."
        )
    return plain


def _parameters(plain: object) -> tuple[Parameters, tuple[str, ...]]:
    """Parameters, and what is to be told about those that are unknown; those that are missing have their defaults."""
    given = _mapping(plain, "parameters")
    known = {each.name for each in fields(Parameters)}
    values = {name: value for name, value in given.items() if name in known}
    for name, value in values.items():
        if not isinstance(value, str):
            number(value, name, 1e9)
    if isinstance(values.get("scales"), float) and values["scales"] == int(values["scales"]):
        values["scales"] = int(values["scales"])
    unknown = sorted(set(given) - known)
    told = f"Parameters that are not known here were left out: {shown(', '.join(unknown))}."
    return Parameters(**values), (told,) if unknown else ()


def _image(plain: object) -> ImageFile:
    given = _mapping(plain, "image")
    path = _text_of(given.get("path"), "path of image")
    absolute = _text_of(given.get("absolute", ""), "absolute of image")
    sha256 = _text_of(given.get("sha256", ""), "sha256 of image").lower()
    if not path or "\0" in path + absolute:
        raise ValueError(f"path of image is {shown(path)} but must name a file.")
    if sha256 and not re.fullmatch("[0-9a-f]{64}", sha256):
        raise ValueError(f"sha256 of image is {shown(sha256)} but must be 64 hexadecimal digits.")
    shape = given.get("shape", [])
    if not isinstance(shape, list) or len(shape) not in (0, 2):
        raise ValueError(f"shape of image is {shown(shape)} but must be rows and columns.")
    sides = tuple(int(number(side, "shape of image", _LARGEST_SIDE)) for side in shape)
    if any(side < 1 for side in sides):
        raise ValueError(f"shape of image is {shown(shape)} but must be rows and columns.")
    return ImageFile(path, sha256, sides, (absolute,) if absolute else ())


def _image_to_plain(image: ImageFile, folder: Path) -> dict[str, Any]:
    path, folder = Path(image.path), folder.resolve()
    plain: dict[str, Any] = {"path": image.path}
    if path.is_absolute():
        if path.is_relative_to(folder):
            plain = {"path": path.relative_to(folder).as_posix(), "absolute": str(path)}
    elif image.elsewhere:
        plain["absolute"] = image.elsewhere[0]
    return {**plain, "sha256": image.sha256, "shape": list(image.shape)}


def _listed(plain: Plain, name: str) -> list[tuple[int, object]]:
    """The items of a list with their numbers, counted from one; an empty one where it is missing."""
    items = plain.get(name, [])
    if not isinstance(items, list):
        raise ValueError(f"{name} is {shown(items)} but must be a list.")
    return list(enumerate(items, start=1))


def _mapping(value: object, where: str) -> Plain:
    if not isinstance(value, Mapping):
        raise ValueError(f"{where} is {shown(value)} but must be an object with named values.")
    return value


def _text_of(value: object, where: str) -> str:
    if not isinstance(value, str):
        raise ValueError(f"{where} is {shown(value)} but must be text.")
    return value


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # names that no file can have
        return False


def _text(plain: Plain) -> str:
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
