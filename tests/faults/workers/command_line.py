"""The command line with little memory, and with workers that die."""

from __future__ import annotations

import multiprocessing
import random
import resource
import threading
import time
from pathlib import Path

import numpy as np

from ..kills.command_line import draw_images, said_by
from ..kills.nursery import outcome

_SIDE = 700


class Memory:
    """Runs on a larger image with less memory than they need."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        row, col = np.ogrid[:_SIDE, :_SIDE]
        disk = np.hypot(row - _SIDE / 2, col - _SIDE / 2) < _SIDE / 3
        np.save(folder / "large.npy", np.where(disk, 200, 20).astype(np.uint8))

    def trial(self, mebibytes: float) -> bool:
        """Run with so much memory left; whether it was enough."""
        told = outcome(self._folder, _run_with, mebibytes, self._folder)
        assert not told.killed, f"with {mebibytes:.1f} MiB it dies"
        status, said = told.value
        exported = (self._folder / "a.svg").exists()
        assert (status == 0) == exported, f"with {mebibytes:.1f} MiB its status is {status}"
        assert status == 0 or (said.startswith("cpm: ") and said.count("\n") == 1), f"with {mebibytes:.1f} MiB: {said}"
        return exported


class Workers:
    """Batches in two processes, each of which may be killed at any time, as by a system that lacks memory."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        draw_images(folder)

    def trial(self, kills: int, seed: int) -> None:
        """Kill workers of a batch, and repeat it."""
        for name in (self._folder / "out").glob("*"):
            name.unlink()
        told = outcome(self._folder, _batch_with, kills, seed, self._folder)
        assert not told.killed, "the batch dies with its workers"
        status, said = told.value
        assert "Traceback" not in said, said
        assert said.count("ended unexpectedly") == (0 if kills < 2 else status), said
        status, said = outcome(self._folder, _batch_with, 0, seed, self._folder).value
        assert status == 0, f"the batch after it fails: {said}"
        assert len(list((self._folder / "out").glob("*.svg"))) == 3, "an image is lost"


def _run_with(mebibytes: float, folder: Path) -> tuple[int, str]:
    (folder / "a.svg").unlink(missing_ok=True)
    taken = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, 2 * (taken + int(mebibytes * 2**20),))
    circle, target = f"{_SIDE // 2},{_SIDE // 2},{_SIDE // 4}", str(folder / "a.svg")
    return said_by("run", str(folder / "large.npy"), "--circle", circle, "--max-steps", "2", "--export", target)


def _batch_with(kills: int, seed: int, folder: Path) -> tuple[int, str]:
    drawn = random.Random(seed)

    def kill() -> None:
        for _ in range(kills):
            time.sleep(drawn.uniform(0.5, 2.5))
            alive = multiprocessing.active_children()
            if alive:
                drawn.choice(alive).kill()

    threading.Thread(target=kill, daemon=True).start()
    images = [f"{folder}/{number}.npy" for number in range(3)]
    place = ("--output", f"{folder}/out", "--workers", "2", "--contours", "--export", "svg")
    return said_by("batch", *images, "--session", f"{folder}/start.cpm", "--max-steps", "2", *place)
