"""Arrows of the field are as dense as the zoom allows and the potential is shown on request."""

from __future__ import annotations

import numpy as np
import pytest
from cpm_app.model.display.display_image import shade_potential

from cpm_core.segmentation.engine import Engine
from tests.app.reading import arrow_ends

pytestmark = pytest.mark.shared_window

SIDE = 120
ROW, COL = np.indices((SIDE, SIDE)) - (SIDE - 1) / 2


def test_where_the_potential_is_higher_it_is_shown_no_darker():
    potential = ROW + 0.3 * COL
    shown = shade_potential(potential).ravel()[np.argsort(potential, axis=None)]
    assert (np.diff(shown.astype(int)) >= 0).all()
    assert (shown[0], shown[-1]) == (0, 255)


def test_potential_and_field_are_shown_on_request(ready, hand):
    session, layers = ready.session, hand.canvas.layers
    potential, field = layers["potential"], layers["field"]
    ready.actions_by_name["layer_potential"].trigger()
    hand.wait(lambda: potential.shades is not None)
    parameters = session.document.parameters
    engine = Engine(session.image, parameters)
    assert np.array_equal(potential.shades, shade_potential(engine.potential(parameters)))
    ready.actions_by_name["layer_field"].trigger()
    hand.wait(lambda: len(arrow_ends(field)) > 0)
    arrows = arrow_ends(field)
    hand.canvas.zoom_by(3.0)
    assert not np.array_equal(arrow_ends(field), arrows)
    seen = hand.canvas.view.viewRect()
    assert ((arrow_ends(field)[:, 1] > seen.left() - 1) & (arrow_ends(field)[:, 1] < seen.right() + 1)).all()
    ready.actions_by_name["layer_potential"].trigger()
    assert potential.shades is None
