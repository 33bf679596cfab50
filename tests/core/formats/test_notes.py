"""Notes on what a reader left out or assumed reach everyone who reads, whatever is read from the file."""

import numpy as np
import pytest
import tifffile

import cpm_core as cpm

NOTE = "Only the first of its 2 channels was taken."
SHAPE = (8, 20, 22)


@pytest.fixture
def labels(tmp_path):
    """A function that writes labels in two channels, in a plane or a volume."""

    def write(axes):
        values = np.zeros(SHAPE, np.uint8)
        values[2:6, 5:12, 6:13] = 1
        part = values if axes == 3 else values[4]
        stored = np.stack([part, 0 * part], axis=axes - 2)
        tifffile.imwrite(
            tmp_path / "labels.tif", stored, photometric="minisblack", metadata={"axes": "ZCYX"[-stored.ndim :]}
        )
        return tmp_path / "labels.tif"

    return write


@pytest.mark.parametrize("axes", [2, 3])
def test_all_that_reads_a_file_tells_what_was_left_out(labels, axes):
    file, told, volume = labels(axes), [], cpm.Image(np.zeros(SHAPE))
    if axes == 2:
        cpm.load_contours(file, warn=told.append)
        values = cpm.load_image(file), cpm.load_truth(file, SHAPE[1:])
    else:
        cpm.load_surface(file, warn=told.append)
        cpm.load_surface(file, volume, warn=told.append)
        values = cpm.load_volume(file), cpm.load_volume_truth(file, volume)
    assert all(NOTE in one.notes for one in values)
    assert set(told) == {f"labels.tif: {NOTE}"}
