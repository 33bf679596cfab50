"""The pictures of the gallery have the colours of the window's canvas."""

import pytest

from app.views import theme
from cpm_core.gallery import drawing


@pytest.mark.parametrize(
    ("drawn", "shown"),
    [("PARTICLE", "MOVING"), *((name, name) for name in ("CLOSED", "OPEN", "JUNCTION", "FIELD", "HALO"))],
)
def test_the_gallery_and_the_window_mean_the_same_by_a_colour(drawn, shown):
    assert getattr(drawing, drawn) == getattr(theme, shown)
