"""``cpm export``: writes what a session shows, or contours and surfaces of a file, in other formats."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from cpm_core.cli.arguments import add_json, add_space, check_exports
from cpm_core.cli.export.files import of_file
from cpm_core.cli.export.sessions import of_session
from cpm_core.cli.inputs.numbers import as_number
from cpm_core.cli.outcome import Files, tell
from cpm_core.cli.terminal import counted, say
from cpm_core.contours.result import Result
from cpm_core.formats import (
    CONTOURS_READABLE,
    FOR_CENTERLINES,
    FOR_VOLUMES,
    SURFACES_READABLE,
    WRITABLE,
    left_out,
    suffix_of,
)
from cpm_core.formats.provenance import ENTRY, facts_of, facts_on
from cpm_core.formats.sessions.session_file import SUFFIX
from cpm_core.medial_axis.space.centerlines import Centerlines
from cpm_core.parameters.quotation import shown


def add_to(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command to those of the command line."""
    parser = commands.add_parser("export", help="write a session or contours in other formats", allow_abbrev=False)
    parser.set_defaults(command=_export)
    parser.description = (
        "Write the contours or the surface that a session shows, or those of a file, in other formats. A session "
        "without a recorded run is run first."
    )
    known = ", ".join((*CONTOURS_READABLE, *SURFACES_READABLE, *FOR_CENTERLINES))
    parser.add_argument(
        "source", metavar="FILE", help=f"session ({SUFFIX}), contours, a surface or center lines ({known}), or labels"
    )
    parser.add_argument("--image", metavar="IMAGE", help="the image or volume that it belongs to")
    parser.add_argument("--page", metavar="N", type=as_number, help="page of contours in a stack, from 1")
    parser.add_argument(
        "--to",
        metavar="PATH",
        nargs="+",
        action="extend",
        required=True,
        help=f"files to write ({', '.join(dict.fromkeys((*WRITABLE, *FOR_VOLUMES, *FOR_CENTERLINES)))})",
    )
    parser.add_argument("--outlines", action="store_true", help="lines in label masks, open ones too, instead of areas")
    add_space(parser)
    add_json(parser)


def _export(arguments: argparse.Namespace) -> int:
    """Write the files, after all checks that need none of them."""
    source = Path(arguments.source)
    check_exports(arguments.to, arguments, flag="--to")
    _check_page(arguments.page, source)
    result: Result | Centerlines
    if source.suffix.lower() == SUFFIX:
        result, image = of_session(source, arguments)
    else:
        result, image = of_file(source, arguments), arguments.image
    files = Files()
    files.export(
        result,
        arguments.to,
        image=image,
        outlines=arguments.outlines,
        space=arguments.space or "LPS",
        tell=lambda sentence: say(f"cpm: {sentence}"),
    )
    files.check()
    missing = {path: left_out(result, suffix_of(path), outlines=arguments.outlines) for path in files.written}
    told, line = _told(result, source)
    facts = {"source": str(source), "left_out": missing, "not_written": files.refused, **told}
    tell("export", facts, [line], files.written, as_json=arguments.json)
    return files.status()


def _check_page(page: int | float | str | None, source: Path) -> None:
    """Raise ValueError unless a page is a number, of a file that may have several."""
    if page is None:
        return
    if source.suffix.lower() == SUFFIX:
        raise ValueError(f"--page is for contours in a stack, but {source.name} is a session: leave it out.")
    if not isinstance(page, int) or page < 1:
        raise ValueError(f"--page is {shown(page)} but must be a whole number from 1 up.")


def _told(result: Result | Centerlines, source: Path) -> tuple[dict[str, Any], str]:
    """What is told of a result, as plain JSON and as a line."""
    closed = sum(contour.closed for contour in result.contours)
    facts: dict[str, Any] = {"contours": len(result.contours), "closed": closed}
    if isinstance(result, Centerlines):
        facts[ENTRY] = facts_on(result.source, result.provenance)
        return facts, f"{source.name}: {counted(len(result.contours), 'center line')} ({closed} closed)"
    facts[ENTRY] = facts_of(result)
    if result.surface is None:
        return facts, f"{source.name}: {counted(len(result.contours), 'contour')} ({closed} closed)"
    vertices, faces = len(result.surface.vertices), len(result.surface.faces)
    facts |= {"vertices": vertices, "faces": faces}
    return facts, f"{source.name}: a surface of {counted(faces, 'triangle')}, with {vertices} corners"
