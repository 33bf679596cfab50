"""Command line: ``cpm run`` finds the contours of an image, ``cpm info`` tells what an image file holds. No window."""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from cpm_core.formats import READABLE, WRITABLE, check_export, export, load_image, load_points
from cpm_core.image import Image
from cpm_core.initialization import circle, gradient_threshold, uniform_grid
from cpm_core.parameters import PARAMETERS, PRESETS, Parameters
from cpm_core.particles import State
from cpm_core.result import Result
from cpm_core.segmentation import segment

BAD_INPUT = 2
INTERRUPTED = 130

_REDRAW = 0.1  # [s] between two lines of progress


class _Parser(argparse.ArgumentParser):
    """Parser that leaves it to `main` how an error is shown."""

    def error(self, message: str) -> NoReturn:
        raise ValueError(f"{message} (see {self.prog} --help).")


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments after the program's name; those of the process when left out.

    Returns
    -------
    int
        Exit status: 0 when done, 2 on bad input (one line on standard error, nothing written), 130 when interrupted.
    """
    try:
        arguments = _parser().parse_args(argv)
        command: Callable[[argparse.Namespace], None] = arguments.command
        command(arguments)
    except ValueError as error:
        print(f"cpm: {error}", file=sys.stderr)
        return BAD_INPUT
    except MemoryError:
        print("cpm: there is not enough memory for this: use a smaller image or fewer particles.", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print("cpm: interrupted; nothing was written.", file=sys.stderr)
        return INTERRUPTED
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="cpm",
        description="Find contours in images with charged particles.",
        epilog="Without a command the window opens, on the image that is named if there is one: cpm [IMAGE].",
        allow_abbrev=False,
    )
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    _add_run(commands.add_parser("run", help="find the contours of an image", allow_abbrev=False))
    _add_info(commands.add_parser("info", help="tell what an image file holds", allow_abbrev=False))
    return parser


def _add_run(parser: argparse.ArgumentParser) -> None:
    parser.set_defaults(command=_run)
    parser.description = "Let particles flow from a start to the contours of an image."
    _add_image(parser)
    start = parser.add_argument_group("start (one at least; several add up)")
    start.add_argument("--circle", metavar="ROW,COL,RADIUS", action="append", default=[], help="a circle, in px")
    start.add_argument("--points", metavar="FILE.csv", action="append", default=[], help="points: row,col on each line")
    start.add_argument("--auto", choices=("grid", "gradient"), help="everywhere, or on the strongest edges")
    parameters = parser.add_argument_group("parameters")
    parameters.add_argument("--preset", choices=tuple(PRESETS), default="shape", help="named settings (default: shape)")
    for info in PARAMETERS.values():
        parameters.add_argument(
            _flag(info.name),
            metavar=info.name.upper(),
            type=_number,
            dest=info.name,
            help=f"{info.meaning} {info.more} (default: {info.default})".replace("%", "%%"),
        )
    outcome = parser.add_argument_group("outcome")
    outcome.add_argument("--max-steps", metavar="N", type=_number, help="stop after so many steps at most")
    kinds = ", ".join(WRITABLE)
    outcome.add_argument(
        "--export", metavar="PATH", nargs="+", action="extend", default=[], help=f"write the contours ({kinds})"
    )
    _add_json(outcome)


def _add_info(parser: argparse.ArgumentParser) -> None:
    parser.set_defaults(command=_info)
    parser.description = "Tell the size, grey levels and pixel size of an image, and what reading it changed."
    _add_image(parser)
    _add_json(parser)


def _add_image(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("image", metavar="IMAGE", help=f"image file ({', '.join(READABLE)})")


def _add_json(parser: argparse._ActionsContainer) -> None:
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def _flag(name: str) -> str:
    return "--" + name.replace("_", "-")


def _number(text: str) -> int | float | str:
    """Turn text into a number if it is one; else leave it to the check of the value to say what is wanted."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def _run(arguments: argparse.Namespace) -> None:
    """Find the contours of an image; every check that needs no image comes first."""
    parameters = _parameters(arguments)
    max_steps = _max_steps(arguments.max_steps)
    drawn = _drawn(arguments)
    for path in arguments.export:
        check_export(path)
        if Path(path).resolve() == Path(arguments.image).resolve():
            raise ValueError(f"--export {path} would overwrite the image itself: choose another name.")
    image = load_image(arguments.image)
    seeds = np.concatenate([*drawn, *_automatic(arguments.auto, image, parameters)])
    started = time.perf_counter()
    progress = _Progress() if sys.stderr.isatty() else None
    try:
        result = segment(image, seeds, parameters, max_steps=max_steps, progress=progress)
    finally:
        if progress is not None:
            progress.clear()
    seconds = time.perf_counter() - started
    export(result, *arguments.export)
    _tell_result(result, seconds, arguments.export, as_json=arguments.json)


