"""All channels of a file are shown together, each in its color, while a run works on the one that is open."""

from __future__ import annotations

import numpy as np
import pytest
import tifffile
from cpm_app.model.display.channels import list_channels
from cpm_app.model.volume.parts import FileParts
from cpm_app.session.features import channel_images
from cpm_app.views.features.files import OpenSaveFeature
from cpm_app.views.features.volumes import PagesFeature, SlicesFeature, SpaceFeature
from cpm_app.views.layers import image_layer
from PySide6.QtCore import QPoint, Qt

from tests.app.views.volume.conftest import ball, open_file

pytestmark = pytest.mark.shared_window

SHADES = (200, 150, 100)
"""Largest gray value of each channel, whose smallest is 0."""

OME = {"Name": ["DAPI", "GFP", ""], "Color": [0x00FFFFFF, -16776961, 0x0000FFFF]}
"""Cyan, red and blue, with the opacity in the last byte, as a signed number."""


def squares() -> np.ndarray:
    """Three channels with a bright square each, from left to right."""
    pixels = np.zeros((3, 40, 90), np.uint16)
    for channel, shade in enumerate(SHADES):
        pixels[channel, 10:30, 5 + 30 * channel : 25 + 30 * channel] = shade
    return pixels


@pytest.fixture
def composite(window, hand, tmp_path):
    """A window on a file of three channels without colors."""
    tifffile.imwrite(tmp_path / "three.tif", squares(), photometric="minisblack", metadata={"axes": "CYX"}, ome=True)
    open_channels(window, hand, tmp_path / "three.tif")
    yield window
    layer(window).set_option("content", "colors")


def layer(window):
    return window.canvas_area.canvas.layers["image"]


def bar(window):
    return window.get_feature(PagesFeature).channels


def colors(hand) -> list[tuple[int, int, int]]:
    """Color of the square of each channel."""
    return [hand.color_at(20.0, 15.0 + 30.0 * channel) for channel in range(3)]


def open_channels(window, hand, path) -> None:
    open_file(window, hand, path)
    wait_for_channels(window, hand)


def wait_for_channels(window, hand) -> None:
    """Wait until every channel that is shown has been read."""

    def is_complete() -> bool:
        shown = {index for index, look in enumerate(layer(window).looks) if look.shown}
        return window.session.idle and window.turns.is_idle and not shown - {*layer(window).shown_channels, here()}

    def here() -> int:
        return layer(window).open_channel

    hand.wait(is_complete)


def choose(window, hand, channel: int) -> None:
    """Work on another channel, by the number of it."""
    field = window.get_feature(PagesFeature).bar.number
    field.setFocus()
    field.selectAll()
    hand.qtbot.keyClicks(field, str(channel + 1))
    hand.qtbot.keyClick(field, Qt.Key.Key_Return)
    hand.wait(lambda: layer(window).open_channel == channel and window.session.idle)
    wait_for_channels(window, hand)


def click(hand, button) -> None:
    hand.qtbot.mouseClick(button, Qt.MouseButton.LeftButton, pos=button.rect().center() / 2)


def choose_in_menu(window, hand, channel: int, title: str) -> None:
    """Choose an entry of the menu of a channel."""
    menu = bar(window).buttons[channel].menu()
    menu.popup(QPoint(0, 0))
    (action,) = (each for each in menu.actions() if each.text() == title)
    hand.qtbot.mouseClick(menu, Qt.MouseButton.LeftButton, pos=menu.actionGeometry(action).center())


def test_channels_without_colors_get_the_usual_ones_and_each_is_switched_by_a_click(composite, hand) -> None:
    assert bar(composite).isVisible() and [button.text() for button in bar(composite).buttons] == ["1", "2", "3"]
    assert colors(hand) == [(255, 0, 0), (0, 255, 0), (0, 0, 255)]
    click(hand, bar(composite).buttons[1])
    assert colors(hand) == [(255, 0, 0), (0, 0, 0), (0, 0, 255)]
    click(hand, bar(composite).buttons[0])
    assert colors(hand) == [(0, 0, 0), (0, 0, 0), (0, 0, 255)]
    click(hand, bar(composite).buttons[1])
    assert colors(hand) == [(0, 0, 0), (0, 255, 0), (0, 0, 255)]
    click(hand, bar(composite).composite)
    assert colors(hand) == [(255, 255, 255), (0, 0, 0), (0, 0, 0)]
    assert not bar(composite).buttons[1].isEnabled()


