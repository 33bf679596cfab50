"""The same runs on one core, on all cores and on narrow vector registers, over many images."""

import time

from tests.core.segmentation import reproduced

from .report import Budget, Report, going_on


def compared(budget: Budget) -> Report:
    """Compare the vertices of runs with those on one core to the bit, and with those on narrow registers to 1e-6 px.

    Each seed has images of its own. The loops are compiled again for narrow registers, once.
    """
    until, runs, failures = time.monotonic() + budget.seconds, 0, []
    seed = budget.seed
    while not runs or going_on(until):
        here = reproduced.vertices(seed)
        elsewhere = {"on one core": (reproduced.on_one_core(seed), 0.0)}
        if reproduced.HAS_WIDE:
            narrow = reproduced.on_narrow_registers(seed, reproduced.NARROW)
            elsewhere["on narrow registers"] = (narrow, reproduced.LAW)
        for where, (found, most) in elsewhere.items():
            differences = {name: reproduced.apart(found[name], points) for name, points in here.items()}
            failures += [
                f"the run {name} with seed {seed} differs {where} by {difference:.3g} px"
                for name, difference in differences.items()
                if difference > most
            ]
        runs, seed = runs + len(here) * len(elsewhere), seed + 1
    return Report(runs, failures=tuple(failures))
