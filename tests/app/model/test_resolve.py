"""Enabled actions and texts depend only on document and run."""

from __future__ import annotations

import pytest
from cpm_app.model.document import edits
from cpm_app.model.document.document import Document, ImageReference
from cpm_app.model.state.resolve import resolve_texts
from cpm_app.model.state.situation import RunStatus, Situation, can_step, has_image, is_started

from cpm_core.shapes import Barrier, Charge, Circle

IMAGE = ImageReference("disc.png", "disc.png", (64, 64), 180.0)
DRAWN = Document(IMAGE, (Circle((32.0, 32.0), 10.0),))


def test_without_an_image_there_is_no_run_and_the_hint_explains_how_to_open_one() -> None:
    empty = Situation()
    assert not any(holds(empty) for holds in (has_image, can_step, is_started))
    assert "Open an image" in resolve_texts(empty).hint


def test_while_the_first_image_is_opened_no_hint_asks_for_one() -> None:
    assert resolve_texts(Situation(status=RunStatus(busy="Opening disc.png…"))).hint == ""


@pytest.mark.parametrize(
    ("status", "text", "steps", "started"),
    [
        (RunStatus("ready"), "Run", True, False),
        (RunStatus("running"), "Pause", False, True),
        (RunStatus("paused"), "Resume", True, True),
        (RunStatus("paused", stale=True), "Run again", True, True),
        (RunStatus("finished", stop_reason="at rest", converged=True, count=9), "Run again", False, True),
        (RunStatus("finished", stop_reason="all particles left the image"), "Run again", False, True),
        (RunStatus("finished", stop_reason="not at rest after 400 steps", count=9), "Resume", True, True),
        (RunStatus("finished", stop_reason="not at rest", count=9, stale=True), "Run again", True, True),
        (RunStatus("finished", stop_reason="at rest", steered=True), "Resume", True, True),
        (RunStatus("finished", stop_reason="at rest", steered=True, stale=True), "Run again", True, True),
    ],
)
def test_run_is_worded_by_what_it_will_do(status: RunStatus, text: str, steps: bool, started: bool) -> None:
    situation = Situation(DRAWN, status)
    assert resolve_texts(situation).run_text == text
    assert has_image(situation)
    assert (can_step(situation), is_started(situation)) == (steps, started)


def test_a_run_that_is_out_of_date_shows_how_to_renew_it() -> None:
    assert "next run" in resolve_texts(Situation(DRAWN, RunStatus("running", stale=True))).hint
    assert "Run starts over" in resolve_texts(Situation(DRAWN, RunStatus("paused", stale=True))).hint
    assert resolve_texts(Situation(DRAWN, RunStatus("running"))).hint == ""


def test_the_stop_reason_is_shown_and_whether_it_is_an_equilibrium() -> None:
    assert (
        resolve_texts(Situation(DRAWN, RunStatus("finished", stop_reason="at rest", converged=True))).state
        == "Finished: at rest"
    )
    assert resolve_texts(Situation(DRAWN, RunStatus("finished", stop_reason="lost"))).state == "Stopped – lost"


def test_what_a_run_starts_from_are_starts_and_scales_but_not_what_acts_at_once() -> None:
    assert edits.clear_shapes(DRAWN).start_counts != DRAWN.start_counts
    for shape in (Barrier(((1.0, 2.0), (3.0, 4.0))), Charge((5.0, 6.0))):
        assert edits.add_shape(DRAWN, shape).start_counts == DRAWN.start_counts
    assert edits.set_parameter(DRAWN, "scales", 2).start_inputs != DRAWN.start_inputs
    assert edits.set_parameter(DRAWN, "beta", 1.0).start_inputs == DRAWN.start_inputs
