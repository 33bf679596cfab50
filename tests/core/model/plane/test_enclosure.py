"""Once one boundary of an enclosed region has been found, its other boundaries are found too."""

import numpy as np
import pytest

from cpm_core.field.scale_field import build_scale_field
from cpm_core.image.regions import Regions
from cpm_core.model.plane.enclosed_regions import reseeding_places
from cpm_core.model.starts import circle
from cpm_core.parameters import Parameters
from cpm_core.segmentation.evolve import segment

ROW, COL = np.indices((120, 140))


def ring(hole_at=(60.0, 60.0)):
    image = 200.0 * np.clip(50.5 - np.hypot(ROW - 60.0, COL - 66.0), 0.0, 1.0)
    return image * np.clip(np.hypot(ROW - hole_at[0], COL - hole_at[1]) - 13.5, 0.0, 1.0)


def rim(center, radius):
    return circle(center, radius)


@pytest.mark.parametrize("known", ["hole", "outline"])
def test_a_boundary_that_no_particle_reached_is_reseeded(known):
    scale_field = build_scale_field(ring(), 1.0, 0.0)
    hole, outline = rim((60.0, 60.0), 13.5), rim((60.0, 66.0), 50.0)
    places = reseeding_places(scale_field, hole if known == "hole" else outline)
    center, radius = ((60.0, 66.0), 50.0) if known == "hole" else ((60.0, 60.0), 13.5)
    assert len(places) > 3
    assert np.abs(np.hypot(*(places - center).T) - radius).max() < 4.0
    assert len(reseeding_places(scale_field, np.concatenate([hole, outline]))) == 0


@pytest.mark.parametrize("gap", [3.0, 5.0, 8.0])
def test_a_hole_close_to_the_outline_is_reseeded_although_particles_are_near(gap):
    """Their rims may coincide; the side of the edge on which a particle lies distinguishes them."""
    center, radius = (60.0, 66.0 + 50.0 - gap - 6.0), 6.0
    image = 200.0 * np.clip(50.5 - np.hypot(ROW - 60.0, COL - 66.0), 0.0, 1.0)
    image *= np.clip(np.hypot(ROW - center[0], COL - center[1]) - radius + 0.5, 0.0, 1.0)
    places = reseeding_places(build_scale_field(image, 1.0, 0.0), rim((60.0, 66.0), 50.0))
    assert len(places) >= 2
    assert np.abs(np.hypot(*(places - center).T) - radius).max() < 4.5
    result = segment(image, circle((60.0, 30.0), 6.0), Parameters())
    np.testing.assert_allclose(sorted(c.area for c in result.contours), [np.pi * radius**2, np.pi * 50.0**2], rtol=0.1)
    assert all(c.closed for c in result.contours)


@pytest.mark.parametrize("start", [(60.0, 60.0, 18.0), (60.0, 95.0, 6.0), (20.0, 66.0, 5.0), (60.0, 60.0, 5.0)])
def test_a_start_on_any_side_finds_ring_and_hole(start):
    row, col, radius = start
    result = segment(ring(), circle((row, col), radius), Parameters())
    np.testing.assert_allclose(sorted(c.area for c in result.contours), [np.pi * 14.0**2, np.pi * 50.0**2], rtol=0.01)
    assert all(c.closed for c in result.contours)
    assert result.converged


def test_there_is_no_reseeding_across_a_barrier():
    """A barrier between the hole and the outline, closed but not around either of them alone."""
    around = [(60.0 + 30.0 * np.sin(a), 66.0 + 30.0 * np.cos(a)) for a in np.linspace(0.0, 2.0 * np.pi, 41)]
    regions = Regions(barriers=(tuple(around),))
    contours = segment(ring(), circle((60.0, 60.0), 5.0), Parameters(), regions=regions).contours
    assert [c.area for c in contours] == [pytest.approx(np.pi * 14.0**2, rel=0.01)]
    inside = segment(ring(), circle((60.0, 60.0), 5.0), Parameters(), regions=Regions(interest=(tuple(around[:-1]),)))
    assert len(inside.contours) == 1
