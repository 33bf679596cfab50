"""NIfTI: values, sizes and place as nibabel gives them, and label volumes that lie on their input."""

import nibabel
import nrrd
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cpm_core import Result, Surface, export, load_image, load_volume, load_volume_truth
from cpm_core.formats.surface_file import load_surface
from cpm_core.numerics.grids import zero_surface

from .made import VALUES, affine, write_nifti


@pytest.mark.parametrize("kind", [nibabel.Nifti1Image, nibabel.Nifti2Image])
@pytest.mark.parametrize("name", ["a.nii", "a.nii.gz"])
def test_values_sizes_and_place_are_those_of_nibabel(tmp_path, kind, name):
    write_nifti(tmp_path / name, kind=kind, xyzt_units=2)
    volume, known = load_volume(tmp_path / name), nibabel.load(tmp_path / name)
    assert np.array_equal(volume.values, np.asarray(known.dataobj).T)
    assert volume.spacing == pytest.approx(known.header.get_zooms()[::-1])
    np.testing.assert_allclose(volume.geometry.affine(volume.spacing)[:, [2, 1, 0, 3]], known.affine, atol=1e-12)
    assert (volume.unit, volume.geometry.convention, volume.notes) == ("mm", "RAS", ())
    assert len(volume.file_sha256) == 64


@pytest.mark.parametrize("form", ["sform", "qform", "neither"])
def test_a_label_volume_has_the_affine_of_the_file_that_was_read(tmp_path, form):
    image = nibabel.Nifti1Image(np.zeros(VALUES.T.shape, np.int16), affine())
    image.set_sform(affine(), 1 if form == "sform" else 0)
    image.set_qform(affine(), 1 if form == "qform" else 0)
    ball = 4.0 - np.linalg.norm(np.indices(VALUES.shape).T - (4, 6, 7), axis=-1).T
    image = nibabel.Nifti1Image((100 * ball).T.astype(np.int16), None, image.header)
    nibabel.save(image, tmp_path / "a.nii.gz")
    volume = load_volume(tmp_path / "a.nii.gz")
    surface = Surface(*zero_surface(ball.astype(np.float32)), volume.spacing, volume.unit)
    place = volume.shape, volume.spacing, volume.unit, volume.source
    result = Result(np.zeros((0, 3)), (), surface, 1, True, "at rest", *place, image=volume)
    export(result, tmp_path / "labels.nii.gz", tmp_path / "labels.nrrd")
    known, written = nibabel.load(tmp_path / "a.nii.gz"), nibabel.load(tmp_path / "labels.nii.gz")
    np.testing.assert_allclose(written.affine, known.affine, rtol=0, atol=1e-5)
    assert np.array_equal(written.affine, known.affine) or form != "sform"
    assert np.array_equal(np.asarray(written.dataobj) > 0, np.asarray(known.dataobj) > 0)
    values, header = nrrd.read(str(tmp_path / "labels.nrrd"))
    assert np.array_equal(values, np.asarray(written.dataobj))
    lps = np.diag([-1.0, -1.0, 1.0]) @ written.affine[:3]
    np.testing.assert_allclose(header["space directions"].T, lps[:, :3], rtol=0, atol=1e-5)
    np.testing.assert_allclose(header["space origin"], lps[:, 3], rtol=0, atol=1e-5)
    back = load_volume(tmp_path / "labels.nrrd")
    assert (back.shape, back.unit) == (volume.shape, "mm")
    place = back.geometry.affine(back.spacing, "RAS")
    np.testing.assert_allclose(place, volume.geometry.affine(volume.spacing, "RAS"), rtol=0, atol=1e-4)


def test_as_an_image_the_middle_plane_is_taken_or_the_one_that_is_chosen(tmp_path):
    write_nifti(tmp_path / "a.nii.gz")
    image = load_image(tmp_path / "a.nii.gz")
    assert np.array_equal(image.values, VALUES[5])
    unit, plane = image.notes
    assert unit == "It names no unit of length; millimeters were taken."
    assert "plane 6 of 10" in plane
    third = load_image(tmp_path / "a.nii.gz", page=3)
    assert np.array_equal(third.values, VALUES[2])
    assert third.spacing == pytest.approx((0.75, 0.5))
    np.testing.assert_allclose(third.geometry.origin, (affine() @ (0, 0, 2, 1))[:3])
    assert third.geometry.depth == pytest.approx(2.0)


