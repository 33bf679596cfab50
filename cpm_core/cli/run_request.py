"""What ``cpm run`` is asked for: its arguments, parsed once and checked without the image."""

from __future__ import annotations

import argparse
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from cpm_core.chunked import results, volume_results
from cpm_core.chunked.chunk_run import CHUNKED_START_KINDS
from cpm_core.cli.arguments import (
    SURFACE_FIELDS,
    check_exports,
    check_targets,
    collect_surface_options,
    group_coordinates,
    parse_number_list,
    parse_number_or_text,
    parse_parameters,
    parse_part,
    refuse_options,
)
from cpm_core.cli.inputs import load_named_session, locate_image, read_starts
from cpm_core.field.volume_field import check_volume_parameters
from cpm_core.formats import (
    CENTERLINES_WRITABLE,
    SURFACES_READABLE,
    VOLUMES_WRITABLE,
    find_format_suffix,
    load_points,
)
from cpm_core.formats.common.atomic import check_target, check_writable, find_suffix
from cpm_core.formats.images.multiscale import MultiscaleImage
from cpm_core.formats.images.ome_zarr import is_zarr
from cpm_core.formats.images.readers import open_levels, open_stack
from cpm_core.formats.images.reading import Reading
from cpm_core.formats.sessions.session_file import SESSION_SUFFIX, SessionFile
from cpm_core.formats.sessions.session_run import is_volume_session
from cpm_core.formats.stack_files import STACKS_WRITABLE
from cpm_core.image.colors import LUMINANCE_CHOICE
from cpm_core.image.image import Image
from cpm_core.image.volume_regions import VolumeRegions
from cpm_core.numerics.polyline import as_line
from cpm_core.numerics.types import JsonDict, JsonObject, Texts, frozen
from cpm_core.objects.prior.larger_models import check_model
from cpm_core.objects.segmented import Click
from cpm_core.objects.segmented.segmented_object import Clicks
from cpm_core.parameters import PRESETS, UNLIMITED_REACH, Parameters
from cpm_core.parameters.formatting import quote_value
from cpm_core.segmentation.evolve import DEFAULT_METHOD
from cpm_core.shapes import (
    Barrier,
    Charge,
    Circle,
    Everywhere,
    Points,
    Polygon,
    PolygonRegion,
    SeedingKind,
    Shape,
    Sphere,
    Stroke,
)
from cpm_core.shapes.document_shapes import collect_regions, select_starts

_OptionNumbers = Mapping[str, Sequence[tuple[float, ...]]]
"""Numbers that the options of shapes and places were given, by option."""

_VOLUME_START_SUFFIXES = {*SURFACES_READABLE, *CENTERLINES_WRITABLE}
"""Suffixes of the files of starts that lie in volumes."""

_PLANE_OPTIONS = (
    "session",
    "circle",
    "polygon",
    "stroke",
    "points",
    "start",
    "region",
    "barrier",
    "charge",
    "save_session",
)
"""Options by which a plane of a volume is run as an image."""


