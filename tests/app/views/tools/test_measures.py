"""Rulers, angles and ellipses are drawn, held, undone, listed, exported and saved."""

from __future__ import annotations

import csv

import pytest
from cpm_app.model.display.lengths import format_measured
from cpm_app.model.document import edits
from cpm_app.model.document.edits import set_pixel_size
from cpm_app.views.features.files import OpenSaveFeature
from cpm_app.views.features.measures import MeasuresFeature
from PySide6.QtCore import Qt

from cpm_core.shapes import Angle, Oval, Ruler
from tests.app.exporting import export
from tests.app.reading import column_texts
from tests.app.views.tools.test_tools_drawn import drag_with

pytestmark = pytest.mark.shared_window

KEY, SHIFT, CONTROL = Qt.Key, Qt.KeyboardModifier.ShiftModifier, Qt.KeyboardModifier.ControlModifier
PIXEL = 0.5


def labels(window) -> list[str]:
    return [text for _, text, _ in window.canvas_area.canvas.layers["measures"].labels.texts]


def draw_all(hand) -> None:
    hand.key(KEY.Key_V)
    hand.drag((10, 10), (20, 20), (40, 50))
    hand.key(KEY.Key_V, SHIFT)
    hand.drag((10, 40), (20, 30), (30, 20))
    hand.click(30, 45)
    hand.key(KEY.Key_Z)
    hand.drag((20, 22), (30, 30), (44, 42))


def test_a_ruler_an_angle_and_an_ellipse_show_what_they_measure_and_are_undone_one_by_one(window, hand) -> None:
    window.session.edit("size", lambda document: set_pixel_size(document, (0.5, 0.5), "mm"))
    draw_all(hand)
    ruler, angle, oval = window.session.document.shapes
    assert ruler.points == (pytest.approx((10, 10), abs=PIXEL), pytest.approx((40, 50), abs=PIXEL))
    assert isinstance(angle, Angle) and isinstance(oval, Oval)
    assert oval.center == pytest.approx((32, 32), abs=PIXEL) and oval.radii == pytest.approx((12, 10), abs=PIXEL)
    texts = labels(window)
    assert float(texts[0].removesuffix(" mm")) == pytest.approx(25.0, abs=0.6)
    assert float(texts[1].removesuffix("°")) == pytest.approx(45.0, abs=3.0)
    assert texts[2].startswith("200 ± 0, ") and texts[2].endswith(" mm²")
    for left in (2, 1, 0):
        hand.key(KEY.Key_Z, CONTROL)
        assert len(window.session.document.shapes) == left
    hand.key(KEY.Key_Z, CONTROL | SHIFT)
    assert window.session.document.shapes == (ruler,)


def test_the_table_of_measures_comes_to_the_front_with_the_first_and_with_the_tool(window, hand) -> None:
    docks = window.docks
    docks.reveal_panel("objects")
    hand.key(KEY.Key_V)
    assert docks.is_in_front("objects")  # there is nothing to list
    hand.drag((20, 22), (30, 30), (44, 42))
    assert docks.is_in_front("measures")
    hand.key(KEY.Key_C)
    assert docks.is_in_front("run")
    hand.key(KEY.Key_V)
    assert docks.is_in_front("measures")
    hand.key(KEY.Key_S)
    assert docks.is_in_front("measures")


def test_a_narrow_table_shows_what_there_is_before_what_no_measure_has(window, hand) -> None:
    hand.key(KEY.Key_Z)
    hand.drag((20, 22), (30, 30), (44, 42))
    window.docks.reveal_panel("measures")
    table = window.get_feature(MeasuresFeature).table
    hand.wait(lambda: bool(table.rows.items))

    def shown(width):
        table.resize(width, 200)
        return [one.name for at, one in enumerate(table.rows.columns) if not table.isColumnHidden(at)]

    names = [one.name for one in table.rows.columns]
    assert shown(2000) == names
    width = next(width for width in range(2000, 0, -10) if len(shown(width)) == 5)
    assert shown(width) == ["name", "mean", "deviation", "area", "pixels"]


