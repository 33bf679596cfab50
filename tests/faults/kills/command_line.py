"""A run and a batch on the command line that are killed: files are old or new as a whole, and the next start works."""

from __future__ import annotations

import contextlib
import csv
import io
import os
import time
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

from cpm_core import cli
from cpm_core.formats.sessions.session_file import SessionFile, save_session
from cpm_core.parameters import Parameters
from cpm_core.shapes import Circle

from .nursery import End, outcome

Kill = Callable[..., End]
"""Starts a process that calls a function with arguments in a folder, and kills it: `killed_before`, for example."""

_CENTERS = ((16.0, 16.0), (30.0, 17.0), (24.0, 33.0))
_FILES = ("a.svg", "a.csv", "a.measures.csv", "a.json", "a.zip", "a.png")
_SUFFIXES = ("svg", "measures.csv")
_OLD = b"an older file\n"


def draw_images(folder: Path) -> None:
    """Draw a disk into each of three small images, and save a session with a start for all."""
    row, col = np.indices((48, 48))
    for number, (top, left) in enumerate(_CENTERS):
        np.save(folder / f"{number}.npy", np.where(np.hypot(row - top, col - left) < 9.0, 200.0, 20.0))
    shapes = tuple(Circle(center, 5.0) for center in _CENTERS)
    save_session(SessionFile(shapes=shapes, parameters=Parameters(scales=1)), folder / "start.cpm")


def run(folder: Path) -> tuple[int, str]:
    """``cpm run`` with six exports; its status and what it says on standard error."""
    files = (str(folder / name) for name in _FILES)
    return said_by("run", "0.npy", "--session", "start.cpm", "--scales", "1", "--max-steps", "3", "--export", *files)


def batch(folder: Path, steps: int) -> tuple[int, str]:
    """``cpm batch`` of all images, in one process."""
    images = (f"{number}.npy" for number in range(len(_CENTERS)))
    place = ("--output", str(folder / "out"), "--workers", "1", "--contours", "--export", *_SUFFIXES)
    return said_by("batch", *images, "--session", "start.cpm", "--max-steps", str(steps), *place)


def said_by(*arguments: str) -> tuple[int, str]:
    """Status of a command, and what it says on standard error."""
    said = io.StringIO()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said):
        status = cli.main(arguments)
    return status, said.getvalue()


class Runs:
    """Runs with exports over older files."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        draw_images(folder)
        whole = outcome(folder, run, folder)
        assert whole.value == (0, ""), whole.value
        self.operations = whole.operations
        self._new = contents(folder, _FILES)

    def trial(self, kill: Kill) -> None:
        """Kill one run, and let another one follow."""
        for name in _FILES:
            (self._folder / name).write_bytes(_OLD)
        kill(self._folder, run, self._folder)
        for name, content in contents(self._folder, _FILES).items():
            assert content in (_OLD, self._new[name]), f"{name} is neither the old file nor the new one"
        age(drafts(self._folder))
        assert outcome(self._folder, run, self._folder).value == (0, ""), "the run after it fails"
        assert contents(self._folder, _FILES) == self._new, "the run after it writes other files"
        assert not drafts(self._folder), "drafts stay for ever"


class Batches:
    """Batches over the files of an earlier batch with other settings."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._out = folder, folder / "out"
        self._trials = 0
        self._made: dict[int, dict[str, bytes]] = {}
        draw_images(folder)
        names = [f"{number}_contours.{suffix}" for number in range(len(_CENTERS)) for suffix in ("svg", "csv")]
        for steps in (2, 3):
            whole = outcome(folder, batch, folder, steps)
            assert whole.value == (0, ""), whole.value
            self._made[steps] = contents(self._out, names)
        self.operations = whole.operations
        assert self._made[2] != self._made[3], "the settings make no difference"

    def trial(self, kill: Kill) -> None:
        """Kill a batch over a whole one with other settings, and let one with each of both follow, in any order."""
        self._trials += 1
        steps, same_first = 2 + self._trials // 2 % 2, self._trials % 2 > 0
        other = 5 - steps
        assert outcome(self._folder, batch, self._folder, other).value[0] == 0
        kill(self._folder, batch, self._folder, steps)
        for name, content in contents(self._out, self._made[2]).items():
            assert content in (self._made[2][name], self._made[3][name]), f"{name} is neither old nor new"
        done = {
            row["image"]: row["files"].split("; ") for row in self._rows() if f"max_steps={steps}" in row["settings"]
        }
        new = [self._made[steps][name] == content for name, content in contents(self._out, self._made[2]).items()]
        finished = sum(map(all, zip(*[iter(new)] * len(_SUFFIXES), strict=True)))
        assert len(done) >= finished - 1, f"{finished} images were finished, but {len(done)} are known"
        before = {name: (self._out / name).stat().st_mtime_ns for names in done.values() for name in names}
        age(drafts(self._out))
        for each in (steps, other) if same_first else (other, steps):
            status, said = outcome(self._folder, batch, self._folder, each).value
            assert status == 0, f"the batch after it fails: {said}"
            assert contents(self._out, self._made[each]) == self._made[each], "the batch after it leaves other files"
            assert sorted(row["image"] for row in self._rows()) == [f"{number}.npy" for number in range(len(_CENTERS))]
            if each == steps and same_first:
                again = [name for name, written in before.items() if (self._out / name).stat().st_mtime_ns != written]
                assert not again, f"{again[0]} was done and is done again"
        assert not drafts(self._out), "drafts stay for ever"

    def _rows(self) -> list[dict[str, str]]:
        with (self._out / "summary.csv").open(newline="", encoding="utf-8") as stream:
            return list(csv.DictReader(stream))


def contents(folder: Path, names: Iterable[str]) -> dict[str, bytes]:
    """Content of files of a folder by name; empty for one that is missing."""
    paths = {name: folder / name for name in names}
    return {name: path.read_bytes() if path.exists() else b"" for name, path in paths.items()}


def drafts(folder: Path) -> list[Path]:
    """Drafts of killed writers in a folder."""
    return list(folder.glob(".cpm-*.part"))


def age(left: Iterable[Path]) -> None:
    """Let drafts of killed writers be so old that they can be no others."""
    long_ago = time.time() - 3600.0
    for draft in left:
        os.utime(draft, (long_ago, long_ago))