def test_scaled_values_and_other_units_are_read_as_they_are_meant(tmp_path):
    write_nifti(tmp_path / "a.nii", scl_slope=0.5, scl_inter=10.0, xyzt_units=3)
    content = bytearray((tmp_path / "a.nii").read_bytes())
    content[112:120] = np.array([0.5, 10.0], "<f4").tobytes()
    (tmp_path / "a.nii").write_bytes(content)
    volume = load_volume(tmp_path / "a.nii")
    assert np.array_equal(volume.values, 0.5 * VALUES + 10.0)
    assert volume.unit == "µm"


def test_of_times_and_channels_one_is_taken(tmp_path):
    values = np.stack([[VALUES + 10 * time + 3 * channel for time in range(4)] for channel in range(2)])
    write_nifti(tmp_path / "a.nii", values, xyzt_units=2)
    first = load_volume(tmp_path / "a.nii")
    assert np.array_equal(first.values, VALUES)
    channels, times = first.notes
    assert "2 channels" in channels
    assert "4 points in time" in times
    chosen = load_volume(tmp_path / "a.nii", time=3, channel=2)
    assert np.array_equal(chosen.values, VALUES + 23)
    assert chosen.notes == ()
    with pytest.raises(ValueError, match=r"time is 5, but a\.nii has 4 of them: choose 1 to 4"):
        load_volume(tmp_path / "a.nii", time=5)


def test_colors_become_luminance_or_a_channel(tmp_path):
    red, green, blue = (VALUES % m for m in (40, 200, 90))
    stored = np.zeros(VALUES.T.shape, [("R", "u1"), ("G", "u1"), ("B", "u1")])
    for name, values in zip("RGB", (red, green, blue), strict=True):
        stored[name] = values.T
    nibabel.save(nibabel.Nifti1Image(stored, affine()), tmp_path / "a.nii")
    volume = load_volume(tmp_path / "a.nii")
    assert np.allclose(volume.values, 0.2125 * red + 0.7154 * green + 0.0721 * blue)
    assert volume.colors.samples.shape == (*VALUES.shape, 3)
    assert np.array_equal(load_volume(tmp_path / "a.nii", color="blue").values, blue)
    most = load_volume(tmp_path / "a.nii", color="contrast")
    assert np.array_equal(most.values, green)
    assert "The channel green of its colors was taken, which varies the most." in most.notes


def test_two_files_are_read_as_one(tmp_path):
    nibabel.save(nibabel.Nifti1Pair(VALUES.T, affine()), tmp_path / "a.img")
    volume = load_volume(tmp_path / "a.hdr")
    assert np.array_equal(volume.values, VALUES)
    (tmp_path / "a.img").unlink()
    with pytest.raises(ValueError, match=r"a\.hdr"):
        load_volume(tmp_path / "a.hdr")


def test_a_matrix_that_is_not_valid_leaves_the_sizes(tmp_path):
    write_nifti(tmp_path / "a.nii", xyzt_units=2)
    content = bytearray((tmp_path / "a.nii").read_bytes())
    content[280:328] = bytes(48)
    (tmp_path / "a.nii").write_bytes(content)
    volume = load_volume(tmp_path / "a.nii")
    assert (volume.geometry, volume.spacing) == (None, pytest.approx((2.0, 0.75, 0.5)))
    assert volume.notes == ("Its matrix is not valid, so that it is not known where it lies.",)


@pytest.mark.parametrize(
    ("least", "found"), [(-1000, True), (-1024, True), (-3024, True), (-500, False), (-4096, False), (0, False)]
)
def test_a_volume_that_shows_air_as_ct_does_has_hounsfield_units(tmp_path, least, found):
    write_nifti(tmp_path / "a.nii", np.maximum(VALUES, VALUES.max() - 900) - VALUES.max() + 900 + np.int16(least))
    volume = load_volume(tmp_path / "a.nii")
    assert volume.gray_range[0] == least
    assert volume.is_ct == found
    assert not volume.slice_across(0, 3).is_ct


def test_a_slope_and_an_intercept_make_hounsfield_units(tmp_path):
    image = nibabel.Nifti1Image(VALUES.T - VALUES.min(), affine())
    image.header.set_slope_inter(2.0, -1024.0)
    nibabel.save(image, tmp_path / "a.nii")
    volume = load_volume(tmp_path / "a.nii")
    assert volume.is_ct
    assert np.array_equal(volume.values, np.asarray(nibabel.load(tmp_path / "a.nii").dataobj).T)