def test_many_channels_are_reached_by_scrolling_and_seven_are_shown_at_first(composite, hand, tmp_path) -> None:
    pixels, names = np.tile(squares(), (5, 1, 1)), [f"marker {index}" for index in range(15)]
    tifffile.imwrite(tmp_path / "many.ome.tif", pixels, photometric="minisblack",
                     metadata={"axes": "CYX", "Channel": {"Name": names}})  # fmt: skip
    low = bar(composite).height()
    open_channels(composite, hand, tmp_path / "many.ome.tif")
    assert [button.isChecked() for button in bar(composite).buttons] == [True] * 7 + [False] * 8
    scroll_bar = bar(composite).horizontalScrollBar()
    hand.wait(lambda: scroll_bar.maximum() > 0)
    assert bar(composite).height() > low
    bar(composite).buttons[-1].setFocus()
    bar(composite).ensureWidgetVisible(bar(composite).buttons[-1])
    assert not bar(composite).buttons[-1].visibleRegion().isEmpty()


def test_light_of_channels_adds_up_to_white_at_most(window, hand, tmp_path) -> None:
    pixels = squares()
    pixels[1] = pixels[2] = pixels[0]
    pixels[2, :, 15:] //= 4
    tifffile.imwrite(tmp_path / "same.tif", pixels, photometric="minisblack", metadata={"axes": "CYX"}, ome=True)
    open_channels(window, hand, tmp_path / "same.tif")
    assert hand.color_at(20.0, 8.0) == (255, 255, 255) and hand.color_at(20.0, 20.0) == (255, 255, 64)


def test_a_file_gives_names_and_colors_of_its_channels(window, hand, tmp_path) -> None:
    path, metadata = tmp_path / "named.ome.tif", {"axes": "CYX", "Channel": OME}
    tifffile.imwrite(path, squares(), photometric="minisblack", metadata=metadata)
    open_channels(window, hand, path)
    assert [button.text() for button in bar(window).buttons] == ["1 DAPI", "2 GFP", "3"]
    assert colors(hand) == [(0, 255, 255), (255, 0, 0), (0, 0, 255)]
    choose_in_menu(window, hand, 2, "Gray")
    assert colors(hand)[2] == (255, 255, 255)


def test_another_file_gives_its_channels_its_own_colors_also_where_their_names_are_the_same(
    window, hand, tmp_path
) -> None:
    for name, colors_there in (("one.ome.tif", OME["Color"]), ("other.ome.tif", OME["Color"][::-1])):
        metadata = {"axes": "CYX", "Channel": {**OME, "Color": colors_there}}
        tifffile.imwrite(tmp_path / name, squares(), photometric="minisblack", metadata=metadata)
        open_channels(window, hand, tmp_path / name)
    assert colors(hand) == [(0, 0, 255), (255, 0, 0), (0, 255, 255)]


def test_tables_and_ranges_of_imagej_are_those_of_the_channels(window, hand, tmp_path) -> None:
    tables = [np.outer(color, np.arange(256)).astype(np.uint8) for color in ((1, 1, 0), (1, 0, 1), (0, 1, 0))]
    metadata = {"axes": "CYX", "mode": "composite", "LUTs": tables, "Ranges": (0.0, 600.0, 0.0, 150.0, 0.0, 150.0)}
    tifffile.imwrite(tmp_path / "j.tif", squares(), imagej=True, metadata=metadata)
    open_channels(window, hand, tmp_path / "j.tif")
    assert colors(hand) == [(85, 85, 0), (255, 0, 255), (0, 170, 0)]


