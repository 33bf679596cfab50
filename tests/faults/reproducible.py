"""The same runs on one core and on all cores, over many images."""

import time

from . import reproduced
from .report import Budget, Report, going_on


def compared(budget: Budget) -> Report:
    """Compare the vertices of runs with those on one core to the bit; each seed has images of its own."""
    until, runs, failures = time.monotonic() + budget.seconds, 0, []
    seed = budget.seed
    while not runs or going_on(until):
        here, alone = reproduced.vertices(seed), reproduced.on_one_core(seed)
        differences = {name: reproduced.apart(alone[name], points) for name, points in here.items()}
        failures += [
            f"the run {name} with seed {seed} differs on one core by {difference:.3g} px"
            for name, difference in differences.items()
            if difference > 0.0
        ]
        runs, seed = runs + len(here), seed + 1
    return Report(runs, failures=tuple(failures))
