"""Edge contact, against the rule evaluated on fields that SciPy interpolates."""

import pytest

from cpm_core.field.scale_field import ON_EDGE_FORCE
from cpm_core.model.plane.motion import is_on_edge

FLOOR = 2.0


@pytest.mark.parametrize(
    ("force", "strength", "there"),
    [
        (0.0, FLOOR, True),
        (0.99 * ON_EDGE_FORCE, FLOOR, True),
        (ON_EDGE_FORCE, FLOOR, False),
        (0.0, 0.99 * FLOOR, False),
    ],
)
def test_a_particle_is_on_an_edge_below_the_gate_where_the_edge_is_strong_enough(force, strength, there):
    assert is_on_edge(force**2, strength, FLOOR) == there
