"""Everything that is written is read back: each suffix has its reader, and the tests beside it hold how exactly."""

from dataclasses import replace

import numpy as np
import pytest

from cpm_core import (
    centerlines,
    export,
    load_centerlines,
    load_contours,
    load_points,
    load_surface,
    load_volume,
)
from cpm_core.formats import FOR_CENTERLINES, FOR_SKELETONS, FOR_VOLUMES, SURFACES_READABLE, WRITABLE
from cpm_core.formats.writers import DRAWN

from .drawn import RESULT
from .meshes.test_meshes import RESULT as VOLUME

TABLES = {".measures.csv"} | DRAWN
"""Files that tell of contours or show them, and hold none."""


@pytest.mark.parametrize("suffix", [*WRITABLE, *FOR_VOLUMES, *FOR_CENTERLINES])
def test_there_is_a_reader_for_every_file_of_lines_surfaces_or_points(suffix, tmp_path):
    file = tmp_path / f"a{suffix}"
    if suffix in FOR_CENTERLINES:
        inside = np.zeros((12, 12, 40), bool)
        inside[4:9, 4:9, 4:36] = True
        export(centerlines(inside), file)
        assert load_centerlines(file, warn=lambda _: None).branches
        return
    if suffix in FOR_VOLUMES:
        particles = np.array([(1.0, 2.0, 3.25)])
        export(replace(VOLUME, particles=particles), file)
        if suffix in SURFACES_READABLE:
            assert load_surface(file).closed
        elif suffix == ".points.csv":
            assert load_points(file, 3).tolist() == particles.tolist()
        else:
            assert load_surface(file).closed and load_volume(file).shape == VOLUME.shape
    if suffix in WRITABLE.keys() - TABLES:
        one = replace(RESULT, contours=RESULT.contours[:1]) if suffix == ".roi" else RESULT
        export(one, file, warn=lambda _: None)
        assert load_contours(file)
    assert suffix in WRITABLE or suffix in FOR_VOLUMES


def test_what_skeletons_are_written_as_is_written_of_contours_too():
    assert set(FOR_SKELETONS) <= set(WRITABLE)