@frozen
class RunRequest:
    """A run that the command line asks for.

    Attributes
    ----------
    path : Path
        The image, volume or stack.
    part : mapping
        Further arguments of the function that reads it.
    is_volume : bool
        Whether a surface is found in a volume.
    is_chunked : bool
        Whether the run works chunk by chunk.
    session : SessionFile
        The session that is named, else an empty one.
    has_session_image : bool
        Whether the image is the one of the session.
    parameters : Parameters
        Parameters of the run.
    fits_scales : bool
        Whether the number of scales is reduced to those that the image has room for.
    max_steps : int or None
        Largest number of steps.
    drawn : tuple of Shape
        Shapes of the command line; spheres are not yet adapted to the sides of a voxel.
    start_files : tuple of str
        Files with further starts.
    default_starts : tuple of Shape
        The starts of a run for which nothing is named but objects; otherwise empty.
    seeding : str or None
        Where particles start automatically.
    volume_regions : VolumeRegions or None
        Limits in a volume, with those of the session; None where only the session has some.
    clicked : tuple of tuple of Click
        Clicks of each object that is selected.
    model : str
        The larger model that answers them; empty for the network.
    all_objects : bool
        Whether the objects that the run proposes are found.
    picked : str or None
        Numbers of those that are taken; None for all.
    pages : str or None
        Pages of a stack that are run; without them, the image is run.
    follows_pages : bool
        Whether each page starts from the contours of the one before.
    exports : sequence of str
        Files to write.
    surface_options : mapping
        How files of a surface are written: options of `export`.
    truth_file, session_file : str or None
        The ground truth to compare with, and the session to write.
    workers, scheduler : int or None, str or None
        Number of processes, or address of a cluster, of a run chunk by chunk.
    as_json : bool
        Whether the outcome is printed as JSON.
    """

    path: Path
    part: JsonObject
    is_volume: bool
    is_chunked: bool
    session: SessionFile
    has_session_image: bool
    parameters: Parameters
    fits_scales: bool
    max_steps: int | None
    drawn: tuple[Shape, ...]
    start_files: Texts
    default_starts: tuple[Shape, ...]
    seeding: SeedingKind | None
    volume_regions: VolumeRegions | None
    clicked: tuple[Clicks, ...]
    model: str
    all_objects: bool
    picked: str | None
    pages: str | None
    follows_pages: bool
    exports: Sequence[str]
    surface_options: JsonObject
    truth_file: str | None
    session_file: str | None
    workers: int | None
    scheduler: str | None
    as_json: bool

    def collect_drawn_shapes(self, image: Image) -> tuple[Shape, ...]:
        """Collect the shapes of the session and of the command line, its spheres round in the voxels of the image."""
        drawn = (
            Sphere.from_voxel_size(shape.center, shape.radius, image.spacing) if isinstance(shape, Sphere) else shape
            for shape in self.drawn
        )
        return (*self.session.shapes, *drawn)

    def collect_shapes(self, image: Image) -> tuple[Shape, ...]:
        """Collect all shapes of a run on an image: those drawn, those of files, and default starts."""
        files = (start for path in self.start_files for start in read_starts(path, image))
        return (*self.collect_drawn_shapes(image), *files, *self.default_starts)

    def describe_start_files(self) -> list[JsonDict]:
        """Return the files whose contours a run starts from, as session files hold shapes."""
        return [{"shape": "points", "file": Path(path).name} for path in self.start_files]


def parse_run_request(arguments: argparse.Namespace) -> RunRequest:
    """Parse the arguments of ``cpm run``; ValueError for those that are wrong, or have no meaning together."""
    session = load_named_session(arguments)
    if arguments.method:
        session = replace(session, mode="" if arguments.method == DEFAULT_METHOD else arguments.method)
    is_volume = _names_volume(arguments, session)
    _check_options(arguments, session, is_volume)
    numbers = _parse_option_numbers(arguments, is_volume)
    clicked = _parse_clicks(arguments, is_volume)
    if arguments.model and not clicked:
        raise ValueError("--model is given without --object: name a position inside the object as well.")
    check_model(arguments.model, 3 if is_volume else 2)
    preset = arguments.preset or ("volume" if is_volume and not arguments.session else None)
    part = parse_part(arguments, volume=is_volume)
    parameters = parse_parameters(arguments, PRESETS[preset] if preset else session.parameters)
    path, reading = locate_image(arguments.image, session, arguments.session)
    proposes = bool(arguments.objects or arguments.pick)
    is_chunked = _open_chunked_image(arguments, path) is not None
    if is_chunked:
        _check_chunked_run(arguments, path, parameters, is_volume)
    else:
        _check_whole_run(arguments, path, is_volume)
    if arguments.pages is not None:
        reading.pop("page", None)
    return RunRequest(
        path=path,
        part=reading | part,
        is_volume=is_volume,
        is_chunked=is_chunked,
        session=session,
        has_session_image=arguments.image is None,
        parameters=parameters,
        fits_scales=arguments.scales is None,
        max_steps=arguments.max_steps,
        drawn=_build_drawn_shapes(arguments, numbers, is_volume),
        start_files=tuple(arguments.start),
        default_starts=() if _has_start(arguments, session) or (is_volume and not proposes) else (Everywhere("grid"),),
        seeding=arguments.auto,
        volume_regions=_build_volume_regions(numbers, session) if is_volume else None,
        clicked=clicked,
        model=arguments.model,
        all_objects=proposes,
        picked=arguments.pick,
        pages=arguments.pages,
        follows_pages=arguments.follow,
        exports=arguments.export,
        surface_options=collect_surface_options(arguments),
        truth_file=arguments.truth,
        session_file=arguments.save_session,
        workers=arguments.workers,
        scheduler=arguments.scheduler,
        as_json=arguments.json,
    )