OTHER = affine(
    turn=Rotation.from_euler("xyz", (25.0, -30.0, 100.0), degrees=True).as_matrix(), origin=(3.0, -12.0, 20.0)
)
SHEARED = affine() @ np.array([[1, 0, 0.3, 0], [0, 1, 0.1, 0], [0, 0, 1, 0], [0, 0, 0, 1]])


def write_labels(folder, sform, qform, codes):
    """An image with two matrices, and the label volumes that belong to it."""
    values = np.zeros(VALUES.shape, np.int16)
    values[3:7, 2:9, 4:12] = 5
    image = nibabel.Nifti1Image(values.T, affine())
    image.set_sform(sform, codes[0])
    image.set_qform(qform, codes[1])
    image.header.set_xyzt_units("mm")
    header = image.header
    nibabel.save(nibabel.Nifti1Image(values.T, None, header), folder / "a.nii.gz")
    volume = load_volume(folder / "a.nii.gz")
    surface = load_surface(folder / "a.nii.gz", volume)
    place = volume.shape, volume.spacing, volume.unit, volume.source
    result = Result(np.zeros((0, 3)), (), surface, 1, True, "at rest", *place, image=volume)
    export(result, folder / "l.nii.gz", folder / "l.nrrd")
    return volume, nibabel.load(folder / "a.nii.gz"), nibabel.load(folder / "l.nii.gz")


@pytest.mark.parametrize("codes", [(1, 1), (2, 1), (4, 3), (0, 2), (3, 0), (0, 0)])
@pytest.mark.parametrize("sform", [affine(), OTHER, SHEARED], ids=["same", "turned", "sheared"])
def test_labels_have_both_matrices_and_their_codes(tmp_path, sform, codes):
    volume, known, written = write_labels(tmp_path, sform, affine(), codes)
    for name in ("get_sform", "get_qform"):
        (wanted, code), (found, own) = (getattr(one, name)(coded=True) for one in (known, written))
        assert own == code
        if code:
            np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-4)
    np.testing.assert_allclose(written.affine, known.affine, rtol=0, atol=1e-4)
    assert np.array_equal(np.asarray(written.dataobj) > 0, np.asarray(known.dataobj) > 0)
    differ = min(codes) > 0 and not np.allclose(sform, affine())
    assert any("Its sform and its qform lie up to" in note for note in volume.notes) == differ


def test_labels_that_lie_by_the_qform_alone_are_those_of_their_volume(tmp_path):
    volume, _, _ = write_labels(tmp_path, OTHER, affine(), (1, 1))
    labels = np.zeros(VALUES.shape, np.int16)
    labels[3:7, 2:9, 4:12] = 5
    image = nibabel.Nifti1Image(labels.T, affine())
    image.set_sform(None, 0)
    image.set_qform(affine(), 1)
    image.to_filename(tmp_path / "q.nii")
    assert np.array_equal(load_volume_truth(tmp_path / "q.nii", volume).labels > 0, labels > 0)


def test_a_plane_of_a_volume_with_two_matrices_lies_where_both_have_it(tmp_path):
    write_labels(tmp_path, OTHER, affine(), (1, 1))
    plane = load_image(tmp_path / "a.nii.gz", page=4)
    for seen, wanted in ((plane.geometry.affine, OTHER), (plane.geometry.qform_affine, affine())):
        np.testing.assert_allclose(seen(plane.spacing)[:, 3], wanted @ [0, 0, 3, 1], atol=1e-4)


def test_a_size_that_is_given_leaves_both_places_of_the_first_voxel(tmp_path):
    write_labels(tmp_path, OTHER, affine(), (1, 1))
    volume = load_volume(tmp_path / "a.nii.gz", spacing=(1.0, 1.0, 1.0), unit="mm")
    np.testing.assert_allclose(volume.geometry.affine(volume.spacing)[:, 3], OTHER[:, 3], atol=1e-4)
    np.testing.assert_allclose(volume.geometry.qform_affine(volume.spacing)[:, 3], affine()[:, 3], atol=1e-4)


@pytest.mark.parametrize(("low", "high", "found"), [(10.0, 90.0, (10.0, 90.0)), (0.0, 0.0, None)])
def test_the_window_is_that_of_the_header_where_it_states_one(tmp_path, low, high, found):
    volume = nibabel.Nifti1Image(np.arange(1000, dtype=np.int16).reshape(10, 10, 10), np.eye(4))
    volume.header["cal_min"], volume.header["cal_max"] = low, high
    nibabel.save(volume, tmp_path / "a.nii")
    assert load_volume(tmp_path / "a.nii").window == found
