"""What a part of the fault tests is given, and what it tells."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True)
class Budget:
    """How long a part may go on, from which seed, and where it may write.

    Parameters
    ----------
    seconds : float
        Time after which no further input is begun.
    seed : int
        Fixes all random choices: the same seed gives the same inputs in the same order.
    folder : Path
        An empty folder for files of this part alone.
    collection : Path, optional
        A folder of files, sound and damaged ones, that are read and damaged beside the own samples.
    """

    seconds: float
    seed: int
    folder: Path
    collection: Path | None = None


@dataclass(frozen=True)
class Report:
    """What was tried, and what failed.

    Parameters
    ----------
    inputs : int
        Files, calls, sessions or events that were tried.
    faults : int
        Kills, full disks, failed writes and the like that were injected.
    failures : tuple of str
        One sentence for each failure, with what repeats it.
    seconds : float
        Time taken; set by whoever runs the part.
    told : tuple of str
        What has been measured beside this, one sentence each.
    """

    inputs: int
    faults: int = 0
    failures: tuple[str, ...] = field(default=())
    seconds: float = 0.0
    told: tuple[str, ...] = field(default=())


Part = Callable[[Budget], Report]