def _names_volume(arguments: argparse.Namespace, session: SessionFile) -> bool:
    """Tell whether the arguments are about a volume."""
    return bool(
        arguments.sphere
        or arguments.volume
        or is_volume_session(session)
        or _opens_volume(arguments)
        or any(Path(path).suffix.lower() in _VOLUME_START_SUFFIXES for path in arguments.start)
    )


def _open_chunked_image(arguments: argparse.Namespace, path: Path) -> MultiscaleImage | None:
    """Open the image of a run chunk by chunk: of one everywhere in an image that is read in parts; else None."""
    if not arguments.auto or not path.name or (path.is_dir() and not is_zarr(path)):
        return None
    series: Any = arguments.series and parse_number_or_text(arguments.series)
    return open_levels(path, Reading(series=series))


def _opens_volume(arguments: argparse.Namespace) -> bool:
    """Tell whether the image is a volume, where nothing is named that may lie in one of its planes."""
    path = Path(arguments.image or "")
    if arguments.page or arguments.pages:
        return False
    levels = _open_chunked_image(arguments, path)
    if levels is not None:
        return levels.axis_length("z") > 1
    places = (*arguments.object, *getattr(arguments, "not"))
    in_plane = any(text.count(",") != 2 for text in places) or any(getattr(arguments, name) for name in _PLANE_OPTIONS)
    if in_plane or not path.exists() or not path.name:
        return False
    series: Any = arguments.series and parse_number_or_text(arguments.series)
    return open_stack(path, series).default_plane > 0


def _parse_option_numbers(arguments: argparse.Namespace, is_volume: bool) -> _OptionNumbers:
    """Parse the numbers of shapes and places."""
    place = "PLANE,ROW,COL" if is_volume else "ROW,COL"
    forms = {
        "sphere" if is_volume else "circle": f"{place},RADIUS",
        "stroke": f"{place},...",
        **dict.fromkeys(("region", "barrier"), f"{place},{place if is_volume else '...'}"),
        "charge": f"{place},STRENGTH",
        "polygon": f"{place},...",
    }
    return {
        name: [parse_number_list(f"--{name}", text, form, is_xy=arguments.xy) for text in getattr(arguments, name)]
        for name, form in forms.items()
    }


