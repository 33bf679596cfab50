"""``python -m tests.benchmarks.speed``: measures times on this machine, beside other methods and lower bounds."""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence

from cpm_core.cli.bench import describe_machine
from cpm_core.formats import load_image
from tests.benchmarks.speed.growth import table
from tests.benchmarks.speed.measurement import QUICK, UNHURRIED, Measurement
from tests.benchmarks.speed.table import measurements

_WHAT, _TIME, _PEER = 44, 11, 40
"""Widths of the table's columns [characters]."""


def main(argv: Sequence[str] | None = None) -> None:
    """Measure, with a line for each measurement as soon as it is known."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.speed", description=__doc__)
    parser.add_argument("--image", metavar="PATH", help="image for the whole runs (default: a scene of 398 x 548 px)")
    parser.add_argument("--quick", action="store_true", help="a few seconds: smaller inputs, fewer repeats")
    parser.add_argument("--growth", action="store_true", help="time and memory as the work grows, a table in Markdown")
    arguments = parser.parse_args(argv)
    if arguments.growth:
        for row in table():
            print(row, flush=True)
        return
    image = None if arguments.image is None else load_image(arguments.image)
    began = time.perf_counter()
    print(", ".join(f"{name} {value}" for name, value in describe_machine().items()))
    print(f"{'':{_WHAT}}{'ours':>{_TIME}}  {'peer':{_PEER}}{'':>{_TIME}}  ours/peer")
    for row in measurements(QUICK if arguments.quick else UNHURRIED, image):
        print(line(row), flush=True)
    print(f"{time.perf_counter() - began:.0f} s in all")


def line(row: Measurement) -> str:
    """Line of the table."""
    text = f"{row.what:{_WHAT}}{_time(row.value, row.unit):>{_TIME}}"
    if row.ratio is not None and row.peer_value is not None:
        text += f"  {row.peer:{_PEER}}{_time(row.peer_value, row.unit):>{_TIME}}  {row.ratio:.2g}"
    more = [row.note] if row.note else []
    return "  ".join([text, *more])


def _time(value: float, unit: str) -> str:
    """Time with three digits, in a unit that fits its size."""
    seconds = value * {"s": 1.0, "ms": 1e-3}[unit]
    factor, shown = (1.0, "s") if seconds >= 1.0 else (1e3, "ms") if seconds >= 1e-4 else (1e6, "µs")
    return f"{float(f'{seconds * factor:.3g}'):g} {shown}"


if __name__ == "__main__":
    main()
