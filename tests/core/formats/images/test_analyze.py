"""Analyze 7.5 and pairs of NIfTI: values and sizes as nibabel has them, by either of the two files."""

import nibabel
import numpy as np
import pytest

from cpm_core import load_image, load_volume

from .made import VALUES

KINDS = [nibabel.AnalyzeImage, nibabel.Spm99AnalyzeImage, nibabel.Spm2AnalyzeImage]
PAIRS = [*KINDS, nibabel.Nifti1Pair, nibabel.Nifti2Pair]


def write(path, kind=nibabel.AnalyzeImage, values=VALUES, unit=b"", order="<"):
    header = kind.header_class(endianness=order) if kind in KINDS else None
    image = kind(values.T, np.diag([0.5, 0.75, 2.0, 1.0]), header)
    if kind in KINDS:
        image.header["vox_units"] = unit
    image.to_filename(path)
    return image


@pytest.mark.parametrize("ending", [".hdr", ".img"])
@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("kind", PAIRS)
def test_either_file_of_a_pair_is_the_volume(tmp_path, kind, order, ending):
    write(tmp_path / "a.hdr", kind, order=order)
    volume = load_volume(tmp_path / f"a{ending}")
    assert np.array_equal(volume.values, np.asarray(nibabel.load(tmp_path / "a.hdr").dataobj).T)
    assert np.array_equal(volume.values, VALUES)
    assert (volume.spacing, volume.unit) == (pytest.approx((2.0, 0.75, 0.5)), "mm")
    assert np.array_equal(load_image(tmp_path / f"a{ending}", page=3).values, VALUES[2])


@pytest.mark.parametrize(("unit", "kept"), [(b"um", "µm"), (b"cm", "cm"), (b"mm", "mm"), (b"vox", None)])
def test_analyze_states_the_unit_but_no_place(tmp_path, unit, kept):
    write(tmp_path / "a.hdr", unit=unit)
    volume = load_volume(tmp_path / "a.hdr")
    assert (volume.unit, volume.geometry) == (kept, None)
    assert volume.spacing == pytest.approx((2.0, 0.75, 0.5) if kept else (4.0, 1.5, 1.0))
    assert volume.notes == ("Its format, Analyze 7.5, does not say where it lies, nor which side is left.",)


def test_times_of_analyze_are_read_one_by_one(tmp_path):
    write(tmp_path / "a.hdr", values=np.stack([VALUES, VALUES + 7]))
    assert np.array_equal(load_volume(tmp_path / "a.hdr", time=2).values, VALUES + 7)


@pytest.mark.parametrize("kind", PAIRS)
def test_a_header_whose_values_are_missing_is_not_called_damaged(tmp_path, kind):
    write(tmp_path / "a.hdr", kind)
    (tmp_path / "a.img").unlink()
    with pytest.raises(ValueError, match=r'keeps its values in "a\.img", which is not a single file next to it'):
        load_volume(tmp_path / "a.hdr")


def test_values_without_a_header_of_their_format_are_not_taken_for_a_pair(tmp_path):
    write(tmp_path / "a.hdr")
    (tmp_path / "a.hdr").write_text("ENVI\nsamples = 10\n" + 400 * " ")
    with pytest.raises(ValueError, match=r"a\.img is"):
        load_volume(tmp_path / "a.img")