def test_each_channel_keeps_its_range_when_another_one_is_worked_on(composite, hand) -> None:
    layer(composite).set_window(0.0, 3.0 * SHADES[0])
    before = composite.session.image.values
    choose(composite, hand, 2)
    assert composite.session.document.image.reading.channel == 3 and composite.workspace.pages.number == 3
    np.testing.assert_array_equal(composite.session.image.values, squares()[2])
    assert layer(composite).get_choice("range") == "0" and layer(composite).window == (0.0, SHADES[2])
    layer(composite).set_window(0.0, 5.0 * SHADES[2])
    assert colors(hand) == [(85, 0, 0), (0, 255, 0), (0, 0, 51)]
    assert bar(composite).buttons[2].font().bold() and not bar(composite).buttons[0].font().bold()
    choose(composite, hand, 0)
    assert layer(composite).window == (0.0, 3.0 * SHADES[0])
    assert colors(hand) == [(85, 0, 0), (0, 255, 0), (0, 0, 51)]
    np.testing.assert_array_equal(composite.session.image.values, before)


def test_a_session_brings_back_the_looks_of_channels_and_reads_none_that_is_off(
    composite, hand, image_file, tmp_path, monkeypatch
) -> None:
    click(hand, bar(composite).buttons[1])
    choose_in_menu(composite, hand, 2, "Yellow")
    layer(composite).set_window(0.0, 3.0 * SHADES[0])
    expected = [(85, 0, 0), (0, 0, 0), (255, 255, 0)]
    assert colors(hand) == expected
    saved = tmp_path / "kept.cpm"
    composite.get_feature(OpenSaveFeature).document_file.save_and_wait(saved)
    open_file(composite, hand, image_file)
    assert not bar(composite).isVisible() and layer(composite).looks == []
    read, load = [], channel_images.load_channel
    monkeypatch.setattr(channel_images, "load_channel", lambda *given: read.append(given[1].channel) or load(*given))
    composite.open_image(str(saved))
    hand.wait(lambda: composite.session.document.image.name == "three.tif" and composite.session.idle)
    wait_for_channels(composite, hand)
    assert colors(hand) == expected and read == [3]
    assert not composite.get_feature(OpenSaveFeature).document_file.unsaved


def test_a_session_brings_back_the_buttons_of_channels_too(composite, hand, image_file, tmp_path) -> None:
    for button in bar(composite).buttons[1:]:
        click(hand, button)
    choose_in_menu(composite, hand, 0, "Yellow")
    icon, saved = bar(composite).buttons[0].icon().pixmap(14).toImage(), tmp_path / "kept.cpm"
    composite.get_feature(OpenSaveFeature).document_file.save_and_wait(saved)
    open_file(composite, hand, image_file)
    composite.open_image(str(saved))
    hand.wait(lambda: composite.session.document.image.name == "three.tif" and composite.session.idle)
    wait_for_channels(composite, hand)
    assert [button.isChecked() for button in bar(composite).buttons] == [True, False, False]
    assert bar(composite).buttons[0].icon().pixmap(14).toImage() == icon
    assert colors(hand) == [(255, 255, 0), (0, 0, 0), (0, 0, 0)]


def test_the_channels_of_a_volume_are_seen_in_all_slices_in_space_and_at_other_times(window, hand, tmp_path) -> None:
    values = np.stack([[ball(), ball(4.0)], [ball(), ball(10.0)]]).astype(np.uint16).transpose(0, 2, 1, 3, 4)
    tifffile.imwrite(tmp_path / "film.ome.tif", values, photometric="minisblack", metadata={"axes": "TZCYX"})
    window.session.open_file(tmp_path / "film.ome.tif", as_volume=True)
    hand.wait(lambda: window.session.document.image.name == "film.ome.tif" and window.session.idle)
    wait_for_channels(window, hand)
    for view in (window.canvas_area.canvas, *window.get_feature(SlicesFeature).sides):
        ((shown, color),) = view.layers["image"]._item._others
        assert color == "#00ff00"
        expected = view.shown_slice.slice_array(values[0, :, 1])
        np.testing.assert_array_equal(shown.shades == 255, expected == expected.max())
    panel = window.get_feature(SpaceFeature).panel
    for part in ("slices", "projection"):
        panel.bar.checks[part].setChecked(True)
        hand.wait(lambda: panel.view.is_idle)
        found = panel.view._frame.picture.colors.reshape(-1, 3)
        assert (found == (255, 255, 0)).all(axis=1).any() and (found[:, 0] > found[:, 1]).any(), part
        panel.bar.checks[part].setChecked(False)
    assert hand.color_at(13.5, 15.5) == (255, 255, 0) and hand.color_at(13.5, 21.0) == (255, 0, 0)
    window.get_feature(PagesFeature).bar.number.setValue(2)
    hand.wait(lambda: window.workspace.pages.number == 2 and window.session.idle)
    wait_for_channels(window, hand)
    assert hand.color_at(13.5, 21.0) == (255, 255, 0)


