"""Limits of what is drawn are checked before memory or time is taken for it."""

import json
import tracemalloc

import numpy as np
import pytest

import cpm_core as cpm
from cpm_core.formats.common.json_values import shape_from_json, to_json
from cpm_core.formats.sessions.session_file import SessionFile, load_session, save_session
from cpm_core.image.region import Region
from cpm_core.model.starts import check_seeds
from cpm_core.numerics.packed_mask import PackedMask
from cpm_core.shapes import EnclosedRegion, EnclosingWall, Grid

SQUARE = ((0.0, 0.0), (0.0, 100.0), (100.0, 100.0), (100.0, 0.0))


@pytest.mark.parametrize("scale", [1.0, 1e2, 9e3])
def test_a_grid_of_too_many_particles_is_refused_before_they_are_made(tmp_path, scale):
    corners = [[row * scale, col * scale] for row, col in SQUARE]
    save_session(SessionFile(shapes=(Grid(SQUARE, 4.0),)), tmp_path / "a.cpm")
    content = json.loads((tmp_path / "a.cpm").read_text())
    content["shapes"][0] |= {"points": corners, "spacing": 0.01 * scale}
    (tmp_path / "a.cpm").write_text(json.dumps(content))
    tracemalloc.start()
    with pytest.raises(ValueError, match=r"spacing|far|coordinate"):
        load_session(tmp_path / "a.cpm")
    assert tracemalloc.get_traced_memory()[1] < 20e6
    tracemalloc.stop()


def test_starts_that_crowd_a_pixel_are_thinned_and_others_are_not():
    spread = cpm.uniform_grid((40, 40), 1.0)
    assert check_seeds(spread, (40, 40), None) is not None
    assert np.array_equal(check_seeds(spread, (40, 40), None), spread)
    crowd = np.random.default_rng(0).uniform(10.0, 14.0, (40_000, 2))
    found = check_seeds(np.concatenate([spread, crowd]), (40, 40), None)
    assert len(found) <= len(spread) + 16 * 25
    assert np.array_equal(found[: len(spread)], spread)
    assert np.bincount((np.rint(found) @ [40, 1]).astype(int)).max() <= 16


@pytest.mark.parametrize("kind", [EnclosedRegion, EnclosingWall])
@pytest.mark.parametrize(
    "region", [Region(), Region((SQUARE,)), Region(pixels=PackedMask.pack(np.zeros((2, 2, 2), bool)))]
)
def test_a_limit_of_a_volume_without_voxels_is_refused_when_its_session_is_read(kind, region):
    plain = {"shape": kind.__name__.lower(), "region": json.loads(json.dumps(to_json(region)))}
    with pytest.raises(ValueError, match="in a volume needs at least one voxel"):
        shape_from_json(plain, "a shape")
