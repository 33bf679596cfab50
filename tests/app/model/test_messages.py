"""Which message is shown, and when it no longer applies."""

from __future__ import annotations

from cpm_app.model.state.messages import Message, Messages

LOST = Message("It could not be written.", error=True, category="exporting")
SAVED = Message("Saved.", category="saving")
NO_START = Message("There is nothing to start from.", error=True, category="running")


def test_good_news_is_shown_over_an_error_and_the_error_comes_back() -> None:
    both = Messages().with_message(LOST).with_message(SAVED)
    assert both.shown is SAVED
    assert both.without_news().shown is LOST


def test_another_attempt_takes_away_what_was_said_about_the_last_one() -> None:
    two = Messages().with_message(NO_START).with_message(LOST)
    assert two.without_categories("exporting").shown is NO_START
    assert two.without_categories("exporting", "running").shown is None
    assert Messages().with_message(SAVED).without_categories("saving").shown is None


def test_an_error_stays_until_it_is_dismissed() -> None:
    assert Messages().with_message(LOST).without_news().shown is LOST
    assert Messages().with_message(LOST).without_shown().shown is None


def test_another_image_takes_away_all_but_what_was_said_about_opening_it() -> None:
    refused = Message("a.png is no image.", error=True, category="opening")
    assert (
        Messages().with_message(LOST).with_message(refused).with_message(SAVED).only_categories("opening").shown
        is refused
    )
