"""Measures are drawn in each slice, and seen there and in space."""

from __future__ import annotations

import pytest
from cpm_app.model.volume.shape_sections import build_shape_wires
from cpm_app.views.features.files import OpenSaveFeature
from cpm_app.views.features.measures import MeasuresFeature
from cpm_app.views.features.volumes import SlicesFeature
from PySide6.QtCore import Qt

from cpm_core.formats import load_session
from tests.app.reading import column_texts
from tests.app.views.volume.conftest import drag

pytestmark = pytest.mark.shared_window

KEY, PIXEL = Qt.Key, 0.5


@pytest.mark.parametrize("index", [0, 1, 2])
def test_measures_lie_in_the_slices_of_volumes_and_are_seen_in_space(volume, hand, index, tmp_path) -> None:
    view = (volume.canvas_area.canvas, *volume.get_feature(SlicesFeature).sides)[index]
    hand.key(KEY.Key_Z)
    drag(view, (9, 10), (12, 14), (15, 20))
    hand.key(KEY.Key_V)
    drag(view, (4, 5), (8, 9), (16, 21))
    oval, ruler = volume.session.document.shapes
    here = view.shown_slice
    assert (oval.axis, oval.center[here.axis]) == (here.axis, here.index)
    assert here.drop_axis(oval.center) == pytest.approx((12, 15), abs=2 * PIXEL)
    assert len(build_shape_wires(oval, (1, 1, 1))) > 20 and len(build_shape_wires(ruler, (1, 1, 1))) == 1
    texts = view.layers.measures.labels.texts
    assert len(texts) == 2 and float(texts[1][1].split()[0]) == pytest.approx(20.0, abs=1.5)
    values = volume.session.image.values.take(here.index, axis=here.axis)
    assert float(texts[0][1].split(" ±")[0]) <= values.max()
    hand.key(KEY.Key_S)
    drag(view, (16, 21), (16, 20), (16, 15))
    assert here.drop_axis(volume.session.document.shapes[1].points[1]) == pytest.approx((16, 15), abs=2 * PIXEL)
    volume.workspace.slices.step_along(here.axis, 2)
    assert view.layers.measures.labels.texts == []
    volume.docks.reveal_panel("measures")
    table = volume.get_feature(MeasuresFeature).table
    hand.wait(lambda: column_texts(table, "name") == ["measuring ellipse", "ruler"])
    hand.qtbot.mouseClick(
        table.viewport(), Qt.MouseButton.LeftButton, pos=table.visualRect(table.rows.index(1, 0)).center()
    )
    assert volume.session.selected_shape == 1 and len(view.layers.measures.labels.texts) == 2
    drawn = volume.session.document.shapes
    volume.get_feature(OpenSaveFeature).document_file.save_and_wait(tmp_path / "kept.cpm")
    assert load_session(tmp_path / "kept.cpm").shapes == drawn
