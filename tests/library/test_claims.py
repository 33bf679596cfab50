"""The benchmark of the claims: its trials, what it makes of scores, and what it prints."""

from itertools import islice

import numpy as np
import pytest

from cpm_core.contours.rasterize import inside
from tests.benchmarks.claims import __main__ as report
from tests.benchmarks.claims.claims import CLAIMS, GOOD, TIME, Score, scores, verdicts
from tests.benchmarks.claims.trials import CONCAVITIES, STARTS, trials


def of(method, f, seconds, claim=STARTS):
    return Score(claim, "a trial", method, f, seconds)


def test_every_claim_has_trials_whose_start_and_truth_lie_in_the_image():
    made = list(trials())
    assert {trial.claim for trial in made} == set(CLAIMS)
    assert len({trial.name for trial in made}) == len(made)
    for trial in made:
        rows, cols = trial.image.shape
        for line in (*trial.start.outlines, *(contour.points for contour in trial.truth)):
            assert line.min() >= -0.5 and (line.max(axis=0) <= [rows - 0.5, cols - 0.5]).all(), trial.name


def test_a_start_around_the_object_contains_it_and_no_other_does():
    for trial in trials():
        truth = inside(trial.truth, trial.image.shape)
        covered = (trial.start.mask(trial.image.shape) & truth).sum() == truth.sum() > 0
        assert covered == trial.start.around, trial.name


def test_a_claim_is_confirmed_when_the_particles_find_every_object():
    low, high = GOOD - 0.01, GOOD + 0.01
    found = [of("cpm", 1.0, 1.0), of("cpm", low, 1.0), of("gac", high, 2.0), of("gac", high, 2.0)]
    (verdict, _) = verdicts(found)
    assert (verdict.claim, verdict.confirmed) == (STARTS, False)
    assert verdict.figures == pytest.approx({"cpm": (1.0 + low) / 2, "gac": high})
    assert verdict.least == {"cpm": low, "gac": high}
    assert verdicts([of("cpm", high, 1.0), of("gac", 1.0, 2.0)])[0].confirmed


def test_whoever_has_the_highest_mean_wins_and_those_as_good_with_it():
    found = [of("cpm", 0.95, 1.0), of("gac", 0.999, 2.0), of("gvf", 0.997, 2.0), of("snake", 0.0, 0.1)]
    assert verdicts(found)[0].winners == ("gac", "gvf")


@pytest.mark.parametrize(("ours", "so"), [(0.5, True), (0.05, False), (3.0, False)])
def test_the_claim_about_time_is_slower_than_snakes_and_faster_than_level_sets(ours, so):
    found = [of("cpm", 1.0, ours), of("snake", 1.0, 0.1), of("gvf", 1.0, 0.2), of("gac", 1.0, 1.0)]
    verdict = verdicts(found)[-1]
    assert (verdict.claim, verdict.confirmed) == (TIME, so)


def test_scores_are_those_of_the_methods_named_in_the_order_of_the_trials():
    few = [trial for trial in trials() if trial.claim == CONCAVITIES][:1]
    seen = []
    found = scores(("cpm", "gvf"), few, tell=lambda trial, here: seen.append((trial.name, len(here))))
    assert [(score.trial, score.method) for score in found] == [("long thin bay", "cpm"), ("long thin bay", "gvf")]
    assert seen == [("long thin bay", 2)]
    assert found[0].f > GOOD > found[1].f
    assert all(np.isfinite(score.seconds) and score.seconds > 0.0 for score in found)


@pytest.fixture
def quick(monkeypatch):
    """The benchmark on one trial and two methods, without compiling what others need."""
    few = list(islice(trials(), 1))
    monkeypatch.setattr(report, "warm_up", lambda: None)
    monkeypatch.setattr(
        report, "scores", lambda tell=None: scores(("cpm", "random_walker"), few, tell or (lambda *rest: None))
    )


def test_each_claim_is_printed_with_who_won(quick, capsys):
    report.main()
    out = capsys.readouterr().out
    assert report.SEARCHED in out
    assert "start inside" in out
    assert f"Claim: {STARTS}. Confirmed. Best: Charged particles" in out
    assert f"Claim: {TIME}. " in out
