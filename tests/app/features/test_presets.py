"""Presets: used from the gallery, saved, renamed, deleted and shared as files; a damaged file is reported."""

from __future__ import annotations

import json
from dataclasses import fields, replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtCore import Qt
from PySide6.QtGui import QImage, QPixmap
from PySide6.QtWidgets import QFileDialog, QMenu

from app.model.parameters.presets import Preset, built_in, checked_name, read, written
from app.session.storage.presets import PresetStore
from app.views.features.run import ParametersFeature
from app.views.presets import preset_files as dialogs
from app.views.presets.preset_gallery import PICTURE, PresetGallery, picture_of
from cpm_core.parameters import PARAMETERS, PLANE_PRESETS, PRESETS, Parameters
from cpm_core.parameters.choices import CHOICES

pytestmark = pytest.mark.shared_window

OWN = Preset("Mine & yours ‹1›", Parameters(beta=1.25, smoothing="auto", scales=2), "For tests.", b"\x89PNG")


@pytest.fixture
def store(tmp_path, qapp) -> PresetStore:
    return PresetStore(tmp_path / "presets")


def test_the_built_in_presets_are_those_of_the_core_with_text_and_picture(qapp) -> None:
    assert {preset.key: preset.parameters for preset in built_in()} == PLANE_PRESETS
    for preset in built_in():
        assert preset.about
        assert not QImage.fromData(preset.picture).isNull()


def free(name: str) -> bool:
    """Whether a preset may have a name: it is not blank, and none of the program has it."""
    return " ".join(name.split()) not in {"", *(preset.name for preset in built_in())}


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
    st.binary(max_size=50),
)
def test_a_preset_is_read_as_it_was_written(parameters, name, picture) -> None:
    preset = Preset(checked_name(name), parameters, "about", picture)
    assert read(written(preset), "a file") == preset


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda kept: [], "not a preset of CPM"),
        (lambda kept: kept | {"format": "other"}, "not a preset of CPM"),
        (lambda kept: kept | {"version": 2}, "newer CPM"),
        (lambda kept: kept | {"version": "1"}, "damaged"),
        (lambda kept: kept | {"name": 7}, "damaged"),
        (lambda kept: kept | {"name": "   "}, "needs a name"),
        (lambda kept: kept | {"name": "x" * 61}, "61 letters"),
        (lambda kept: kept | {"name": built_in()[0].name}, "comes with the program"),
        (lambda kept: kept | {"parameters": None}, "holds no parameters"),
        (lambda kept: kept | {"parameters": {"betta": 1.0}}, "no parameter betta"),
        (lambda kept: kept | {"parameters": {"beta": 99.0}}, "beta is 99 but must be a number from 0 to 4"),
        (lambda kept: kept | {"parameters": {"beta": "much"}}, 'beta is "much"'),
    ],
)
def test_a_file_that_is_no_preset_is_rejected_with_a_message(change, message) -> None:
    kept = change(json.loads(written(OWN)))
    with pytest.raises(ValueError, match=message) as caught:
        read(json.dumps(kept).encode(), "shared.cpmpreset")
    assert "shared.cpmpreset" in str(caught.value)
    assert str(caught.value).endswith(".")


@given(st.binary(max_size=300))
def test_arbitrary_bytes_raise_only_a_value_error(content) -> None:
    with pytest.raises(ValueError, match="not a preset of CPM"):
        read(content, "a file")


def test_parameters_missing_in_a_file_have_their_defaults() -> None:
    kept = json.loads(written(OWN))
    kept["parameters"] = {"beta": 1.0}
    assert read(json.dumps(kept).encode(), "a file").parameters == Parameters(beta=1.0)
    assert {field.name for field in fields(Parameters)} == {*PARAMETERS, *CHOICES}


def test_a_preset_is_saved_found_renamed_and_deleted(store, qtbot) -> None:
    with qtbot.waitSignal(store.changed):
        store.save(OWN)
    assert PresetStore(store.folder).called(OWN.name) == OWN
    store.rename(OWN.name, "Other")
    assert PresetStore(store.folder).called("Other") == replace(OWN, name="Other")
    assert store.called(OWN.name) is None
    store.delete("Other")
    assert not list(store.folder.iterdir())
    assert [preset.own for preset in store.presets] == [False] * len(PLANE_PRESETS)


def test_names_in_use_and_changes_of_built_in_presets_are_rejected(store) -> None:
    store.save(OWN)
    store.save(replace(OWN, name="Second"))
    with pytest.raises(ValueError, match="already"):
        store.rename("Second", OWN.name)
    for name in ("Nobody", built_in()[0].name):
        with pytest.raises(ValueError, match="of your own"):
            store.delete(name)
    assert len([preset for preset in store.presets if preset.own]) == 2