def _parameters(arguments: argparse.Namespace) -> Parameters:
    given = {field.name: getattr(arguments, field.name) for field in fields(Parameters)}
    return replace(PRESETS[arguments.preset], **{name: value for name, value in given.items() if value is not None})


def _max_steps(given: int | float | str | None) -> int | None:
    if given is None or (isinstance(given, int) and given > 0):
        return given
    raise ValueError(f"--max-steps is {given} but must be a whole number above 0.")


def _drawn(arguments: argparse.Namespace) -> list[NDArray[np.float64]]:
    """Particles of the circles and points on the command line."""
    if not (arguments.circle or arguments.points or arguments.auto):
        raise ValueError("No start is given: add --circle ROW,COL,RADIUS, --points FILE.csv or --auto grid.")
    return [*(_circle(text) for text in arguments.circle), *(load_points(path) for path in arguments.points)]


def _circle(text: str) -> NDArray[np.float64]:
    numbers = [_number(part.strip()) for part in text.split(",")]
    row, col, radius = (numbers + [""] * 3)[:3]
    if len(numbers) != 3 or isinstance(row, str) or isinstance(col, str) or isinstance(radius, str):
        raise ValueError(f'--circle is "{text}" but must be three numbers, ROW,COL,RADIUS in px.')
    return circle(center=(row, col), radius=radius)


def _automatic(kind: str | None, image: Image, parameters: Parameters) -> list[NDArray[np.float64]]:
    """Particles that need no drawing."""
    if kind == "grid":
        return [uniform_grid(image.shape)]
    if kind == "gradient":
        sigma = parameters.smoothing
        return [
            gradient_threshold(image.values, smoothing=sigma) if sigma != "auto" else gradient_threshold(image.values)
        ]
    return []


class _Progress:
    """A line on a terminal that says how far the run is."""

    def __init__(self) -> None:
        self._due = 0.0

    def __call__(self, state: State) -> None:
        now = time.monotonic()
        if now >= self._due:
            self._due = now + _REDRAW
            text = f"step {state.step}  scale {state.scale}  particles {state.count}"
            print(f"\r\x1b[2K{text}", end="", file=sys.stderr, flush=True)

    def clear(self) -> None:
        """Take the line away."""
        print("\r\x1b[2K", end="", file=sys.stderr, flush=True)


def _tell_result(result: Result, seconds: float, written: Sequence[str], *, as_json: bool) -> None:
    closed = sum(contour.closed for contour in result.contours)
    if as_json:
        facts = {
            "particles": len(result.particles),
            "contours": len(result.contours),
            "closed": closed,
            "steps": result.steps,
            "converged": result.converged,
            "stop_reason": result.stop_reason,
            "seconds": round(seconds, 3),
        }
        print(json.dumps(facts))
        return
    print(f"{result.source}: {_count(len(result.contours), 'contour')} ({closed} closed)")
    for number, contour in enumerate(result.contours[:10], start=1):
        kind = f"closed, area {contour.area:.1f} px²" if contour.closed else "open"
        print(f"  {number}. length {contour.length:.1f} px, {kind}, strength {contour.strength:.3g}")
    if len(result.contours) > 10:
        print(f"  ... and {len(result.contours) - 10} shorter ones")
    print(f"{_count(len(result.particles), 'particle')}, {_count(result.steps, 'step')} in {seconds:.2f} s")
    print(f"Stopped: {result.stop_reason}")
    for path in written:
        print(f"Wrote {path}")


def _info(arguments: argparse.Namespace) -> None:
    """Tell what an image file holds."""
    image = load_image(arguments.image)
    low, high = float(image.values.min()), float(image.values.max())
    if arguments.json:
        facts = {
            "source": image.source,
            "shape": list(image.shape),
            "minimum": low,
            "maximum": high,
            "spacing": list(image.spacing) if image.unit else None,
            "unit": image.unit,
            "notes": list(image.notes),
        }
        print(json.dumps(facts))
        return
    print(f"{image.source}: {image.shape[0]} rows x {image.shape[1]} columns, grey levels {low:g} to {high:g}")
    if image.unit:
        print(f"Size of a pixel: {image.spacing[0]:g} x {image.spacing[1]:g} {image.unit} (row x column)")
    else:
        print("Size of a pixel: the file does not tell")
    for note in image.notes:
        print(f"Note: {note}")


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"
