"""Presets: used from a menu, saved and deleted; a damaged file is reported."""

from __future__ import annotations

import json
from pathlib import Path
from unittest.mock import Mock

import pytest
from cpm_app.model.parameters.presets import Preset, built_in_presets, check_preset_name, decode_preset, encode_preset
from cpm_app.session.storage.presets import PresetStore
from cpm_app.views.features.run import RunControlFeature
from cpm_app.views.panels import presets as dialogs
from cpm_app.views.panels.presets import PresetBox
from cpm_app.views.window.dialogs import QuestionDialog
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtCore import Qt

from cpm_core.parameters import PARAMETERS, PLANE_PRESETS, PRESETS, Parameters

pytestmark = pytest.mark.shared_window

OWN = Preset("Mine & yours ‹1›", Parameters(beta=1.25, smoothing="auto", scales=2), "For tests.")


def called(store: PresetStore, name: str):
    """The preset of a store that has this name."""
    return next((preset for preset in store.presets if preset.name == name), None)


@pytest.fixture
def store(tmp_path, qapp) -> PresetStore:
    return PresetStore(tmp_path / "presets")


def free(name: str) -> bool:
    """Whether a preset may have a name: it is not blank, and none of the program has it."""
    return " ".join(name.split()) not in {"", *(preset.name for preset in built_in_presets())}


@given(
    st.builds(
        Parameters,
        **{
            name: st.floats(info.slider_low, info.slider_high)
            for name, info in PARAMETERS.items()
            if name not in ("scales", "w1", "w2")
        },
        scales=st.integers(1, 8),
        w1=st.floats(0.0, 1.0),
        w2=st.floats(1.5, 3.0),
    ),
    st.text(min_size=1, max_size=40).filter(free),
)
def test_a_preset_is_read_as_it_was_written(parameters, name) -> None:
    preset = Preset(check_preset_name(name), parameters, "about")
    assert decode_preset(encode_preset(preset)) == preset


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda kept: {"name": kept["name"]}, "not a preset of CPM"),
        (lambda kept: kept | {"name": "   "}, "needs a name"),
        (lambda kept: kept | {"parameters": {"beta": 99.0}}, "beta is 99 but must be a number from 0 to 4"),
    ],
)
def test_a_file_that_is_no_preset_is_rejected_with_a_message(change, message) -> None:
    with pytest.raises(ValueError, match=message):
        decode_preset(json.dumps(change(json.loads(encode_preset(OWN)))).encode())


@given(st.binary(max_size=300))
def test_arbitrary_bytes_raise_only_a_value_error(content) -> None:
    with pytest.raises(ValueError):
        decode_preset(content)


def test_a_preset_is_saved_found_and_deleted_and_damaged_files_are_ignored(store, qtbot) -> None:
    with qtbot.waitSignal(store.changed):
        store.save(OWN)
    (store.folder / "broken.cpmpreset").write_bytes(b"{")
    assert called(PresetStore(store.folder), OWN.name) == OWN
    assert len(PresetStore(store.folder).presets) == len(PLANE_PRESETS) + 1
    store.delete(OWN.name)
    assert [preset.is_own for preset in store.presets] == [False] * len(PLANE_PRESETS)


# In the window


@pytest.fixture
def presets(window) -> PresetBox:
    return window.get_feature(RunControlFeature).presets


def test_a_preset_is_chosen_with_the_keys_and_undone(window, hand, presets) -> None:
    assert presets.current.key == "shape"
    presets.setFocus()
    hand.qtbot.keyClick(presets, Qt.Key.Key_Down)
    assert window.session.document.parameters == PRESETS["automatic"]
    assert "Automatic" in presets.currentText()
    assert presets.toolTip().startswith(f"{presets.currentText()}\n")
    window.panels["run"].parameters.rows["beta"].slider.setValue(3)
    assert presets.current is None
    assert (presets.currentText(), presets.placeholderText()) == ("", "Custom parameters")
    window.session.undo()
    window.session.undo()
    assert presets.current.key == "shape"


def test_own_presets_are_saved_and_deleted(window, presets, monkeypatch) -> None:
    window.panels["run"].parameters.rows["beta"].slider.setValue(3)
    mine = window.session.document.parameters
    assert not window.actions_by_name["delete_preset"].isEnabled()
    monkeypatch.setattr(dialogs, "ask_for_text", lambda *_: "Soft")
    window.actions_by_name["save_preset"].trigger()
    assert called(presets.store, "Soft").parameters == mine
    assert presets.current.name == "Soft"
    monkeypatch.setattr(QuestionDialog, "wait_for_answer", lambda _: "delete")
    window.actions_by_name["delete_preset"].trigger()
    assert called(presets.store, "Soft") is None


def test_a_preset_that_cannot_be_deleted_is_told_in_a_sentence(window, presets, monkeypatch) -> None:
    monkeypatch.setattr(dialogs, "ask_for_text", lambda *_: "Soft")
    window.panels["run"].parameters.rows["beta"].slider.setValue(3)
    presets.save_preset()
    monkeypatch.setattr(QuestionDialog, "wait_for_answer", lambda _: "delete")
    with monkeypatch.context() as read_only:
        read_only.setattr(Path, "unlink", Mock(side_effect=PermissionError(13, "Permission denied")))
        presets.delete_preset()
    assert "Permission denied" in window.canvas_area.messages.text
    assert called(presets.store, "Soft") is not None
    presets.delete_preset()
