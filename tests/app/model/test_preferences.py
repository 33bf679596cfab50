"""Each preference keeps to its kind and limits; keys of actions belong to one action each."""

from __future__ import annotations

import pytest
from cpm_app.model.display import lengths
from cpm_app.model.display.lengths import PixelSize, preferred_pixel_size
from cpm_app.model.preferences import shortcuts
from cpm_app.model.preferences.shortcuts import ActionKeys
from cpm_app.model.preferences.table import (
    ALL_PREFERENCES,
    CONTOUR_WIDTH,
    THEME_PREFERENCE,
    ChoicePreference,
    NumberPreference,
)
from cpm_app.session.storage.preferences import Preferences
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtCore import QSettings

STORED = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=8),
    st.lists(st.text(max_size=3), max_size=3),
    st.sampled_from(["true", "#00ff00", "#GG0000", "nan", "1e999", "light"]),
)  # fmt: skip


@pytest.mark.parametrize("preference", ALL_PREFERENCES, ids=lambda preference: preference.name)
def test_a_preference_has_words_a_page_and_a_default_that_it_accepts(preference) -> None:
    assert preference.label
    assert preference.parse_stored(preference.default) == preference.default
    assert preference.parse_stored(str(preference.default).lower()) == preference.default


@given(stored=STORED)
def test_any_stored_value_is_taken_within_the_limits_or_not_at_all(stored) -> None:
    for preference in ALL_PREFERENCES:
        taken = preference.parse_stored(stored)
        assert taken is None or type(taken) is type(preference.default)
        if isinstance(preference, NumberPreference) and taken is not None:
            assert preference.low <= taken <= preference.high
        if isinstance(preference, ChoicePreference) and taken is not None:
            assert taken in preference.choices


def test_a_broken_value_becomes_the_default() -> None:
    preferences = Preferences()
    preferences.store_key(CONTOUR_WIDTH.name, "wide")
    preferences.store_key(THEME_PREFERENCE.name, "sepia")
    assert preferences.read_preference(CONTOUR_WIDTH) == CONTOUR_WIDTH.default
    assert preferences.read_preference(THEME_PREFERENCE) == "system"


def test_a_value_comes_back_from_the_file_and_the_default_is_not_stored() -> None:
    preferences, seen = Preferences(), []
    preferences.changed.connect(seen.append)
    preferences.store_preference(CONTOUR_WIDTH, 3.5)
    preferences.store_preference(CONTOUR_WIDTH, 3.5)
    preferences.flush()
    assert Preferences().read_preference(CONTOUR_WIDTH) == 3.5
    preferences.store_preference(CONTOUR_WIDTH, CONTOUR_WIDTH.default)
    assert seen == [CONTOUR_WIDTH.name] * 2
    preferences.flush()
    kept = QSettings(QSettings.Format.IniFormat, QSettings.Scope.UserScope, "cpm", "cpm")
    assert CONTOUR_WIDTH.name not in kept.allKeys()


@pytest.fixture
def in_unit():
    yield lengths.prefer_unit
    lengths.prefer_unit("image")


@pytest.mark.parametrize(
    ("unit", "spacing", "wanted", "shown"),
    [
        ("µm", (0.5, 0.5), "image", PixelSize((0.5, 0.5), "µm")),
        ("µm", (0.5, 0.5), "px", PixelSize((1.0, 1.0), None, 2.0)),
        ("µm", (0.5, 0.5), "nm", PixelSize((500.0, 500.0), "nm", 1000.0)),
        ("mm", (0.5, 2.0), "cm", PixelSize((0.05, 0.2), "cm", 0.1)),
        ("mm", (0.5, 2.0), "px", PixelSize((0.5, 2.0), "mm")),
        ("furlong", (3.0, 3.0), "mm", PixelSize((3.0, 3.0), "furlong")),
        (None, (1.0, 1.0), "mm", PixelSize((1.0, 1.0), None)),
    ],
)
def test_lengths_are_shown_in_the_preferred_unit_where_that_is_possible(in_unit, unit, spacing, wanted, shown) -> None:
    in_unit(wanted)
    found = preferred_pixel_size(spacing, unit)
    assert found.unit == shown.unit
    assert found.spacing == pytest.approx(shown.spacing)
    assert found.factor == pytest.approx(shown.factor)


@pytest.mark.parametrize(
    ("spacing", "unit", "wanted", "said"),
    [
        ((0.5, 0.5), "µm", "image", "12.34 µm"),
        ((0.5, 0.5), "µm", "px", "24.7 px"),
        ((0.5, 0.5), "µm", "nm", "12,340 nm"),
        ((0.5, 2.0), "µm", "image", "24.7 px"),
        ((1.0, 1.0), None, "mm", "24.7 px"),
    ],
)
def test_a_measured_length_follows_the_same_rule(in_unit, spacing, unit, wanted, said) -> None:
    in_unit(wanted)
    assert lengths.format_measured_length(24.68, spacing, unit) == said


ACTIONS = (
    ActionKeys("run", "Run", "Run", ("Space",)),
    ActionKeys("open", "Open", "File", ("Ctrl+O",)),
    ActionKeys("redo", "Redo", "Edit", ("Ctrl+Y", "Ctrl+Shift+Z")),
    ActionKeys("about", "About", "Help", ()),
)


@given(st.lists(st.tuples(st.sampled_from(ACTIONS), st.sampled_from(["", "Space", "Ctrl+O", "Ctrl+Y", "F5"]))))
def test_no_key_ever_belongs_to_two_actions(changes) -> None:
    chosen = {}
    for action, key in changes:
        chosen = shortcuts.assign_key(key, action, ACTIONS, chosen)
        assert shortcuts.find_action_keys(action, chosen) == ((key,) if key else ())
        held = [key for one in ACTIONS for key in shortcuts.find_action_keys(one, chosen)]
        assert len(held) == len(set(held))
        assert shortcuts.parse_shortcuts(shortcuts.encode_shortcuts(chosen)) == chosen


def test_an_action_with_its_default_keys_is_not_stored() -> None:
    chosen = shortcuts.assign_key("F5", ACTIONS[0], ACTIONS, {})
    assert shortcuts.assign_key("Space", ACTIONS[0], ACTIONS, chosen) == {}
