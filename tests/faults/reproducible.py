"""The same runs on one core and on all cores, over many images."""

import time

from tests.core.segmentation import reproduced

from .report import Budget, Report


def compared(budget: Budget) -> Report:
    """Compare the vertices of runs on one core with those on all cores to the bit, each seed on images of its own."""
    until, runs, failures = time.monotonic() + budget.seconds, 0, []
    seed = budget.seed
    while not runs or time.monotonic() < until:
        here, alone = reproduced.hashes(seed), reproduced.on_one_core(seed)
        differing = [name for name, told in here.items() if alone.get(name) != told]
        failures += [f"the run {name} with seed {seed} differs on one core" for name in differing]
        runs, seed = runs + len(here), seed + 1
    return Report(runs, failures=tuple(failures))
