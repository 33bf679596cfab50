"""Label masks that know the size of a pixel: TIFF for ImageJ, NIfTI for radiology."""

import io
import json
from dataclasses import replace

import nibabel
import numpy as np
import PIL.Image
import pytest
import tifffile

from cpm_core.contours.rasterize import rasterize_labels
from cpm_core.formats import export, load_image, to_bytes

from ..drawn import FIBRE, RESULT

MASK = rasterize_labels(RESULT.contours, RESULT.shape)


@pytest.mark.parametrize("suffix", [".tif", ".tiff"])
def test_the_tiff_holds_the_label_mask_in_sixteen_bits(suffix):
    with PIL.Image.open(io.BytesIO(to_bytes(RESULT, suffix))) as image:
        assert image.mode == "I;16"
        assert np.array_equal(np.asarray(image), MASK)
    assert MASK.max() == 3


def test_imagej_and_we_find_the_size_of_a_pixel_in_the_tiff(tmp_path):
    export(RESULT, tmp_path / "a.tif")
    with tifffile.TiffFile(tmp_path / "a.tif") as file:
        assert file.is_imagej
        assert file.imagej_metadata["unit"] == "um"
        assert file.pages[0].tags["XResolution"].value == (4, 1)
        assert file.pages[0].tags["YResolution"].value == (2, 1)
    image = load_image(tmp_path / "a.tif")
    assert (image.spacing, image.unit) == ((0.5, 0.25), "µm")


def test_more_labels_than_sixteen_bits_hold_make_thirty_two(tmp_path):
    last = replace(RESULT, contours=(replace(FIBRE, number=70_000),))
    export(last, tmp_path / "a.tif", tmp_path / "a.nii", outlines=True)
    with tifffile.TiffFile(tmp_path / "a.tif") as file:
        assert file.pages[0].dtype == np.uint32
        assert file.asarray().max() == 70_000
        assert json.loads(file.pages[0].description)["image"] == {"name": RESULT.source}
    image = load_image(tmp_path / "a.tif")
    assert image.spacing == pytest.approx((0.5, 0.25))
    volume = nibabel.load(tmp_path / "a.nii")
    assert volume.get_data_dtype() == np.uint32
    assert np.asarray(volume.dataobj).max() == 70_000


def volume_of(result):
    return nibabel.Nifti1Image.from_bytes(to_bytes(result, ".nii"))


def test_the_nifti_is_the_label_mask_with_columns_first():
    volume = volume_of(RESULT)
    assert (volume.shape, volume.get_data_dtype()) == ((90, 60, 1), np.uint16)
    assert np.array_equal(np.asarray(volume.dataobj)[:, :, 0].T, MASK)


@pytest.mark.parametrize(
    ("unit", "spacing", "named", "sizes"),
    [
        ("µm", (0.5, 0.25), "micron", (0.25, 0.5)),
        ("mm", (0.5, 0.25), "mm", (0.25, 0.5)),
        ("nm", (500.0, 250.0), "micron", (0.25, 0.5)),
        ("cm", (0.5, 0.25), "mm", (2.5, 5.0)),
        ("m", (0.5, 0.25), "meter", (0.25, 0.5)),
        (None, (1.0, 1.0), "unknown", (1.0, 1.0)),
    ],
)
def test_the_nifti_knows_the_size_of_a_pixel_and_lies_as_a_picture_does(unit, spacing, named, sizes):
    volume = volume_of(replace(RESULT, unit=unit, spacing=spacing))
    assert volume.header.get_xyzt_units()[0] == named
    assert volume.header.get_zooms() == pytest.approx((*sizes, 1.0))
    width, height = sizes
    lies = np.diag([-width, -height, 1.0, 1.0])  # columns to the left, rows to the back, no shift
    np.testing.assert_allclose(volume.affine, lies)
    for form in (volume.get_sform(coded=True), volume.get_qform(coded=True)):
        np.testing.assert_allclose(form[0], lies, atol=1e-6)
        assert form[1] > 0
