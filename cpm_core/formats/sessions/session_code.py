"""The work of a session as a Python script and as a command, which find the same objects."""

from __future__ import annotations

import os
import shlex
import subprocess
from collections.abc import Iterable, Iterator
from dataclasses import fields
from pathlib import Path

from cpm_core.formats.sessions.session_file import SessionFile
from cpm_core.formats.sessions.session_run import is_volume_session
from cpm_core.image.colors import CONTRAST_CHOICE, LUMINANCE_CHOICE
from cpm_core.numerics.types import Integers, Line, Place, Texts, frozen
from cpm_core.objects.segmented.segmented_object import Click, Clicks
from cpm_core.parameters import PRESETS, Parameters
from cpm_core.shapes import (
    Barrier,
    Charge,
    Circle,
    EnclosedRegion,
    EnclosingWall,
    Everywhere,
    Polygon,
    PolygonRegion,
    Shape,
    Stroke,
    select_starts,
)

_DRAWN_OPTIONS: dict[type[Shape], str] = {
    Circle: "circle",
    Polygon: "polygon",
    Stroke: "stroke",
    Charge: "charge",
    PolygonRegion: "region",
    Barrier: "barrier",
    Everywhere: "auto",
}
"""Option of ``cpm run`` for each shape that has one, in the order in which a run takes them."""


@frozen
class SessionCode:
    """What a script or a command repeats: a run, and the objects that are taken of it.

    Attributes
    ----------
    session : SessionFile
        Image, shapes, parameters and mode of the run; without a start, that of `cpm_core.partition`.
    picked : tuple of int or None
        Indices of the objects that the run proposes; None for all of them where there are no clicks.
    clicked : tuple of tuple of Click
        Clicks of further objects.
    file : str
        Where the session is saved, or empty.
    """

    session: SessionFile
    picked: Integers | None = None
    clicked: tuple[Clicks, ...] = ()
    file: str = ""

    def write_script(self) -> str:
        """Write a Python script; empty where only a saved session could say what was drawn."""
        session, drawn = self.session, self.session.shapes
        assert session.image is not None
        reading = "".join(f", {name}={given!r}" for name, given in session.image.reading.arguments.items())
        load = "load_volume" if is_volume_session(session) else "load_image"
        lines = [f"image = cpm.{load}({os.fspath(session.image.path)!r}{reading})"]
        imports, given = {"import cpm_core as cpm"}, "image"
        if any(isinstance(shape, EnclosedRegion | EnclosingWall) for shape in drawn):
            if not self.file:
                return ""
            lines.append(f"result = cpm.run(image, {self.file!r})")
            given = "result"
        elif select_starts(drawn):
            names = sorted({type(shape).__name__ for shape in drawn})
            imports |= {"from cpm_core.formats import SessionFile", f"from cpm_core.shapes import {', '.join(names)}"}
            parameters, differing = _format_parameters(session.parameters)
            imports |= {"from dataclasses import replace"} if differing else set()
            mode = f", mode={session.mode!r}" if session.mode == "published" else ""
            lines += ["shapes = (", *(f"    {shape!r}," for shape in drawn), ")", f"parameters = {parameters}"]
            lines.append(f"result = cpm.run(image, SessionFile(shapes=shapes, parameters=parameters{mode}))")
            given = "result"
        lines += self._write_objects(given)
        imports |= {"from cpm_core.objects.segmented import Click, select_by_clicks"} if self.clicked else set()
        head = sorted(imports, key=lambda line: ("dataclasses" not in line, line.startswith("from"), line))
        return "\n".join([*head, "", *lines, 'print(*objects, sep="\\n")', ""])

    def _write_objects(self, given: str) -> Iterator[str]:
        """Write the lines that take the objects of a result, or of an image."""
        own = "result.objects" if self.picked is None else f"[result.objects[index] for index in {self.picked}]"
        if not self.clicked:
            yield f"objects = {own}"
            return
        yield "clicks = ["
        for clicks in self.clicked:
            yield f"    [{', '.join(map(_format_click, clicks))}],"
        yield "]"
        if self.picked:
            yield f"proposed = {own}"
            yield f"objects = [*proposed, *select_by_clicks(cpm.partition({given}), clicks, proposed)]"
        else:
            yield f"objects = select_by_clicks(cpm.partition({given}), clicks)"

    def write_command(self) -> str:
        """Write a command line; empty where only a saved session could say what was drawn."""
        words = self._write_run()
        if words is None and self.file:
            words = ["cpm", "run", self.file]
        if words is None:
            return ""
        image = self.session.image
        assert image is not None
        export = ("--export", _name_of_objects(image.path, is_volume_session(self.session)))
        return join_words([*words, *self._write_chosen(), *export])

    def _write_run(self) -> list[str] | None:
        """Write the options of the run; None where they cannot express it."""
        session, drawn = self.session, self.session.shapes
        assert session.image is not None
        reading, options = session.image.reading, tuple(_DRAWN_OPTIONS)
        volume, starts = is_volume_session(session), select_starts(drawn)
        known = all(type(shape) in _DRAWN_OPTIONS and not (volume and shape not in starts) for shape in drawn)
        ordered = sorted(starts, key=lambda start: options.index(type(start))) if known else ()
        doubled = sum(isinstance(start, Everywhere) for start in starts) > 1
        if tuple(ordered) != starts or doubled or not all(isinstance(one, Everywhere) or not volume for one in starts):
            return None
        if reading.color not in (LUMINANCE_CHOICE, CONTRAST_CHOICE) or (reading.spacing and not reading.unit):
            return None
        words = ["cpm", "run", session.image.path, *(["--volume"] if volume else [])]
        for name in ("page", "time", "series", "channel"):
            words += [f"--{name}", str(getattr(reading, name))] if getattr(reading, name) is not None else []
        words += ["--channel", CONTRAST_CHOICE] if reading.color == CONTRAST_CHOICE else []
        if reading.spacing:
            words += ["--pixel-size", f"{'x'.join(map(_format_number, reading.spacing))}{reading.unit}"]
        for shape in drawn:
            words += [f"--{_DRAWN_OPTIONS[type(shape)]}", _format_shape(shape)]
        preset, differing = _find_nearest_preset(session.parameters)
        if "channel" in differing and "--channel" in words:
            return None
        words += ["--preset", preset] if starts and (volume or preset != "published") else []
        for name in differing if starts else ():
            words += [f"--{name.replace('_', '-')}", _format_number(getattr(session.parameters, name))]
        return [*words, *(["--method", "published"] if session.mode == "published" else [])]

    def _write_chosen(self) -> Iterator[str]:
        """Write the options of the objects."""
        if self.picked is not None:
            yield from ("--pick", ",".join(str(index + 1) for index in self.picked))
        elif not self.clicked:
            yield "--objects"
        for number, clicks in enumerate(self.clicked):
            yield from ("--and",) if number else ()
            for click in clicks:
                yield from ("--object" if click.inside else "--not", _format_places(click.places))
                yield from ("--larger", str(click.step)) if click.step else ()