def _parse_clicks(arguments: argparse.Namespace, is_volume: bool) -> tuple[Clicks, ...]:
    """Parse the places inside and outside of objects, with the sizes of candidates, in their order."""
    deep = [name for name in ("object", "not") for text in getattr(arguments, name) if text.count(",") == 2]
    if deep and not is_volume:
        raise ValueError(f"--{deep[0]} has a plane, a row and a column: add --volume, or give ROW,COL in an image.")
    axes, form = (3, "PLANE,ROW,COL,...") if is_volume else (2, "ROW,COL,...")
    objects: list[Clicks] = [()]
    for name, text in getattr(arguments, "clicks", ()):
        if name == "and":
            objects.append(())
        elif name == "larger":
            if not objects[-1]:
                raise ValueError("--larger is given before a place: name one by --object first.")
            if not re.fullmatch(r"[+-]?\d{1,3}", text, re.ASCII):
                raise ValueError(
                    f"--larger is {quote_value(text)} but must be a whole number of sizes, such as 1 or -2."
                )
            objects[-1] = (*objects[-1][:-1], replace(objects[-1][-1], step=int(text)))
        else:
            numbers = parse_number_list(f"--{name}", text, form, is_xy=arguments.xy)
            objects[-1] += (Click(group_coordinates(numbers, axes), name == "object"),)
    if not all(any(click.inside for click in clicks) for clicks in objects) and objects != [()]:
        raise ValueError("--not or --and is given without --object: name a place inside the object as well.")
    return tuple(filter(None, objects))


def _build_drawn_shapes(arguments: argparse.Namespace, numbers: _OptionNumbers, is_volume: bool) -> tuple[Shape, ...]:
    """Build the shapes of the command line; in a volume limits are no shapes, see `_build_volume_regions`."""
    axes = 3 if is_volume else 2
    shapes: list[Shape] = [Stroke(group_coordinates(line, axes)) for line in numbers["stroke"]]
    shapes += [Charge(tuple(place), strength) for *place, strength in numbers["charge"]]
    shapes += [Points(as_line(load_points(path, axes))) for path in arguments.points]
    everywhere = [Everywhere(arguments.auto)] if arguments.auto else []
    if is_volume:
        return (*(Sphere(tuple(center), radius) for *center, radius in numbers["sphere"]), *shapes, *everywhere)
    circles = (Circle((row, col), radius) for row, col, radius in numbers["circle"])
    polygons = (Polygon(group_coordinates(line, 2)) for line in numbers["polygon"])
    regions = (PolygonRegion(group_coordinates(line, 2)) for line in numbers["region"])
    barriers = (Barrier(group_coordinates(line, 2)) for line in numbers["barrier"])
    return (*circles, *polygons, *shapes, *regions, *barriers, *everywhere)


def _build_volume_regions(numbers: _OptionNumbers, session: SessionFile) -> VolumeRegions | None:
    """Build boxes of interest and planes as barriers, with the limits of a session; None where none is drawn."""
    if not (numbers["region"] or numbers["barrier"]):
        return None
    saved = collect_regions(session.shapes, session.objects.barriers)
    before = saved if isinstance(saved, VolumeRegions) else VolumeRegions()
    boxes, planes = (
        tuple(((a, b, c), (d, e, f)) for a, b, c, d, e, f in numbers[name]) for name in ("region", "barrier")
    )
    return VolumeRegions((*before.interest, *boxes), (*before.barriers, *planes))


def _has_start(arguments: argparse.Namespace, session: SessionFile) -> bool:
    """Tell whether the arguments or the session have a start."""
    names = ("circle", "polygon", "sphere", "stroke", "points", "start")
    return bool(any(getattr(arguments, name) for name in names) or arguments.auto or select_starts(session.shapes))


def _check_options(arguments: argparse.Namespace, session: SessionFile, is_volume: bool) -> None:
    """Raise ValueError for options that have no meaning for this run."""
    if is_volume:
        refuse_options(arguments, ("circle", "polygon", "pages", "save_session"), "images, but a volume is run")
    else:
        refuse_options(arguments, SURFACE_FIELDS, "volumes, but an image is run")
    if not (arguments.objects or arguments.pick or arguments.object or _has_start(arguments, session)):
        if session.mode == "skeleton":
            raise ValueError("The session is for a skeleton and has no start: use cpm skeleton IMAGE --export PATH.")
        raise ValueError(
            "No start is given: add --circle ROW,COL,RADIUS (in a volume --sphere PLANE,ROW,COL,RADIUS) or --auto "
            "grid, name a place inside an object, --object ROW,COL, or see cpm run --help all for other starts."
        )
    if arguments.save_session is not None:
        if Path(arguments.save_session).suffix.lower() != SESSION_SUFFIX:
            raise ValueError(f"--save-session is {arguments.save_session} but must end in {SESSION_SUFFIX}.")
        check_writable(Path(arguments.save_session))


