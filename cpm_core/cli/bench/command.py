"""``cpm bench``: measures times on this machine, beside other methods and lower bounds."""

from __future__ import annotations

import argparse
import time
from dataclasses import asdict

from cpm_core.cli.arguments import add_json
from cpm_core.cli.bench.measurement import QUICK, UNHURRIED, Measurement
from cpm_core.cli.bench.table import machine, measurements
from cpm_core.cli.compare.report import report_claims
from cpm_core.cli.outcome import print_json
from cpm_core.formats import load_image

_WHAT, _TIME, _PEER = 44, 11, 40
"""Widths of the table's columns [characters]."""


def add_to(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command to those of the command line."""
    parser = commands.add_parser("bench", help="measure how fast it is here", allow_abbrev=False)
    parser.set_defaults(command=_bench)
    parser.description = (
        "Measure how fast this is on your machine: whole runs and their parts, beside other methods and lower bounds. "
        "Each time is a median, without compilation. It takes about a minute."
    )
    parser.add_argument("--image", metavar="PATH", help="image for the whole runs (default: a scene of 398 x 548 px)")
    parser.add_argument("--quick", action="store_true", help="a few seconds: smaller inputs, fewer repeats")
    parser.add_argument(
        "--claims",
        action="store_true",
        help="test the claims of the publication beside classical methods on drawn images, which takes minutes",
    )
    add_json(parser)


def _bench(arguments: argparse.Namespace) -> None:
    """Measure, with a line for each measurement as soon as it is known."""
    if arguments.claims:
        if arguments.image is not None or arguments.quick:
            raise ValueError("--claims has images of its own, each run once: leave out --image and --quick.")
        report_claims(as_json=arguments.json)
        return
    image = None if arguments.image is None else load_image(arguments.image)
    began = time.perf_counter()
    rows = measurements(QUICK if arguments.quick else UNHURRIED, image)
    here = machine()
    if arguments.json:
        entries = [asdict(row) | {"ratio": row.ratio} for row in rows]
        facts = {"machine": here, "quick": arguments.quick, "seconds": time.perf_counter() - began}
        print_json("bench", facts | {"measurements": entries})
        return
    for number, row in enumerate(rows):
        if number == 0:  # a bad image has raised an error by now
            print(", ".join(f"{name} {value}" for name, value in here.items()))
            print(f"{'':{_WHAT}}{'ours':>{_TIME}}  {'beside it':{_PEER}}{'':>{_TIME}}  ours/it")
        print(_line(row), flush=True)
    print(f"{time.perf_counter() - began:.0f} s in all")


def _line(row: Measurement) -> str:
    """Line of the table."""
    text = f"{row.what:{_WHAT}}{_time(row.value, row.unit):>{_TIME}}"
    if row.ratio is not None and row.peer_value is not None:
        text += f"  {row.peer:{_PEER}}{_time(row.peer_value, row.unit):>{_TIME}}  {row.ratio:.2g}"
    more = [row.note] if row.note else []
    if row.error is not None:
        more.append(f"error {row.error:.0e}")
    if row.growth is not None:
        more.append(f"growth {row.growth:.2f}")
    return "  ".join([text, *more])


def _time(value: float, unit: str) -> str:
    """Time with three digits, in a unit that fits its size."""
    seconds = value * {"s": 1.0, "ms": 1e-3}[unit]
    factor, shown = (1.0, "s") if seconds >= 1.0 else (1e3, "ms") if seconds >= 1e-4 else (1e6, "µs")
    return f"{float(f'{seconds * factor:.3g}'):g} {shown}"
