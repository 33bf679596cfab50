"""A server whose address stands in the preferences answers clicks in a volume; without one nothing is sent."""

from __future__ import annotations

import pytest
from cpm_app.model.preferences.table import SERVER_ADDRESS
from cpm_app.views.features.help import PreferencesFeature
from PySide6.QtCore import Qt

from tests.app.views.volume.test_objects_in_volumes import click, take

KEY = Qt.Key

server = pytest.importorskip("tests.core.objects.test_server").server


def test_the_server_of_the_preferences_answers_clicks(volume, hand, server) -> None:
    dialog = volume.get_feature(PreferencesFeature).open_preferences()
    dialog.turn_to("objects")
    field = dialog.rows[SERVER_ADDRESS.label]
    field.setFocus()
    hand.qtbot.keyClicks(field, server.address)
    hand.qtbot.keyClick(field, KEY.Key_Return)
    dialog.reject()
    updater = volume.workspace.object_selection.partition_updater
    hand.wait(lambda: updater._models[3] == server.address)
    volume.activateWindow()
    hand.wait(volume.isActiveWindow)
    hand.canvas.setFocus()
    hand.key(KEY.Key_W)
    hand.wait(lambda: volume.workspace.object_selection.ready)
    assert server.asked == []
    click(hand, (14, 16))
    take(hand)
    (item,) = volume.session.document.objects.items
    assert item.model == server.address.removeprefix("http://")
    updater.set_model("", 3)