def _check_whole_run(arguments: argparse.Namespace, path: Path, is_volume: bool) -> None:
    """Raise ValueError for what does not work on an image or a volume in one piece."""
    refuse_options(arguments, ("scheduler", "workers"), "images in folders of Zarr that are run everywhere, by --auto")
    for target in arguments.export if is_volume else ():
        if find_format_suffix(target) not in VOLUMES_WRITABLE:
            raise ValueError(
                f"{target} is for contours, but a volume has a surface: end its name in .ply, .stl or .csv, or name a "
                "plane by --page."
            )
    if arguments.pages is None:
        check_exports(arguments.export, arguments, path)
    else:
        _check_pages(arguments, path)


def _check_pages(arguments: argparse.Namespace, path: Path) -> None:
    """Raise ValueError for what does not work on the pages of a stack."""
    if arguments.object and not arguments.follow:
        raise ValueError("--object is on the first of the pages: add --follow, which finds the object on the others.")
    if arguments.objects:
        refuse_options(arguments, ("object",), "one object, but --objects finds those of each page")
    alone = ("and", "larger", "pick", "page", "truth", "save_session", "method")
    refuse_options(arguments, alone, "one image, but --pages runs several")
    for target in arguments.export:
        check_target(target, STACKS_WRITABLE, "for all pages of a stack")
    check_targets(arguments.export, arguments, path)


def _check_chunked_run(arguments: argparse.Namespace, path: Path, parameters: Parameters, is_volume: bool) -> None:
    """Raise ValueError for what does not work chunk by chunk."""
    drawn = ("circle", "polygon", "stroke", "points", "sphere", "start", "region", "barrier", "charge")
    other = ("object", "not", "pick", "session", "pages", "truth", *SURFACE_FIELDS, "save_session", "method")
    refuse_options(arguments, (*drawn, *other), "an image that is run in one piece")
    if arguments.auto not in CHUNKED_START_KINDS:
        raise ValueError(
            f"--auto is {arguments.auto}, which looks at the whole image: use one of {', '.join(CHUNKED_START_KINDS)}."
        )
    if parameters.channel != LUMINANCE_CHOICE:
        raise ValueError(f"--channel is {parameters.channel}, but its channels have numbers: give one from 1.")
    if parameters.edges == "vessels":
        raise ValueError("--edges vessels looks at the whole image at once: use gradient, or a smaller image.")
    if parameters.reach < UNLIMITED_REACH:
        raise ValueError("--reach is for a start that is drawn: leave it out.")
    writable = volume_results.WRITERS if is_volume else results.WRITERS
    if not arguments.export:
        raise ValueError(f"--export is missing: name files that end in {', '.join(writable)}.")
    for target in arguments.export:
        if not find_suffix(target, writable):
            raise ValueError(f"{target} cannot be written chunk by chunk: choose one of {', '.join(writable)}.")
        if Path(target).is_dir() and not is_zarr(Path(target)):
            raise ValueError(f"{target} is a folder, which would be replaced: choose another name.")
        if not Path(target).absolute().parent.is_dir():
            raise ValueError(f"{target} cannot be written: there is no such folder.")
    check_targets(arguments.export, arguments, path)
    if is_volume:
        check_volume_parameters(parameters)
        if parameters.gamma != 1.0:
            raise ValueError("--gamma looks at the whole volume at once: leave it at 1, or run a smaller volume.")