def test_channels_of_large_images_have_ranges_of_their_own_at_any_magnification(
    window, hand, tmp_path, monkeypatch
) -> None:
    monkeypatch.setattr(image_layer, "_MAX_IMMEDIATE_PIXELS", 10)
    pixels = squares().repeat(8, axis=1).repeat(8, axis=2)
    tifffile.imwrite(tmp_path / "large.tif", pixels, photometric="minisblack", metadata={"axes": "CYX"}, ome=True)
    open_channels(window, hand, tmp_path / "large.tif")
    layer(window).set_look(1, window=(0.0, 3.0 * SHADES[1]))
    layer(window).set_look(0, shown=False)
    places = [(160.0, 120.0 + 240.0 * channel) for channel in range(3)]
    assert [hand.color_at(*place) for place in places] == [(0, 0, 0), (0, 85, 0), (0, 0, 255)]
    hand.canvas.look_at(places[1], 20.0)
    assert hand.color_at(*places[1]) == (0, 85, 0)


def test_a_file_that_is_opened_while_channels_of_another_are_read_is_complete(window, hand, tmp_path) -> None:
    for name, pixels in (("one.tif", squares()), ("other.tif", squares()[:, ::-1, ::-1])):
        tifffile.imwrite(tmp_path / name, pixels, photometric="minisblack", metadata={"axes": "CYX"}, ome=True)
    window.session.open_file(tmp_path / "one.tif")
    hand.wait(lambda: window.workspace.channel_images._wanted == {0, 1, 2})
    window.session.open_file(tmp_path / "other.tif")
    hand.wait(lambda: window.session.document.image.name == "other.tif")
    wait_for_channels(window, hand)
    assert colors(hand) == [(0, 0, 255), (0, 255, 0), (255, 0, 0)]


def test_red_green_and_blue_are_no_channels_of_a_composite(window, hand, tmp_path) -> None:
    tifffile.imwrite(tmp_path / "rgb.tif", np.moveaxis(squares(), 0, -1).astype(np.uint8), photometric="rgb")
    open_file(window, hand, tmp_path / "rgb.tif")
    assert not bar(window).isVisible() and window.session.scene.channels == ()


def test_of_channels_one_of_which_cannot_be_read_the_others_are_shown(window, hand, tmp_path, monkeypatch) -> None:
    tifffile.imwrite(tmp_path / "cut.tif", squares(), photometric="minisblack", metadata={"axes": "CYX"}, ome=True)
    load = channel_images.load_channel

    def load_all_but_one(path, reading, *given):
        if reading.channel == 2:
            raise ValueError("cut.tif is damaged or cut short.")
        return load(path, reading, *given)

    monkeypatch.setattr(channel_images, "load_channel", load_all_but_one)
    open_file(window, hand, tmp_path / "cut.tif")
    hand.wait(lambda: 2 in layer(window).shown_channels)
    assert colors(hand) == [(255, 0, 0), (0, 0, 0), (0, 0, 255)]
    assert window.canvas_area.messages.text == "Channel 2 is not shown: cut.tif is damaged or cut short."


