"""What is clicked in a notebook is what is selected in Python, by the messages that its page sends."""

import importlib
import io

import numpy as np
import PIL.Image
import pytest

import cpm_core as cpm

MODULE = importlib.import_module("cpm_core.notebook.view")


def sent(view, name, *given):
    """The view as the page of a notebook has it, after it has sent a message."""
    widget = view._widget
    widget._handle_msg(
        {"content": {"data": {"method": "custom", "content": {"do": name, "given": given}}}, "buffers": []}
    )
    return widget.get_state()


def test_clicks_choose_select_correct_and_remove():
    pytest.importorskip("anywidget")
    view = cpm.notebook_view(cpm.example("disks"))
    chosen = sent(view, "click", [32, 18], False)["chosen"]
    assert [selected for selected, _ in chosen["objects"]] == [True]
    assert f"{view.selection.mask.sum()} px" in chosen["said"]
    sent(view, "click", [32, 46], False)
    assert [bool(one.mask[32, 18]) for one in view.objects] == [True, False]
    sent(view, "click", [32, 18], False)  # it is known, and selected again
    assert len(view.objects) == 2
    assert view.selection.mask[32, 18]
    sent(view, "click", [32, 25], True)
    assert view.selection.mask[32, 18]
    assert not view.selection.mask[32, 25]
    sent(view, "click", [32, 25], True)
    assert view.selection.mask[32, 25]
    assert [selected for selected, _ in sent(view, "remove")["chosen"]["objects"]] == [False]
    assert view.selection is None
    view.click((32, 18))  # what is done in Python is seen as well
    assert len(view._widget.chosen["objects"]) == 2


def test_the_image_is_sent_with_its_contours_once_and_small(monkeypatch):
    pytest.importorskip("anywidget")
    result = cpm.segment(cpm.example("disks"), cpm.uniform_grid((64, 64)))
    monkeypatch.setattr(MODULE, "_MAX_PICTURE_SIDE", 32)
    view = cpm.notebook_view(result)
    ground = view._widget.ground
    assert PIL.Image.open(io.BytesIO(ground["picture"])).size == (32, 32)
    assert (ground["shape"], ground["aspect"], ground["planes"]) == ((64, 64), 1.0, 0)
    assert [path.endswith("Z") for _, path in ground["lines"]] == [contour.closed for contour in result.contours]
    first = [float(number) for number in ground["lines"][0][1][1:].partition("L")[0].split(",")]
    np.testing.assert_allclose(first[::-1], result.contours[0].points[0], atol=0.01)
    sent(view, "click", [32, 18], False)
    assert view._widget.ground is ground


def test_a_volume_is_clicked_in_its_planes():
    pytest.importorskip("anywidget")
    ball = cpm.segment(cpm.example("ball"), cpm.sphere((15, 15, 15), 4, 60), cpm.PRESETS["volume"])
    view = cpm.notebook_view(ball)
    state = sent(view, "turn_to", 10)
    (_, line), (_, body) = (
        state["ground"]["lines"][0],
        sent(view, "click", [10, 15, 15], False)["chosen"]["objects"][0],
    )
    assert state["ground"]["plane"] == 10
    points = [tuple(map(float, pair.split(","))) for pair in line.strip("MZ").split("L")]
    np.testing.assert_allclose(np.hypot(*(np.array(points).T - 15.0)), np.sqrt(9.0**2 - 5.0**2), atol=0.3)
    assert body
    assert view.selection.size == pytest.approx(ball.surface.volume)
    assert sent(view, "turn_to", 2)["chosen"]["objects"] == [(True, "")]
    cpm.notebook_view(ball.image).click((15, 15, 15))


def test_a_notebook_without_the_library_shows_the_picture(monkeypatch):
    view = cpm.notebook_view(cpm.example("disks"))
    view.click((32, 18))
    pixels = np.asarray(PIL.Image.open(io.BytesIO(view._repr_png_())).convert("RGB")).reshape(-1, 3)
    assert (np.abs(pixels - np.array([0xF5, 0x79, 0x3A])).max(axis=1) < 8).any()
    monkeypatch.setattr(MODULE, "has_package", lambda name: None)
    assert view._repr_mimebundle_() == {}


def test_a_result_that_does_not_know_its_image_is_given_one():
    image = cpm.example("disks")
    found = cpm.segment(image, cpm.uniform_grid((64, 64)))
    stranger = cpm.Result(found.particles, found.contours, None, 0, True, "", (64, 64), (1.0, 1.0), None, "a")
    with pytest.raises(ValueError, match="the result has no image"):
        cpm.notebook_view(stranger)
    assert cpm.notebook_view(image.values, stranger).partition.contours == found.contours
