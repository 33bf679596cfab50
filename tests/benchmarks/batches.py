"""A batch that is killed at random moments: ``python -m tests.benchmarks.batches [--images N] [--kills N]``.

Draws small images with one to three disks, starts ``cpm batch`` on all, kills it (SIGKILL) and starts it again, and
prints memory while it works, and whether each image was done once, no file is cut short, and the table of all contours
consists of those of single runs.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import io
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import PIL.Image

from cpm_core import cli
from cpm_core.formats.sessions.session_file import SessionFile, save_session
from cpm_core.parameters import Parameters
from cpm_core.shapes import Circle

SIDE, CENTERS = 64, ((18.0, 18.0), (20.0, 46.0), (46.0, 32.0))


def draw(folder: Path, count: int) -> None:
    """Draw the images: disks whose number, radii and positions are random."""
    random_numbers = np.random.default_rng(1)
    row, col = np.indices((SIDE, SIDE))
    folder.mkdir(exist_ok=True)
    for number in range(count):
        values = random_numbers.normal(40.0, 4.0, (SIDE, SIDE))
        for center in CENTERS[: random_numbers.integers(1, 4)]:
            radius, (top, left) = random_numbers.uniform(7.0, 11.0), random_numbers.normal(center, 1.0)
            values += 160.0 * np.clip(radius + 0.5 - np.hypot(row - top, col - left), 0.0, 1.0)
        PIL.Image.fromarray(values.clip(0, 255).astype(np.uint8)).save(folder / f"{number:05}.png")


def processes(first: int) -> list[int]:
    """A process and all that it has started, by their numbers."""
    found = [first]
    for one in found:
        for task in Path(f"/proc/{one}/task").glob("*/children"):
            found += map(int, task.read_text().split())
    return found


def resident(process: int) -> float:
    """Memory of a process [MB]."""
    status = Path(f"/proc/{process}/status")
    lines = status.read_text().splitlines() if status.exists() else []
    return next((int(line.split()[1]) / 1e3 for line in lines if line.startswith("VmRSS")), 0.0)  # none of a zombie


def rows(path: Path) -> list[dict[str, str]]:
    """Whole rows of a table."""
    if not path.exists():
        return []
    text = path.read_text(encoding="utf-8")
    return list(csv.DictReader(text[: text.rfind("\n") + 1].splitlines()))


def watched(command: list[str], table: Path, seconds: float) -> bool:
    """Run a batch for so long at most and then kill it; print memory once in a while, and say whether it has ended."""
    began, due = time.monotonic(), 0.0
    batch = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    while batch.poll() is None and time.monotonic() - began < seconds:
        time.sleep(0.05)
        if time.monotonic() - began > due:
            due += 15.0
            try:
                used = [resident(one) for one in processes(batch.pid)]
            except (OSError, ValueError):  # one has just ended
                continue
            done = table.read_bytes().count(b"\n") - 1 if table.exists() else 0
            print(
                f"  {due - 15:5.0f} s, {done} done, MB: {used[0]:.0f}, others {[round(one) for one in used[1:]]}",
                flush=True,
            )
    if batch.poll() is not None:
        print(f"  ended after {time.monotonic() - began:.1f} s with status {batch.returncode}", flush=True)
        return True
    left = processes(batch.pid)[1:]
    batch.send_signal(signal.SIGKILL)
    batch.wait()
    time.sleep(1.5)
    left = [one for one in left if resident(one)]
    print(f"  killed after {time.monotonic() - began:.1f} s; {len(left)} of its processes are left", flush=True)
    return False


def check(folder: Path, output: Path, some: list[int]) -> None:
    """Print what is not as it must be: of all images their rows, files and measures, of some single runs."""
    done, joined = rows(output / "summary.csv"), rows(output / "objects.csv")
    files = {name for row in done for name in row["files"].split("; ")} | {"summary.csv", "objects.csv"}
    failed = sum(bool(row["trouble"]) for row in done)
    print(f"{len(done)} rows of {len({row['image'] for row in done})} images, {failed} failed")
    print(f"files that no row names: {sorted({path.name for path in output.iterdir()} - files) or 'none'}")
    measured: dict[str, list[dict[str, str]]] = {}
    for row in joined:
        measured.setdefault(row["image"], []).append(row)
    counted = sum(len(measured.get(Path(row["image"]).name, ())) != int(row["objects"]) for row in done)
    print(f"{len(joined)} objects in all; of {counted} images not those that were found")
    other = 0
    for number in some:
        name, alone = f"{number:05}.png", folder / "alone.table.csv"
        run = ["run", str(folder / "images" / name), "--session", str(folder / "start.cpm"), "--objects"]
        run += ["--export", str(alone)]
        with contextlib.redirect_stdout(io.StringIO()):
            cli.main(run)
        other += rows(alone) != measured[name]
    print(f"of {len(some)} single runs {other} give other measures")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--images", type=int, default=10_000)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--longest", type=float, default=90.0, help="longest time until a kill [s]")
    parser.add_argument("--folder", type=Path, help="where to work (default: a folder that is removed)")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = arguments.folder or Path(scratch)
        images, output = folder / "images", folder / "found"
        draw(images, arguments.images)
        start = SessionFile(shapes=tuple(Circle(center, 4.0) for center in CENTERS), parameters=Parameters(scales=1))
        save_session(start, folder / "start.cpm")
        command = [sys.executable, "-m", "cpm_app", "batch", str(images), "--session", str(folder / "start.cpm")]
        command += ["--output", str(output), "--export", "svg", "csv"]
        table, generator = output / "summary.csv", random.Random(1)
        known: dict[str, str] = {}
        kills, again = 0, 0
        while not watched(
            command, table, generator.uniform(1.0, arguments.longest) if kills < arguments.kills else 1e9
        ):
            kills += 1
            now = {row["image"]: row["finished"] for row in rows(table)}
            again += sum(now.get(image) != finished for image, finished in known.items())
            print(f"kill {kills}: {len(now)} done; {again} done ones were done again until now", flush=True)
            known = now
        check(folder, output, random.Random(2).sample(range(arguments.images), 20))
    return 0


if __name__ == "__main__":
    sys.exit(main())
