"""Neither a million letters nor twenty thousand corners keep the window waiting."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from app.model.document import edits
from app.model.parameters.presets import Preset, read, written
from app.model.text.language import MOST_SHOWN, shortened
from app.session.storage.autosave import KEY, folder_of_journals
from cpm_core.contours.contour import MOST_LETTERS
from cpm_core.contours.review import Mark
from cpm_core.image import regions
from cpm_core.image.regions import Regions
from cpm_core.objects.segmented.segmented_object import ObjectClass, SegmentedObject
from cpm_core.parameters import Parameters
from cpm_core.shapes import Barrier, Polygon, Region
from tests.app.session.test_never_blocks import Watch
from tests.app.session.test_recovery import offer

pytestmark = pytest.mark.shared_window

LONG = "a" * 1_000_000
CORNERS = 20_000
MOST_CALLS = 4 * CORNERS
"""Calls of Python in one gesture: few for each corner; the checks of the lines took 16 for each."""


def around(corners: int = CORNERS) -> tuple[tuple[float, float], ...]:
    angle = np.linspace(0.0, 2.0 * np.pi, corners, endpoint=False)
    radius = 26.0 + 2.0 * np.sin(40.0 * angle)
    return tuple(zip((32.0 + radius * np.sin(angle)).tolist(), (32.0 + radius * np.cos(angle)).tolist(), strict=True))


SQUARE = (((1.0, 1.0), (1.0, 9.0), (9.0, 9.0)),)


@pytest.mark.parametrize(
    "make",
    [
        lambda name: Mark((1.0, 1.0), name=name),
        lambda name: ObjectClass(name, "#ffffff"),
        lambda name: SegmentedObject(1, (), SQUARE, name=name),
    ],
)
def test_names_that_no_table_could_show_are_refused(make) -> None:
    make("a" * MOST_LETTERS)
    with pytest.raises(ValueError, match="1001 letters"):
        make("a" * (MOST_LETTERS + 1))


def test_a_description_of_a_preset_has_its_limit_too() -> None:
    with pytest.raises(ValueError, match="description is too long"):
        read(written(Preset("long", Parameters(), LONG)), "a.cpmpreset")


@pytest.mark.parametrize("length", [0, 1, MOST_SHOWN, MOST_SHOWN + 1, 10**6])
def test_a_shortened_text_has_its_beginning_and_its_end(length) -> None:
    text = "".join(chr(97 + number % 26) for number in range(length))
    short = shortened(text)
    assert len(short) <= MOST_SHOWN
    assert (short == text) == (length <= MOST_SHOWN)
    assert short[:100] == text[:100]
    assert short[-100:] == text[-100:]


HOSTILE = {
    "path": {"image": {"path": LONG}},
    "verdict": {"image": {"path": "a.png"}, "marks": [{"anchor": [1, 1], "verdict": LONG}]},
    "name": {"image": {"path": "a.png"}, "marks": [{"anchor": [1, 1], "name": LONG}]},
    "class": {"image": {"path": "a.png"}, "objects": {"classes": [{"name": LONG, "color": "#ffffff"}]}},
    "mode": {"image": {"path": "a.png"}, "mode": LONG},
    "view": {"image": {"path": "disc.npy"}, "view": {LONG: LONG, "layers": LONG}},
    "unknown": {"image": {"path": "disc.npy"}, LONG: LONG},
    "parameter": {"image": {"path": "disc.npy"}, "parameters": {LONG: 1}},
    "channel": {"image": {"path": "disc.npy"}, "parameters": {"channel": LONG}},
}


@pytest.mark.parametrize("content", HOSTILE.values(), ids=HOSTILE)
def test_a_session_with_a_million_letters_shows_only_few_of_them(ready, hand, tmp_path, content) -> None:
    path, opened = tmp_path / "long.cpm", ready.session.image_generation
    path.write_text(json.dumps({"cpm-session": 1, **content}))
    ready.session.open(path)
    shown = ready.canvas_area.messages
    hand.wait(lambda: bool(shown.text) or ready.session.image_generation > opened)
    assert len(shown.text) <= MOST_SHOWN


@pytest.mark.own_window
def test_the_question_about_unsaved_work_shows_few_of_a_million_letters(window) -> None:
    folder_of_journals().mkdir(parents=True)
    plain = {"cpm-session": 1, "image": {"path": LONG}, KEY: {"name": LONG, "session": LONG}}
    (folder_of_journals() / "a.cpm").write_text(json.dumps(plain))
    box = offer(window)
    assert len(box.text() + box.informativeText()) < 2000


@pytest.mark.parametrize("kind", [Barrier, Region, Polygon])
def test_a_gesture_on_a_line_of_many_corners_takes_few_calls(window, hand, kind) -> None:
    session, shape = window.session, kind(around())
    corner = shape.points[0]
    window.canvas_area.use_tool("select")
    gestures = {
        "drawing": lambda: session.edit("draw", lambda document: edits.add_shape(document, shape)),
        "pointing": lambda: hand.move(32.0, 32.0),
        "selecting": lambda: hand.press(*corner),
        "dragging": lambda: hand.move(corner[0] + 1.0, corner[1] + 1.0),
        "letting go": lambda: hand.release(corner[0] + 1.0, corner[1] + 1.0),
        "undoing": session.undo,
        "redoing": session.redo,
        "deleting": lambda: (session.select(0), session.delete_selected()),
    }
    for name, gesture in gestures.items():
        with Watch() as watch:
            gesture()
        assert watch.most <= MOST_CALLS, name
    assert session.document.shapes == ()


def test_a_document_is_asked_for_its_regions_without_making_them_again(window, hand, monkeypatch) -> None:
    made = []
    whole = Regions.__post_init__
    monkeypatch.setattr(Regions, "__post_init__", lambda self: (made.append(self), whole(self))[1])
    barrier = Barrier(around(300))
    window.session.edit("draw", lambda document: edits.add_shape(document, barrier))
    hand.wait(lambda: window.session.idle)
    assert len(made) == 1


def test_the_rim_of_a_region_of_many_corners_is_found_from_neighbors(monkeypatch) -> None:
    compared = []
    whole = regions.cut

    def counted(side, others, tolerance):
        compared.append(len(others))
        return whole(side, others, tolerance)

    monkeypatch.setattr(regions, "cut", counted)
    rim = Regions((around(2000),)).rims()
    assert len(rim) == 2000
    assert sum(compared) < 20 * 2000


def test_a_file_whose_name_is_too_long_is_refused_in_one_sentence(ready, hand, tmp_path) -> None:
    ready.session.open(Path(tmp_path / (LONG + ".png")))
    hand.wait(lambda: bool(ready.canvas_area.messages.text))
    assert len(ready.canvas_area.messages.text) <= MOST_SHOWN
