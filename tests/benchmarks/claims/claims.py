"""The claims of the publication about the charged particles and the classical methods, tested on trials."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from cpm_core.contours.agreement import compare_boundaries
from cpm_core.methods import CONTOUR_METHODS, run_method
from cpm_core.parameters import PRESETS
from tests.benchmarks.claims.trials import CONCAVITIES, LEAKS, NOISE, STARTS, TOPOLOGY, Trial, trials

OURS = "cpm"
OURS_SETTINGS = PRESETS["noisy"]
"""One setting for all trials: the defaults of the publication, with the smoothing chosen by the noise of each image."""

GOOD = 0.9
"""F from which an object counts as found."""

_SAME = 0.005
"""Difference of mean F up to which two methods share a place."""

TIME = "faster than level sets, slower than snakes"
_LEVEL_SETS, _SNAKES = ("geodesic", "geometric_gvf", "chan_vese"), ("snake", "gvf")

NO_PART = ("object",)
"""Methods of which the claims say nothing: one outline asks for one object, whatever else the particles find."""

CLAIMS = (STARTS, CONCAVITIES, TOPOLOGY, LEAKS, NOISE)


@dataclass(frozen=True)
class Score:
    """The outcome of a method in a trial: F of the boundaries, and the time that it took [s]."""

    claim: str
    trial: str
    method: str
    f: float
    seconds: float


@dataclass(frozen=True)
class Verdict:
    """What the trials say of a claim.

    Attributes
    ----------
    claim : str
        The claim.
    confirmed : bool
        Whether the particles found the object in each of its trials; of the claim about time, whether it is so.
    figures : mapping
        For each method the mean F of the trials, or the median time [s].
    least : mapping
        For each method the least F of the trials; empty for the claim about time.
    winners : tuple of str
        The methods with the highest mean F; for time those with the shortest.
    """

    claim: str
    confirmed: bool
    figures: Mapping[str, float]
    least: Mapping[str, float]
    winners: tuple[str, ...]


def taking_part() -> tuple[str, ...]:
    """Names of the methods that can run and that the claims are about."""
    return tuple(name for name in CONTOUR_METHODS if name not in NO_PART)


def scores(
    methods: Sequence[str] | None = None,
    among: Sequence[Trial] | None = None,
    tell: Callable[[Trial, list[Score]], object] | None = None,
) -> list[Score]:
    """Run methods on trials, by default those that `taking_part` gives on all; `tell` is called after each trial."""
    methods = taking_part() if methods is None else methods
    found: list[Score] = []
    for trial in trials() if among is None else among:
        here = [_score(trial, name) for name in methods]
        found += here
        if tell is not None:
            tell(trial, here)
    return found


def verdicts(found: Sequence[Score]) -> list[Verdict]:
    """What scores say of each claim."""
    methods = list(dict.fromkeys(score.method for score in found))
    made = []
    for claim in CLAIMS:
        of = {name: [s.f for s in found if s.claim == claim and s.method == name] for name in methods}
        if not all(of.values()):
            continue
        means = {name: statistics.fmean(values) for name, values in of.items()}
        least = {name: min(values) for name, values in of.items()}
        best = max(means.values())
        winners = tuple(name for name, mean in means.items() if mean >= best - _SAME)
        made.append(Verdict(claim, least.get(OURS, 0.0) >= GOOD, means, least, winners))
    return [*made, _of_time(found, methods)]


def _of_time(found: Sequence[Score], methods: Sequence[str]) -> Verdict:
    """The claim about time: above the slowest snake, below the fastest level set."""
    times = {name: statistics.median(s.seconds for s in found if s.method == name) for name in methods}
    snakes, fronts = ([times[name] for name in kind if name in times] for kind in (_SNAKES, _LEVEL_SETS))
    ours = times.get(OURS, float("nan"))
    confirmed = all(time < ours for time in snakes) and all(ours < time for time in fronts)
    fastest = min(times, key=lambda name: times[name])
    return Verdict(TIME, confirmed, times, {}, (fastest,))


def _score(trial: Trial, name: str) -> Score:
    method = CONTOUR_METHODS[name]
    end = run_method(method, trial.image, trial.start, OURS_SETTINGS if name == OURS else None)
    return Score(trial.claim, trial.name, name, compare_boundaries(end.state.contours, trial.truth).f, end.seconds)