def write_saved_objects_script(session: SessionFile, file: str) -> str:
    """Write a script that takes the objects of a saved session as they are."""
    shape = () if session.image is None else session.image.shape
    return f"""from pathlib import Path

from cpm_core.formats import load_session
from cpm_core.objects.segmented import selection_from_object

session = load_session(Path({file!r}))
objects = [selection_from_object(item, {shape!r}) for item in session.objects.items]
print(*objects, sep="\\n")
"""


def write_saved_objects_command(session: SessionFile, file: str) -> str:
    """Write a command that takes the objects of a saved session as they are."""
    target = _name_of_objects(file, is_volume_session(session))
    return join_words(["cpm", "export", file, "--objects", "--to", target])


def _name_of_objects(file: str, in_volume: bool) -> str:
    """Return the name of the file of the objects of an image, or of a session."""
    return f"{Path(file).stem}_objects{'.tif' if in_volume else '.geojson'}"


def join_words(words: Iterable[str]) -> str:
    """Join words to a line for the shell of this system."""
    return subprocess.list2cmdline([*words]) if os.name == "nt" else shlex.join(words)


def _format_click(click: Click) -> str:
    """Format a click as Python."""
    others = ("" if click.inside else ", inside=False") + (f", step={click.step}" if click.step else "")
    return f"Click({click.places!r}{others})"


def _format_number(number: object) -> str:
    return repr(number).removesuffix(".0") if isinstance(number, float) else str(number)


def _format_places(places: Iterable[Place]) -> str:
    return ",".join(_format_number(number) for place in places for number in place)


def _format_shape(shape: Shape) -> str:
    """Format the value of the option for a shape."""
    match shape:
        case Everywhere():
            return shape.kind
        case Circle():
            return _format_places([(*shape.center, shape.radius)])
        case Charge():
            return _format_places([(*shape.position, shape.strength)])
        case _:
            line: Line = shape.points  # type: ignore[union-attr]
            return _format_places(line)


def _find_nearest_preset(parameters: Parameters) -> tuple[str, Texts]:
    """Find the preset with the fewest other values, and the names of these."""
    differing = {
        name: tuple(
            one.name for one in fields(Parameters) if getattr(preset, one.name) != getattr(parameters, one.name)
        )
        for name, preset in PRESETS.items()
    }
    name = min(("published", *differing), key=lambda name: len(differing[name]))
    return name, differing[name]


def _format_parameters(parameters: Parameters) -> tuple[str, Texts]:
    """Format parameters as Python, with the names of those that differ from a preset."""
    preset, differing = _find_nearest_preset(parameters)
    changes = "".join(f", {name}={getattr(parameters, name)!r}" for name in differing)
    base = f"cpm.PRESETS[{preset!r}]"
    return (f"replace({base}{changes})" if differing else base), differing
