"""The benchmark of the claims: its trials, what it makes of scores, and what it prints."""

import pytest

from tests.benchmarks.claims.claims import CLAIMS, GOOD, TIME, Score, verdicts
from tests.benchmarks.claims.trials import STARTS, trials


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


def test_a_claim_is_confirmed_when_the_particles_find_every_object():
    low, high = GOOD - 0.01, GOOD + 0.01
    found = [of("cpm", 1.0, 1.0), of("cpm", low, 1.0), of("geodesic", high, 2.0), of("geodesic", high, 2.0)]
    (verdict, _) = verdicts(found)
    assert (verdict.claim, verdict.confirmed) == (STARTS, False)
    assert verdict.figures == pytest.approx({"cpm": (1.0 + low) / 2, "geodesic": high})
    assert verdict.least == {"cpm": low, "geodesic": high}
    assert verdicts([of("cpm", high, 1.0), of("geodesic", 1.0, 2.0)])[0].confirmed


@pytest.mark.parametrize(("ours", "so"), [(0.5, True), (0.05, False), (3.0, False)])
def test_the_claim_about_time_is_slower_than_snakes_and_faster_than_level_sets(ours, so):
    found = [of("cpm", 1.0, ours), of("snake", 1.0, 0.1), of("gvf", 1.0, 0.2), of("geodesic", 1.0, 1.0)]
    verdict = verdicts(found)[-1]
    assert (verdict.claim, verdict.confirmed) == (TIME, so)
