"""Which message is shown, and when it no longer applies."""

from __future__ import annotations

from cpm_app.model.state.messages import Message, Messages

LOST = Message("It could not be written.", error=True, topic="exporting")
SAVED = Message("Saved.", topic="saving")
NO_START = Message("There is nothing to start from.", error=True, topic="running")


def test_good_news_is_shown_over_an_error_and_the_error_comes_back() -> None:
    both = Messages().said(LOST).said(SAVED)
    assert both.shown is SAVED
    assert both.faded().shown is LOST


def test_another_attempt_takes_away_what_was_said_about_the_last_one() -> None:
    two = Messages().said(NO_START).said(LOST)
    assert two.without("exporting").shown is NO_START
    assert two.without("exporting", "running").shown is None
    assert Messages().said(SAVED).without("saving").shown is None


def test_an_error_stays_until_it_is_dismissed() -> None:
    assert Messages().said(LOST).faded().shown is LOST
    assert Messages().said(LOST).dismissed().shown is None


def test_another_image_takes_away_all_but_what_was_said_about_opening_it() -> None:
    refused = Message("a.png is no image.", error=True, topic="opening")
    assert Messages().said(LOST).said(refused).said(SAVED).only("opening").shown is refused
