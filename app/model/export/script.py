"""What was done in the window as a script: a program in Python, and a command line, which find the same contours.

Both begin from what is drawn and set at the moment. A simple document is written out; what a person has decided about
contours or edited by hand is read from the session file, since it is found again by its place on the contours.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from app.model.document.document import Document
from app.model.text.language import tr
from cpm_core.parameters import PRESETS, Parameters
from cpm_core.shapes import Barrier, Circle, Everywhere, Region, Shape, Sphere, Start, Stroke

_FLAGS = ("page", "time", "series")
"""Parts of a file that the command line has flags of the same name for."""

_NO_WORDS = tr("The command line has no words for all that is drawn in this volume; the program in Python has.")


@dataclass(frozen=True, slots=True)
class Script:
    """A workflow in words of the library and of the command line.

    Attributes
    ----------
    python : str
        The program.
    command : str
        The command line; empty where there is none.
    reads_session : bool
        Whether one of them reads the session file, which has to be saved for it.
    note : str
        What a reader should know, in a sentence or two; empty for nothing.
    """

    python: str
    command: str
    reads_session: bool
    note: str


def script_of(document: Document, session: Path) -> Script:
    """The script of a document on an image; `session` is its session file, which need not be there yet."""
    assert document.image is not None
    volume = document.image.is_volume
    if document.mode == "skeleton":
        return _of_skeleton(document)
    if document.marks or document.hand_edits or document.objects.barriers:
        command = "" if volume else _command_of_session(session, document)
        return Script(_python_of_session(session, document), command, True, _NO_WORDS if volume else "")
    python = _python(document, volume)
    command = _command_of_volume(document) if volume else _command(document)
    if not command and volume:
        return Script(python, "", False, _NO_WORDS)
    reads = not command
    return Script(python, command or _command_of_session(session, document), reads, "")


# Python


def _python(document: Document, volume: bool) -> str:
    image = document.image
    assert image is not None
    load = "load_volume" if volume else "load_image"
    return "\n".join(
        (
            *head(image.name),
            *imported(document.shapes),
            "",
            f"image = cpm.{load}({arguments(image.path, _reading(document))})",
            *written_out("parameters", "cpm.Parameters", changed(document.parameters, Parameters())),
            *listed("shapes", document.shapes),
            "",
            "result = cpm.segment(",
            "    image,",
            "    seeds_on(image, shapes, parameters.smoothing, parameters.channel),",
            "    parameters,",
            "    regions=regions_of(shapes),",
            "    charges=charges_of(shapes),",
            ")",
            f"cpm.export(result, {_result(document)!r})",
            "",
        )
    )


def _python_of_session(session: Path, document: Document) -> str:
    volume = document.is_about_volume
    return "\n".join(
        (
            *head(session.name, "from pathlib import Path", ""),
            "from cpm_core.contours.kept import with_kept",
            "from cpm_core.contours.review import apply",
            "from cpm_core.formats.sessions.session_file import find_image, load_session",
            "from cpm_core.segmentation.segment import with_hand_edits",
            "from cpm_core.shapes.document_shapes import charges_of, regions_of, seeds_on",
            "",
            f"path = Path({str(session)!r})",
            "session = load_session(path)",
            "file, _ = find_image(session.image, path.parent)",
            f"image = cpm.{'load_volume' if volume else 'load_image'}(file, **session.image.reading.arguments)",
            "parameters, shapes = session.parameters, session.shapes",
            "",
            "found = cpm.segment(",
            "    image,",
            "    seeds_on(image, shapes, parameters.smoothing, parameters.channel),",
            "    parameters,",
            "    regions=regions_of(shapes, session.objects.barriers),",
            "    charges=charges_of(shapes),",
            ")",
            "edited = with_hand_edits(found, image, parameters, session.hand_edits)",
            "whole = with_kept(edited, session.marks)",
            "result = apply(whole, session.marks, learning=session.learning, found=edited.contours)",
            f"cpm.export(result, {_result(document)!r})",
            "",
        )
    )


def _of_skeleton(document: Document) -> Script:
    """The skeleton of the image or volume, or of chosen objects and closed contours, which are written out."""
    image, lines = document.image, document.outlines
    assert image is not None
    volume = image.is_volume
    name = f"{Path(image.name).stem}_skeleton.{'swc' if volume else 'svg'}"
    given = changed(document.parameters, PRESETS["volume" if volume else "noisy"])
    of = ("outlines = (", *(f"    {line!r}," for line in lines), ")",
          "within = [cpm.Contour(np.array(line), closed=True) for line in outlines]") if lines else ()  # fmt: skip
    python = (
        *head(image.name, *(("import numpy as np", "") if lines else ())),
        "",
        f"image = cpm.load_{'volume' if volume else 'image'}({arguments(image.path, _reading(document))})",
        *written_out("parameters", "cpm.Parameters", changed(document.parameters, Parameters())),
        *of,
        f"cpm.export(cpm.skeleton(image, parameters{', within=within' if lines else ''}), {name!r})",
        "",
    )
    kind = ("--volume",) if volume else ()
    parts = ("cpm", "skeleton", image.path, *kind, *in_words(given), *_part(document), "--export", name)
    return Script("\n".join(python), "" if lines else shlex.join(parts), False, _left_out_of_skeleton(document))


def _left_out_of_skeleton(document: Document) -> str:
    """What the script of a skeleton leaves out, in a sentence or two."""
    notes = []
    if document.outlines:
        notes.append(tr("The command line has no words for chosen objects; the program in Python has."))
    if document.outlined_surfaces:
        notes.append(tr("The skeleton of the whole volume is found, not that of what was chosen."))
    if document.regions is not None:
        notes.append(tr("The skeleton is not kept to the region."))
    return " ".join(notes)


def imported(shapes: Iterable[Shape]) -> tuple[str, str]:
    """Lines that import what a program needs for shapes."""
    kinds = sorted({type(shape).__name__ for shape in shapes})
    return (
        f"from cpm_core.shapes import {', '.join(kinds)}",
        "from cpm_core.shapes.document_shapes import charges_of, regions_of, seeds_on",
    )


def listed(name: str, shapes: Iterable[Shape]) -> tuple[str, ...]:
    """Lines that give shapes a name."""
    return (f"{name} = (", *(f"    {shape!r}," for shape in shapes), ")")


def head(name: str, *more: str) -> tuple[str, ...]:
    """The first lines of a program."""
    return (
        f"# Finds the contours of {name!r} as they were found in the window of CPM.",
        "",
        *more,
        "import cpm_core as cpm",
    )


def written_out(name: str, called: str, given: dict[str, Any]) -> Iterable[str]:
    """Lines that give a name to what is made of values by name."""
    if not given:
        return (f"{name} = {called}()",)
    return (f"{name} = {called}(", *(f"    {key}={value!r}," for key, value in given.items()), ")")


def arguments(path: str, reading: dict[str, Any]) -> str:
    """A file, and how it is read, as arguments of a call."""
    return ", ".join((repr(str(Path(path).absolute())), *(f"{name}={value!r}" for name, value in reading.items())))


# The command line


def _command(document: Document) -> str:
    """The command with everything as flags; empty where it lacks one."""
    image, shapes = document.image, document.shapes
    assert image is not None
    if not set(_reading(document)) <= set(_FLAGS) or not in_order(shapes, (Circle, Stroke, Everywhere)):
        return ""
    given = in_words(changed(document.parameters, Parameters()))
    drawn = [part for shape in shapes for part in flag(shape)]
    return shlex.join(
        ("cpm", "run", _path(image.path), *drawn, *given, *_part(document), "--export", _result(document))
    )


def _command_of_volume(document: Document) -> str:
    image, shapes = document.image, document.shapes
    assert image is not None
    if _reading(document) or not shapes or not all(isinstance(shape, Sphere) for shape in shapes):
        return ""
    if any(shape.sides != (1.0, 1.0, 1.0) for shape in shapes if isinstance(shape, Sphere)):
        return ""
    given = in_words(changed(document.parameters, PRESETS["volume"]))
    drawn = [part for shape in shapes for part in flag(shape)]
    return shlex.join(("cpm", "run", _path(image.path), *drawn, *given, "--export", _result(document)))


def _command_of_session(session: Path, document: Document) -> str:
    return shlex.join(("cpm", "run", "--session", str(session), "--export", _result(document)))


def in_order(shapes: Sequence[Shape], starts: Sequence[type]) -> bool:
    """Whether the command line can name all shapes, and places their particles in the same order."""
    if not all(isinstance(shape, Region | Barrier | Start) for shape in shapes):
        return False
    kinds = [type(shape) for shape in shapes if isinstance(shape, Start)]
    if any(kind not in starts for kind in kinds) or kinds.count(Everywhere) > 1:
        return False
    order = [starts.index(kind) for kind in kinds]
    return order == sorted(order)


def flag(shape: Shape) -> tuple[str, ...]:
    """A shape in words of the command line; none for one that it has no words for."""
    if isinstance(shape, Circle | Sphere):
        return f"--{shape.title}", _numbers((*shape.center, shape.radius))
    if isinstance(shape, Everywhere):
        return "--auto", shape.kind
    if isinstance(shape, Stroke | Region | Barrier):
        name = {Stroke: "stroke", Region: "region", Barrier: "barrier"}[type(shape)]
        return f"--{name}", _numbers(value for point in shape.points for value in point)
    return ()


def _numbers(values: Iterable[float]) -> str:
    return ",".join(repr(float(value)) for value in values)


def in_words(given: dict[str, Any]) -> list[str]:
    """Parameters in words of the command line."""
    return [part for name, value in given.items() for part in (f"--{name.replace('_', '-')}", f"{value}")]


def _part(document: Document) -> list[str]:
    return [part for name, value in _reading(document).items() for part in (f"--{name}", f"{value}")]


# Of both


def changed(parameters: Parameters, standard: Parameters) -> dict[str, Any]:
    """Values that differ from the standard ones, by name."""
    values = {field.name: getattr(parameters, field.name) for field in fields(Parameters)}
    return {name: value for name, value in values.items() if value != getattr(standard, name)}


def _reading(document: Document) -> dict[str, Any]:
    return {} if document.image is None else document.image.reading.arguments


def _path(path: str) -> str:
    return str(Path(path).absolute())


def _result(document: Document) -> str:
    image = document.image
    assert image is not None
    return f"{Path(image.name).stem}_surface.ply" if image.is_volume else f"{Path(image.name).stem}_contours.svg"