def test_handles_and_bodies_of_measures_are_dragged(window, hand) -> None:
    draw_all(hand)
    hand.key(KEY.Key_S)
    hand.drag((44, 32), (46, 32), (50, 32))
    _, _, oval = window.session.document.shapes
    assert oval.radii == pytest.approx((18, 10), abs=2 * PIXEL)
    hand.click(12, 13)
    hand.drag((10, 10), (8, 10), (5, 10))
    ruler, *_ = window.session.document.shapes
    assert ruler.points[0] == pytest.approx((5, 10), abs=2 * PIXEL)
    assert ruler.points[1] == pytest.approx((40, 50), abs=PIXEL)
    hand.key(KEY.Key_Delete)
    assert not any(isinstance(shape, Ruler) for shape in window.session.document.shapes)


def test_a_measure_is_no_start_and_changes_no_run(ready, hand) -> None:
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: ready.session.idle)
    found = ready.session.scene.contours
    draw_all(hand)
    assert not ready.session.status.stale and ready.session.scene.contours is found
    assert len(ready.session.document.starts) == 1


def test_shift_makes_the_ellipse_round_and_escape_forgets_the_angle(window, hand) -> None:
    hand.key(KEY.Key_V, SHIFT)
    hand.click(10, 10)
    hand.click(20, 20)
    hand.key(KEY.Key_Escape)
    hand.click(30, 30)
    assert window.session.document.shapes == ()
    hand.key(KEY.Key_Escape)
    hand.key(KEY.Key_Z)
    drag_with(hand, SHIFT, (20, 20), (40, 30))
    (oval,) = window.session.document.shapes
    assert oval.radii == pytest.approx((10, 10), abs=PIXEL)


def test_the_table_lists_and_selects_measures_and_is_there_while_there_are_any(window, hand) -> None:
    tabs, table = window.docks.tabs, window.get_feature(MeasuresFeature).table
    assert not tabs.isTabVisible(tabs.indexOf(table))
    draw_all(hand)
    assert tabs.isTabVisible(tabs.indexOf(table))
    window.docks.reveal_panel("measures")
    hand.wait(lambda: column_texts(table, "name") == ["ruler", "angle", "measuring ellipse"])
    assert float(column_texts(table, "length")[0]) == pytest.approx(50.0, abs=1.0)
    assert table.rows.headerData(table.column_index("length"), Qt.Orientation.Horizontal) == "Length [px]"
    assert column_texts(table, "mean") == ["–", "–", "200.0"]
    place = table.visualRect(table.rows.index(1, 0)).center()
    hand.qtbot.mouseClick(table.viewport(), Qt.MouseButton.LeftButton, pos=place)
    assert window.session.selected_shape == 1
    hand.qtbot.keyClick(table, KEY.Key_Delete)
    hand.wait(lambda: column_texts(table, "name") == ["ruler", "measuring ellipse"])
    for key in (KEY.Key_S, KEY.Key_V):
        hand.canvas.setFocus()
        hand.key(key)
        assert tabs.currentWidget() is table


@pytest.mark.parametrize(
    ("value", "text"), [(64.0813, "64.08"), (999.96, "1000"), (31415.9, "31,416"), (-1023.6, "-1,024")]
)
def test_large_measures_have_no_exponent(value, text) -> None:
    assert format_measured(value) == text


def test_measures_are_exported_with_units_and_kept_in_the_session(window, hand, tmp_path) -> None:
    window.session.edit("size", lambda document: set_pixel_size(document, (0.5, 0.5), "µm"))
    draw_all(hand)
    drawn = window.session.document.shapes
    (path,) = export(hand.qtbot, window, tmp_path, "measures:.csv")
    assert path.name == "disc_measures.csv"
    ruler, angle, oval = csv.DictReader(path.read_text("utf-8").splitlines())
    assert float(ruler["length_um"]) == pytest.approx(25.0, abs=0.6)
    assert (ruler["angle_deg"], angle["measure"], oval["mean_gray"]) == ("", "angle", "200")
    saved = tmp_path / "kept.cpm"
    window.get_feature(OpenSaveFeature).document_file.save_and_wait(saved)
    window.session.edit("clear", edits.clear_shapes)
    window.open_image(str(saved))
    hand.wait(lambda: window.session.document.shapes == drawn)