@pytest.mark.parametrize(
    ("name", "method"), [("", ""), ("TL Brightfield", ""), ("", "Phase"), ("Ch2", "HoffmanModulation")]
)
def test_transmitted_light_is_gray_and_off_at_first_unless_it_is_open(
    window, hand, tmp_path, monkeypatch, name, method
) -> None:
    pixels, read, load = squares(), [], channel_images.load_channel
    pixels[1] = 180 - pixels[1]
    monkeypatch.setattr(channel_images, "load_channel", lambda *given: read.append(given[1].channel) or load(*given))
    metadata = {"axes": "CYX", "Channel": {"Name": ["DAPI", name, "GFP"]}}
    if method:
        metadata["Channel"]["ContrastMethod"] = ["Fluorescence", method, "Fluorescence"]
    tifffile.imwrite(tmp_path / "light.ome.tif", pixels, photometric="minisblack", metadata=metadata)
    open_channels(window, hand, tmp_path / "light.ome.tif")
    hand.wait(lambda: [button.isChecked() for button in bar(window).buttons] == [True, False, True])
    assert colors(hand) == [(255, 0, 0), (0, 0, 0), (0, 0, 255)]
    assert (2 in read) == (not name + method)
    choose(window, hand, 1)
    assert [button.isChecked() for button in bar(window).buttons] == [True, True, True]
    assert colors(hand) == [(255, 255, 255), (0, 0, 0), (255, 255, 255)]
    choose(window, hand, 0)
    assert not bar(window).buttons[1].isChecked()
    click(hand, bar(window).buttons[1])
    wait_for_channels(window, hand)
    assert bar(window).buttons[1].isChecked() and hand.color_at(2.0, 2.0) == (255, 255, 255)


@pytest.mark.parametrize(
    ("name", "is_bright"), [("Phase", True), ("Ch2 Phase", True), ("Cells phase", True), ("S-phase", False)]
)
def test_the_phase_of_light_is_told_from_that_of_cells(name, is_bright) -> None:
    (channel, _) = list_channels(FileParts(1, channels=2, channel_styles=((name, ""), ("GFP", ""))))
    assert channel.is_bright == is_bright


def test_channels_that_are_all_bright_are_all_shown(window, hand, tmp_path) -> None:
    pixels = 255 - squares()
    tifffile.imwrite(tmp_path / "stained.tif", pixels, photometric="minisblack", metadata={"axes": "CYX"}, ome=True)
    open_channels(window, hand, tmp_path / "stained.tif")
    assert [button.isChecked() for button in bar(window).buttons] == [True] * 3
    assert hand.color_at(2.0, 2.0) == (255, 255, 255) and hand.color_at(20.0, 15.0) == (0, 255, 255)


def test_the_menu_of_a_channel_marks_its_color_and_range(composite, hand) -> None:
    menu = bar(composite).buttons[2].menu()
    for chosen in ("", "Cyan", "Red"):
        if chosen:
            choose_in_menu(composite, hand, 2, chosen)
        menu.popup(QPoint(0, 0))
        assert [each.text() for each in menu.actions() if each.isChecked()] == [chosen or "Blue", "All gray values"]
        menu.close()


def test_the_menu_of_a_channel_has_its_range(window, hand, tmp_path) -> None:
    pixels = squares()
    pixels[1, :4, :18] = 2 * SHADES[1]  # 2 % of the pixels
    tifffile.imwrite(tmp_path / "range.tif", pixels, photometric="minisblack", metadata={"axes": "CYX"}, ome=True)
    open_channels(window, hand, tmp_path / "range.tif")
    assert colors(hand) == [(255, 0, 0), (0, 128, 0), (0, 0, 255)]
    for channel, color in ((1, (0, 255, 0)), (0, (255, 0, 0))):
        choose_in_menu(window, hand, channel, "All except 5 % at either end")
        assert colors(hand)[channel] == color
    assert layer(window).get_choice("range") == "5" and layer(window).channel_range(1) == "5"
    choose_in_menu(window, hand, 1, "All gray values")
    assert colors(hand)[1] == (0, 128, 0)


def test_a_channel_keeps_its_range_by_hand_as_it_is_chosen_again(composite, hand) -> None:
    layer(composite).set_window(0.0, 2.0 * SHADES[0])
    choose(composite, hand, 1)
    before = colors(hand)
    choose_in_menu(composite, hand, 0, "By hand")
    assert colors(hand) == before and layer(composite).channel_range(0) == "hand"