def test_a_preset_is_imported_under_a_free_name_and_damaged_files_are_ignored(store, tmp_path) -> None:
    shared = tmp_path / "shared.cpmpreset"
    store.hand_out(OWN, shared)
    assert store.bring_in(shared).name == OWN.name
    assert store.bring_in(shared).name == f"{OWN.name} 2"
    (store.folder / "broken.cpmpreset").write_bytes(b"{")
    assert len(PresetStore(store.folder).presets) == len(PLANE_PRESETS) + 2


# In the window


@pytest.fixture
def gallery(window) -> PresetGallery:
    return window.panels["parameters"].gallery


def test_a_preset_is_chosen_from_the_gallery_with_the_keys_and_undone(window, hand, gallery) -> None:
    assert gallery.current.key == "shape"
    gallery.setFocus()
    hand.qtbot.keyClick(gallery, Qt.Key.Key_Return)
    assert gallery.popup.isVisible()
    hand.qtbot.keyClick(gallery.pictures, Qt.Key.Key_Right)
    hand.qtbot.keyClick(gallery.pictures, Qt.Key.Key_Return)
    assert not gallery.popup.isVisible()
    assert window.session.document.parameters == PRESETS["automatic"]
    assert "Automatic" in gallery.text()
    window.panels["parameters"].rows["beta"].slider.setValue(3)
    assert gallery.current is None
    window.session.undo()
    window.session.undo()
    assert gallery.current.key == "shape"


@pytest.mark.own_window
def test_pictures_of_presets_are_decoded_when_they_are_seen(hand, gallery) -> None:
    assert not gallery.pictures.count()
    hand.qtbot.mouseClick(gallery, Qt.MouseButton.LeftButton)
    assert gallery.pictures.count()


def test_a_preset_is_chosen_with_the_mouse(window, hand, gallery) -> None:
    hand.qtbot.mouseClick(gallery, Qt.MouseButton.LeftButton)
    item = gallery.pictures.item(list(PRESETS).index("noisy"))
    place = gallery.pictures.visualItemRect(item).center()
    hand.qtbot.mouseClick(gallery.pictures.viewport(), Qt.MouseButton.LeftButton, pos=place)
    assert window.session.document.parameters == PRESETS["noisy"]


def test_own_presets_are_saved_with_a_picture_renamed_shared_and_deleted(
    window, hand, gallery, monkeypatch, tmp_path
) -> None:
    preset_files = window.feature(ParametersFeature).preset_files
    window.panels["parameters"].rows["beta"].slider.setValue(3)
    mine = window.session.document.parameters
    monkeypatch.setattr(dialogs, "ask_for_name", lambda parent, suggestion: "Soft")
    preset_files.save.trigger()
    kept = preset_files.store.called("Soft")
    assert kept.parameters == mine
    assert QImage.fromData(kept.picture).width() == 2 * PICTURE.width()
    assert gallery.current == kept
    monkeypatch.setattr(dialogs, "ask_for_name", lambda parent, suggestion: f"{suggestion}er")
    preset_files.rename.trigger()
    assert gallery.current.name == "Softer"
    shared = tmp_path / "softer.cpmpreset"
    monkeypatch.setattr(dialogs, "ask_for_preset", lambda parent, names, question, button: names[0])
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(shared), ""))
    preset_files.export_action.trigger()
    monkeypatch.setattr(dialogs, "agrees_to_delete", lambda parent, name: True)
    preset_files.delete.trigger()
    assert preset_files.store.called("Softer") is None
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_: (str(shared), ""))
    preset_files.import_action.trigger()
    assert gallery.current.name == "Softer"


def test_a_bad_file_is_reported_in_the_message_bar(window, monkeypatch, tmp_path) -> None:
    preset_files = window.feature(ParametersFeature).preset_files
    bad = tmp_path / "bad.cpmpreset"
    bad.write_text("nothing")
    for path in (bad, tmp_path / "nowhere.cpmpreset"):
        monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_, path=path: (str(path), ""))
        preset_files.import_action.trigger()
        assert path.name in window.canvas_area.messages.text


def test_the_menu_offers_every_preset(window) -> None:
    inner = next(menu for menu in window.menus["Run"].findChildren(QMenu) if menu.title() == "&Preset")
    inner.aboutToShow.emit()
    texts = [action.text() for action in inner.actions()]
    assert texts[: len(PLANE_PRESETS)] == [preset.name for preset in built_in()]
    assert inner.actions()[0].isChecked()
    inner.actions()[1].trigger()
    assert window.session.document.parameters == PRESETS["automatic"]


@pytest.mark.parametrize("size", [(50, 400), (400, 50), (10, 10)])
def test_pictures_have_the_size_of_the_gallery_for_any_canvas(qapp, size) -> None:
    canvas = QPixmap(*size)
    canvas.fill()
    assert QImage.fromData(picture_of(canvas.toImage())).width() == 2 * PICTURE.width()
