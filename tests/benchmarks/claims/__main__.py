"""``python -m tests.benchmarks.claims``: a line for each trial, then each claim with its figures."""

from __future__ import annotations

from collections.abc import Sequence

from cpm_core.methods import CONTOUR_METHODS
from cpm_core.warm_up import warm_up
from tests.benchmarks.claims.claims import TIME, Score, Verdict, scores, taking_part, verdicts
from tests.benchmarks.claims.trials import Trial

SEARCHED = (
    "Settings: those of the charged particles are the publication's, with the smoothing chosen by the noise. Those of "
    "the other methods are their defaults: one search of each parameter in turn, on every second of these images and "
    "on four more, looked for better ones, and they were taken where they are no worse on the other images."
)

_WHAT, _NUMBER = 26, 8
_SHORT = {
    "cpm": "cpm",
    "snake": "snake",
    "gvf": "gvf",
    "geodesic": "gac",
    "geometric_gvf": "g-gvf",
    "chan_vese": "c-v",
    "morph_gac": "m-gac",
    "morph_chan_vese": "m-c-v",
    "random_walker": "walker",
}


def main() -> None:
    """Run all methods on all trials, and print what follows for each claim."""
    warm_up()
    print(SEARCHED)
    print(f"F of the boundaries up to 2 px; {', '.join(f'{_short(name)}: {_title(name)}' for name in taking_part())}.")
    print(_row("", [_short(name) for name in taking_part()]))
    found = scores(tell=_tell)
    for verdict in verdicts(found):
        print()
        print(sentence(verdict))
        digits = 2 if verdict.claim != TIME else 3
        print(
            _row(
                "median [s]" if verdict.claim == TIME else "mean F",
                [f"{n:.{digits}f}" for n in verdict.figures.values()],
            )
        )
        if verdict.least:
            print(_row("least F", [f"{n:.2f}" for n in verdict.least.values()]))


def sentence(verdict: Verdict) -> str:
    """Whether a claim is confirmed, and who won."""
    said = "confirmed" if verdict.confirmed else "not confirmed"
    best = "Fastest" if verdict.claim == TIME else "Best"
    return f"Claim: {verdict.claim}. {said.capitalize()}. {best}: {', '.join(map(_title, verdict.winners))}."


def _tell(trial: Trial, here: Sequence[Score]) -> None:
    print(_row(trial.name, [f"{score.f:.2f}" for score in here]), flush=True)


def _row(what: str, cells: Sequence[str]) -> str:
    return f"{what:{_WHAT}}{''.join(f'{cell:>{_NUMBER}}' for cell in cells)}"


def _title(name: str) -> str:
    return CONTOUR_METHODS[name].title


def _short(name: str) -> str:
    return _SHORT.get(name, name[: _NUMBER - 1])


if __name__ == "__main__":
    main()
