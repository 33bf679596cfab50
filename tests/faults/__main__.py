"""Tries broken input, faults and random use at length: ``python -m tests.faults``.

``--only PART ...`` names parts, ``--minutes M`` the time for each, ``--seed S`` fixes all random choices, and
``--files FOLDER`` contains more files that are read and damaged. It prints a table.

Ctrl+C, or the signal that ends a process, ends the part that is running and reports what it has found; a second one
ends everything immediately.
"""

import argparse
import logging
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

from .disk.disk import failed
from .fuzzing.parts import PARTS as FUZZING
from .kills.interruptions import interrupted
from .kills.kills import killed
from .report import Budget, Part, Report, asked_to_stop, stoppable
from .reproducible import compared
from .window.closing import try_closing
from .window.monkey import try_gestures
from .window.orders import try_orders
from .workers.workers import broken

PARTS: dict[str, tuple[str, Part]] = {
    **FUZZING,
    "gestures": ("random gestures on the window", try_gestures),
    "orders": ("orders to a session in every sequence, under delays", try_orders),
    "closing": ("closing the window during all that goes on", try_closing),
    "reproducible": ("the same runs on one core and on all", compared),
    "kills": ("kill -9 at random moments over runs, batches, saves and compilations", killed),
    "interruptions": ("errors that a signal raises at random moments of a call, as Ctrl+C does", interrupted),
    "disk": ("disks that are full, read-only or faulty, at each operation in turn", failed),
    "workers": ("workers that die, memory that is not enough", broken),
}
"""Name of each part: what it tries in a few words, and the function that runs it."""


def run(name: str, seconds: float, seed: int, collection: Path | None = None) -> Report:
    """Run one part in a scratch folder of its own, and take its time."""
    started = time.perf_counter()
    with tempfile.TemporaryDirectory(prefix="cpm-faults-") as folder:
        report = PARTS[name][1](Budget(seconds, seed, Path(folder), collection))
    return replace(report, seconds=time.perf_counter() - started)


def table(reports: dict[str, Report]) -> str:
    """Give the rows of the table of the README."""
    lines = ["| tried | inputs | faults | hours | failures |", "|---|---|---|---|---|"]
    for name, report in reports.items():
        hours = report.seconds / 3600
        lines.append(
            f"| {PARTS[name][0]} | {report.inputs:,} | {report.faults:,} | {hours:.2f} | {len(report.failures)} |"
        )
    return "\n".join(lines)


def main() -> int:
    """Run the parts that are asked for; status 1 if one of them failed."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.faults", description="Try broken input, faults and random use at length."
    )
    parser.add_argument(
        "--only", nargs="+", choices=sorted(PARTS), default=list(PARTS), metavar="PART", help="parts: %(choices)s"
    )
    parser.add_argument("--minutes", type=float, default=2.0, help="time for each part (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="fixes all random choices (default: %(default)s)")
    parser.add_argument(
        "--files", type=Path, metavar="FOLDER", help="files that `files` reads and damages beside its own"
    )
    arguments = parser.parse_args()
    with stoppable():
        reports = _reports(arguments)
    print(table(reports), flush=True)
    return 1 if any(report.failures for report in reports.values()) else 0


def _reports(arguments: argparse.Namespace) -> dict[str, Report]:
    """Run part after part, and print what each reports."""
    told = logging.StreamHandler(sys.stdout)
    mine = logging.getLogger(__package__)
    mine.addHandler(told)
    mine.setLevel(logging.INFO)
    reports: dict[str, Report] = {}
    for name in arguments.only:
        if asked_to_stop():
            break
        reports[name] = run(name, 60 * arguments.minutes, arguments.seed, arguments.files)
        for failure in reports[name].failures:
            print(f"{name}: {failure}", flush=True)
        for sentence in reports[name].told:
            print(f"{name}: {sentence}", flush=True)
    mine.removeHandler(told)
    return reports


if __name__ == "__main__":
    sys.exit(main())
