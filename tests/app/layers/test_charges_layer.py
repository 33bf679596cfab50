"""Placed charges on the canvas."""

from __future__ import annotations

import pyqtgraph as pg
import pytest

from app.views.canvas.layers.drawing import Charges
from cpm_core.shapes import Charge

pytestmark = pytest.mark.usefixtures("qapp")


def test_charges_that_are_drawn_again_and_again_leave_no_pictures_behind() -> None:
    view = pg.ViewBox()
    layer = Charges(view)
    for shown in range(20):
        charges = [Charge((5.0 + shown, 9.0), strength) for strength in (2.0, -2.0)]
        layer.show(charges, charges[shown % 2])
    assert len(layer._discs.data) == 2
    assert len(layer._discs.fragmentAtlas) == 4  # two charges, each chosen or not
