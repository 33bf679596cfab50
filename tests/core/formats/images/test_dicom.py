"""DICOM: single files, films, series in folders, and what is wrong with some of them."""

import numpy as np
import pydicom
import pytest
from pydicom.uid import JPEG2000Lossless, RLELossless

from cpm_core import load_image, load_volume
from cpm_core.formats import open_stack
from cpm_core.formats.images import dicom
from cpm_core.formats.images.dicom import can_read

from .made import ACROSS, OBLIQUE, SHAPE, VALUES, dataset, write_series, write_slice

EVEN = [2.5 * k for k in range(10)]


@pytest.mark.parametrize("along", [ACROSS, OBLIQUE], ids=["across", "oblique"])
def test_a_series_lies_where_its_slices_say_and_not_where_their_thickness_would_put_them(tmp_path, along):
    write_series(tmp_path / "s", EVEN, along)
    volume = load_volume(tmp_path / "s")
    assert np.array_equal(volume.values, VALUES)
    assert volume.spacing == pytest.approx((2.5, 0.75, 0.5), abs=1e-5)
    assert (volume.unit, volume.notes) == ("mm", ())
    at = volume.geometry.affine(volume.spacing) @ (3, 4, 5, 1)
    column, row = np.array(along)
    wanted = (-20, 10, 5) + 7.5 * np.cross(column, row) + 4 * 0.75 * row + 5 * 0.5 * column
    np.testing.assert_allclose(at[:3], wanted, atol=1e-5)
    assert volume.geometry.convention == "LPS"
    assert (volume.geometry.oblique > 1.0) == (along is OBLIQUE)


def test_slices_may_be_numbered_against_their_positions(tmp_path):
    write_series(tmp_path / "s", EVEN[::-1])
    assert np.array_equal(load_volume(tmp_path / "s").values, VALUES[::-1])


def test_of_a_series_with_a_gap_the_longest_even_part_is_taken_and_it_is_said(tmp_path):
    heights = [*range(9), *range(11, 22)]
    write_series(tmp_path / "s", heights, values=np.concatenate([VALUES, VALUES + 1]))
    volume = load_volume(tmp_path / "s")
    assert volume.shape == (11, *SHAPE[1:])
    assert volume.notes == (
        "Between slices 9 and 10 lie 3 mm, elsewhere 1 mm: 2 slices are missing.",
        "The longest even part has 11 slices, 10 to 20, 1 mm apart.",
        "Only these were taken.",
    )
    assert np.array_equal(volume.values[0], VALUES[9])
    assert volume.geometry.origin == pytest.approx((-20.0, 10.0, 16.0))
    whole = load_image(tmp_path / "s", page=3)
    assert np.array_equal(whole.values, VALUES[2])
    assert whole.geometry.origin == pytest.approx((-20.0, 10.0, 7.0))


def test_the_other_even_parts_of_a_series_are_volumes_by_choice(tmp_path):
    heights = [*range(9), *range(11, 22)]
    write_series(tmp_path / "s", heights, values=np.concatenate([VALUES, VALUES + 1]))
    assert open_stack(tmp_path / "s").series == ("head", "head, slices 1 to 9")
    volume = load_volume(tmp_path / "s", series=2)
    assert (volume.shape, volume.notes) == ((9, *SHAPE[1:]), ())
    assert np.array_equal(volume.values, VALUES[:9])
    assert volume.geometry.origin == pytest.approx((-20.0, 10.0, 5.0))


def test_without_an_even_part_large_enough_the_sentence_says_why_and_what_to_do(tmp_path):
    write_series(tmp_path / "s", [0, 1, 2, 3, 4, 9, 10, 11, 12])
    with pytest.raises(ValueError, match=r"s: Between slices 5 and 6 lie 5 mm, .* at least 8 planes: resample them"):
        load_volume(tmp_path / "s")
    assert load_image(tmp_path / "s").shape == SHAPE[1:]


def test_slices_that_are_shifted_against_each_other_keep_their_slant(tmp_path):
    folder = tmp_path / "s"
    folder.mkdir()
    for number in range(10):
        write_slice(folder / f"{number}.dcm", VALUES[number], (0.0, 0.5 * number, 2.0 * number), number=number)
    volume = load_volume(folder)
    assert volume.geometry.slant == pytest.approx(np.degrees(np.arctan(0.25)))
    assert "Its axes are 14.0° off right angles" in volume.notes[0]
    at = volume.geometry.affine(volume.spacing) @ (4, 0, 0, 1)
    np.testing.assert_allclose(at[:3], (0, 2, 8), atol=1e-6)


def test_times_at_the_same_places_are_told_apart(tmp_path):
    write_series(tmp_path / "s", [height for height in EVEN for _ in range(2)], values=np.repeat(VALUES, 2, 0))
    for path in (tmp_path / "s").iterdir():
        slice_ = pydicom.dcmread(path)
        slice_.TemporalPositionIdentifier = slice_.InstanceNumber % 2 + 1
        slice_.RescaleIntercept, slice_.RescaleSlope = 100 * (slice_.InstanceNumber % 2), 1
        slice_.save_as(path)
    first, second = load_volume(tmp_path / "s"), load_volume(tmp_path / "s", time=2)
    assert np.array_equal(first.values, VALUES)
    assert np.array_equal(second.values, VALUES + 100)
    assert first.notes == ("Only the first of its 2 points in time was taken.",)


def test_of_several_series_that_with_the_most_images_is_taken_or_the_chosen_one(tmp_path):
    write_series(tmp_path / "s", EVEN)
    write_slice(tmp_path / "s" / "scout.dcm", VALUES[0] + 1, along=OBLIQUE, SeriesDescription="scout")
    volume = load_volume(tmp_path / "s")
    assert np.array_equal(volume.values, VALUES)
    assert volume.notes == ('Of its 2 series that with the most images was taken, 1 ("head").',)
    assert np.array_equal(load_image(tmp_path / "s", series="scout").values, VALUES[0] + 1)
    assert np.array_equal(load_image(tmp_path / "s", series=2).values, VALUES[0] + 1)
    with pytest.raises(ValueError, match='series is "leg", but s has "head", "scout": choose one of these'):
        load_image(tmp_path / "s", series="leg")


def test_other_files_of_the_folder_do_not_matter_and_damaged_ones_are_told(tmp_path):
    write_series(tmp_path / "s", EVEN)
    (tmp_path / "s" / "notes.txt").write_text("nothing")
    content = (tmp_path / "s" / "037.dcm").read_bytes()
    (tmp_path / "s" / "bad.dcm").write_bytes(content[:150] + b"\xff" * 60)
    volume = load_volume(tmp_path / "s")
    assert volume.shape == SHAPE
    assert volume.notes in ((), ("1 of its files was left out, which cannot be read.",))


def test_without_positions_slices_come_in_the_order_of_their_numbers(tmp_path):
    write_series(tmp_path / "s", EVEN, ImagePositionPatient=None, SpacingBetweenSlices=3.0)
    volume = load_volume(tmp_path / "s")
    assert np.array_equal(volume.values, VALUES)
    assert (volume.spacing[0], volume.geometry) == (3.0, None)
    assert volume.notes[0].endswith("they were taken in their order, 3 mm apart.")


def test_one_slice_is_an_image_and_no_volume(tmp_path):
    write_slice(tmp_path / "a.dcm", VALUES[0], (1.0, 2.0, 3.0), OBLIQUE)
    image = load_image(tmp_path / "a.dcm")
    assert np.array_equal(image.values, VALUES[0])
    assert (image.spacing, image.unit, image.notes) == ((0.75, 0.5), "mm", ())
    assert image.geometry.origin == (1.0, 2.0, 3.0)
    assert image.geometry.depth == 9.0
    with pytest.raises(ValueError, match=r"a\.dcm has the shape \(12, 14\)"):
        load_volume(tmp_path / "a.dcm")


def test_values_are_rescaled_and_white_is_bright(tmp_path):
    unsigned = (VALUES[0] + 500).astype(np.uint16)
    write_slice(tmp_path / "a.dcm", unsigned, RescaleSlope=0.5, RescaleIntercept=-1024)
    assert np.array_equal(load_image(tmp_path / "a.dcm").values, 0.5 * unsigned - 1024)
    write_slice(tmp_path / "b.dcm", unsigned, PhotometricInterpretation="MONOCHROME1", BitsStored=12, HighBit=11)
    image = load_image(tmp_path / "b.dcm")
    assert np.array_equal(image.values, 4095.0 - unsigned)
    assert image.notes == ("It counts from white to black and was inverted.",)
    write_slice(tmp_path / "c.dcm", VALUES[0], PhotometricInterpretation="MONOCHROME1")
    assert np.array_equal(load_image(tmp_path / "c.dcm").values, -1.0 - VALUES[0])


@pytest.mark.parametrize("told", [-2000, 63536])  # many programs write the number of 16 bits without its sign
def test_what_fills_the_rectangle_around_an_image_is_no_data(tmp_path, told):
    values = VALUES.astype(np.int16)
    values[:, :2] = -2000
    values[5] = -2000
    for number, plane in enumerate(values):
        position = (0.0, 0.0, 1.0 * number)
        slice_ = dataset(plane, position, ACROSS, RescaleSlope=2.0, RescaleIntercept=-1024)
        slice_.add_new(0x00280120, "SS" if told < 0 else "US", told)
        slice_.save_as(tmp_path / f"{number}.dcm", enforce_file_format=True)
    image = load_image(tmp_path / "0.dcm")
    filled = 2 * values.shape[2]
    assert [note.startswith(f"{filled} pixels ") for note in image.notes] == [True]
    inside = 2.0 * values[0, 2:] - 1024
    assert np.array_equal(image.values[2:], inside)
    assert image.values[:2].min() >= inside.min()
    whole = load_volume(tmp_path)
    assert whole.values.min() >= (2.0 * VALUES - 1024).min()
    assert any("have no data" in note for note in whole.notes)


def test_colors_of_fewer_bits_than_they_take_are_as_bright_as_they_are(tmp_path):
    colors = np.stack([VALUES[0] % 4096, VALUES[1] % 4096, VALUES[2] % 4096], axis=2).astype(np.uint16)
    changes = {
        "Rows": colors.shape[0],
        "Columns": colors.shape[1],
        "BitsStored": 12,
        "HighBit": 11,
        "SamplesPerPixel": 3,
        "PlanarConfiguration": 0,
    }
    write_slice(tmp_path / "a.dcm", colors, PhotometricInterpretation="RGB", **changes)
    image = load_image(tmp_path / "a.dcm")
    assert image.colors.white == 4095.0
    assert np.allclose(image.values, colors @ [0.2125, 0.7154, 0.0721])


def test_the_size_of_a_pixel_on_the_detector_is_called_that(tmp_path):
    plain = {"ImagePositionPatient": None, "ImageOrientationPatient": None, "PixelSpacing": None}
    write_slice(tmp_path / "a.dcm", VALUES[0], **plain, ImagerPixelSpacing=[0.2, 0.1])
    image = load_image(tmp_path / "a.dcm")
    assert (image.spacing, image.unit, image.geometry) == ((0.2, 0.1), "mm", None)
    assert image.notes == ("The size of a pixel is that on the detector.",)
    region = pydicom.Dataset()
    region.PhysicalDeltaX, region.PhysicalDeltaY = 0.02, 0.03
    region.PhysicalUnitsXDirection = region.PhysicalUnitsYDirection = 3
    write_slice(tmp_path / "b.dcm", VALUES[0], **plain, SequenceOfUltrasoundRegions=[region])
    image = load_image(tmp_path / "b.dcm")
    assert (image.spacing, image.unit) == ((0.03, 0.02), "cm")


def test_a_film_has_frames_which_become_planes_of_a_volume(tmp_path):
    plain = {"ImagePositionPatient": None, "ImageOrientationPatient": None}
    write_slice(tmp_path / "a.dcm", VALUES, **plain, NumberOfFrames=10, FrameTime=40.0)
    image = load_image(tmp_path / "a.dcm")
    assert np.array_equal(image.values, VALUES[0])
    assert image.notes == ("Only the first of its 10 frames was taken.",)
    assert np.array_equal(load_image(tmp_path / "a.dcm", page=4).values, VALUES[3])
    assert np.array_equal(load_image(tmp_path / "a.dcm", time=5).values, VALUES[4])
    volume = load_volume(tmp_path / "a.dcm")
    assert np.array_equal(volume.values, VALUES)
    assert ["10 frames" in note for note in volume.notes] == [True]


def grouped(height):
    """What an image in a file of many tells of itself."""
    item, place, turn, measures, values = (pydicom.Dataset() for _ in range(5))
    place.ImagePositionPatient = [0.0, 0.0, float(height)]
    turn.ImageOrientationPatient = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
    measures.PixelSpacing, measures.SliceThickness = [0.5, 0.25], 4.0
    values.RescaleSlope, values.RescaleIntercept = 2.0, float(height)
    item.PlanePositionSequence, item.PlaneOrientationSequence = [place], [turn]
    item.PixelMeasuresSequence, item.PixelValueTransformationSequence = [measures], [values]
    return item


def test_a_volume_in_one_file_is_ordered_by_the_places_of_its_images(tmp_path):
    heights = [3.0 * (k * 3 % 10) for k in range(10)]
    plain = {"ImagePositionPatient": None, "ImageOrientationPatient": None, "PixelSpacing": None}
    groups = [grouped(height) for height in heights]
    write_slice(tmp_path / "a.dcm", VALUES, **plain, NumberOfFrames=10, PerFrameFunctionalGroupsSequence=groups)
    volume = load_volume(tmp_path / "a.dcm")
    order = np.argsort(heights)
    assert np.array_equal(volume.values, 2.0 * VALUES[order] + np.array(heights)[order, None, None])
    assert volume.spacing == (3.0, 0.5, 0.25)
    assert ["plane 6 of 10" in note for note in load_image(tmp_path / "a.dcm").notes] == [True]


@pytest.mark.parametrize("packing", [RLELossless, JPEG2000Lossless])
def test_packed_pixels_are_the_same(tmp_path, packing):
    codecs = pytest.importorskip("imagecodecs")
    found = dataset(VALUES[0].astype(np.uint16))
    if packing == RLELossless:
        found.compress(packing)
    else:
        packed = codecs.jpeg2k_encode(found.pixel_array, level=0, codecformat="j2k")
        found.PixelData = pydicom.encaps.encapsulate([packed])
        found.file_meta.TransferSyntaxUID = packing
        found["PixelData"].VR = "OB"
    found.save_as(tmp_path / "a.dcm")
    assert np.array_equal(load_image(tmp_path / "a.dcm").values, VALUES[0].astype(np.uint16))


def of_twelve_bits(codecs):
    """A slice packed as JPEG of 12 bits, which Pillow does not unpack."""
    values = (VALUES[0] - VALUES.min()).astype(np.uint16)
    found = dataset(values, BitsStored=12, HighBit=11)
    packed = codecs.jpeg8_encode(values, level=100, bitspersample=12)
    found.PixelData = pydicom.encaps.encapsulate([packed])
    found.file_meta.TransferSyntaxUID = pydicom.uid.JPEGExtended12Bit
    found["PixelData"].VR = "OB"
    return found, codecs.jpeg8_decode(packed)


def test_jpeg_of_twelve_bits_is_unpacked_by_imagecodecs(tmp_path):
    found, known = of_twelve_bits(pytest.importorskip("imagecodecs"))
    found.save_as(tmp_path / "a.dcm")
    assert np.array_equal(load_image(tmp_path / "a.dcm").values, known)


def test_packed_pixels_of_another_size_than_the_header_says_are_refused(tmp_path):
    found, _ = of_twelve_bits(pytest.importorskip("imagecodecs"))
    found.Rows = 11
    found.save_as(tmp_path / "a.dcm")
    with pytest.raises(ValueError, match="is damaged"):
        load_image(tmp_path / "a.dcm")


def test_colors_become_luminance(tmp_path):
    colors = np.stack([VALUES[0] % 251, VALUES[1] % 251, VALUES[2] % 251], -1).astype(np.uint8)
    write_slice(tmp_path / "a.dcm", VALUES[0].astype(np.uint8), SamplesPerPixel=3, PlanarConfiguration=0,
                PhotometricInterpretation="RGB", PixelData=colors.tobytes())  # fmt: skip
    image = load_image(tmp_path / "a.dcm")
    assert np.allclose(image.values, colors @ (0.2125, 0.7154, 0.0721))
    assert np.array_equal(image.colors.samples, colors)


@pytest.mark.parametrize("implicit", [True, False])
def test_old_files_without_a_mark_are_known_by_their_first_entry(tmp_path, implicit):
    found = dataset(VALUES[0])
    found.file_meta, found.preamble = pydicom.dataset.FileMetaDataset(), None
    pydicom.dcmwrite(tmp_path / "a.dcm", found, implicit_vr=implicit, little_endian=True, enforce_file_format=False)
    content = (tmp_path / "a.dcm").read_bytes()
    assert content[128:132] != b"DICM" and can_read(content[:512], tmp_path / "a.dcm")
    assert np.array_equal(load_image(tmp_path / "a.dcm").values, VALUES[0])


def test_a_file_without_an_image_is_called_that(tmp_path):
    write_slice(tmp_path / "a.dcm", VALUES[0], Rows=None)
    with pytest.raises(ValueError, match=r"a\.dcm contains no DICOM image: choose another file"):
        load_image(tmp_path / "a.dcm")


def test_a_file_whose_pixels_were_taken_out_is_called_that(tmp_path):
    write_slice(tmp_path / "a.dcm", VALUES[0], PixelData=None)
    with pytest.raises(ValueError, match=r"a\.dcm contains no DICOM image: choose another file"):
        load_image(tmp_path / "a.dcm")


@pytest.mark.parametrize("along", [ACROSS, OBLIQUE], ids=["across", "oblique"])
def test_the_planes_of_a_grid_of_doses_lie_at_their_offsets(tmp_path, along):
    """It is one file, which tells the place of the first plane and the distances of the others from it."""
    grid = {
        "NumberOfFrames": 10,
        "FrameIncrementPointer": 0x3004000C,
        "GridFrameOffsetVector": [3.0 * k for k in range(10)],
    }
    write_slice(tmp_path / "dose.dcm", VALUES, (-20.0, 10.0, 5.0), along, **grid)
    volume = load_volume(tmp_path / "dose.dcm")
    assert np.array_equal(volume.values, VALUES)
    assert volume.notes == ()
    assert volume.spacing == pytest.approx((3.0, 0.75, 0.5), abs=1e-5)
    write_series(tmp_path / "s", [3.0 * k for k in range(10)], along)
    series = load_volume(tmp_path / "s")
    np.testing.assert_allclose(
        volume.geometry.affine(volume.spacing), series.geometry.affine(series.spacing), atol=1e-5
    )


def test_colors_that_pydicom_does_not_unpack_are_unpacked_by_imagecodecs(tmp_path):
    codecs = pytest.importorskip("imagecodecs")
    colors = np.stack([VALUES[plane] % 251 for plane in range(3)], -1).astype(np.uint8)
    found = dataset(
        VALUES[0].astype(np.uint8), SamplesPerPixel=3, PlanarConfiguration=0, PhotometricInterpretation="RGB"
    )
    found.PixelData = pydicom.encaps.encapsulate([codecs.jpegls_encode(colors)])
    found.file_meta.TransferSyntaxUID = pydicom.uid.JPEGLSNearLossless
    found["PixelData"].VR = "OB"
    found.save_as(tmp_path / "a.dcm")
    assert np.array_equal(load_image(tmp_path / "a.dcm").colors.samples, colors)


def test_colors_that_jpeg_2000_has_turned_are_those_of_the_file():
    pytest.importorskip("imagecodecs")
    image = load_image(pydicom.data.get_testdata_file("GDCMJ2K_TextGBR.dcm"))
    shades, counts = np.unique(image.colors.samples.reshape(-1, 3), axis=0, return_counts=True)
    most = {tuple(shade) for shade in shades[np.argsort(-counts)[:4]].tolist()}
    assert most == {(128, 128, 128), (255, 0, 0), (0, 255, 0), (0, 0, 255)}


@pytest.mark.parametrize(
    ("modality", "kind", "found"), [("CT", None, True), ("CT", "HU", True), ("CT", "US", False), ("MR", None, False)]
)
def test_rescaled_values_of_ct_are_hounsfield_units_as_the_file_says(tmp_path, modality, kind, found):
    changes = {"Modality": modality, "RescaleSlope": 2.0, "RescaleIntercept": -1024.0}
    if kind:
        changes["RescaleType"] = kind
    write_series(tmp_path, HEIGHTS, **changes)
    volume = load_volume(tmp_path)
    assert volume.is_ct == load_image(tmp_path).is_ct == found
    assert np.array_equal(volume.values[:10], 2.0 * VALUES[:10] - 1024.0)


def test_the_window_of_a_series_is_that_of_its_middle_slice_and_its_first_of_several(tmp_path):
    write_series(tmp_path, range(11))
    assert load_volume(tmp_path).window is None
    for path in tmp_path.iterdir():
        slice_ = pydicom.dcmread(path)
        slice_.WindowCenter, slice_.WindowWidth = [40.0 + slice_.InstanceNumber, 0.0], [400.0, 10.0]
        slice_.save_as(path)
    assert load_volume(tmp_path).window == (46.0 - 200.0, 46.0 + 200.0)


def test_the_window_of_an_inverted_file_is_inverted_with_its_values(tmp_path):
    window = {"WindowCenter": 120.0, "WindowWidth": 100.0, "RescaleSlope": 2.0, "RescaleIntercept": -30.0}
    write_slice(tmp_path / "plain.dcm", VALUES[0], **window)
    write_slice(tmp_path / "inverted.dcm", VALUES[0], PhotometricInterpretation="MONOCHROME1", **window)
    plain, inverted = (load_image(tmp_path / name) for name in ("plain.dcm", "inverted.dcm"))
    assert plain.window == (70.0, 170.0)
    shown, turned = ((image.values - image.window[0]) / 100.0 for image in (plain, inverted))
    np.testing.assert_allclose(turned, 1.0 - shown)


def test_ct_without_a_rescaling_has_no_hounsfield_units(tmp_path):
    write_series(tmp_path, HEIGHTS, Modality="CT")
    assert not load_volume(tmp_path).is_ct


ORIGIN = np.array([-20.0, 10.0, 5.0])
HEIGHTS = 2.0 * np.arange(20)


def two_acquisitions(folder, apart):
    """A series whose second acquisition lies so far above the first."""
    write_series(folder, HEIGHTS, AcquisitionNumber=1)
    for number, height in enumerate(HEIGHTS + apart):
        place = np.add(ORIGIN, (0, 0, height))
        write_slice(folder / f"b{number}.dcm", VALUES[9], place, number=100 + number, AcquisitionNumber=2)
    return folder


def test_acquisitions_between_one_another_are_series_of_their_own(tmp_path):
    folder = two_acquisitions(tmp_path / "series", 0.7)
    assert [name[-1] for name in open_stack(folder).series] == ["1", "2"]
    for series in (1, 2):
        volume = load_volume(folder, series=series)
        assert (volume.shape[0], volume.spacing[0]) == (20, 2.0)
        assert np.array_equal(volume.values[3], VALUES[3] if series == 1 else VALUES[9])
    assert load_volume(folder).notes == (
        'Of its 2 series that with the most images was taken, 1 ("head, acquisition 1").',
    )


def test_acquisitions_that_fill_each_others_gaps_are_one_volume_and_that_is_reported(tmp_path):
    volume = load_volume(two_acquisitions(tmp_path / "series", 1.0))
    assert (volume.shape[0], volume.spacing[0]) == (40, 1.0)
    assert volume.notes == ("Slices of several acquisitions lie between one another; they were taken as one volume.",)


@pytest.mark.parametrize("apart", [0.0, 40.0])
def test_acquisitions_at_the_same_places_or_one_behind_the_other_are_not_mixed(tmp_path, apart):
    volume = load_volume(two_acquisitions(tmp_path / "series", apart))
    assert volume.shape[0] == (40 if apart else 20)
    assert ["2 points in time" in note for note in volume.notes] == ([] if apart else [True])


def test_a_place_that_lacks_one_of_several_times_is_no_mixture(tmp_path):
    folder = two_acquisitions(tmp_path / "series", 0.0)
    (folder / "b7.dcm").unlink()
    more = "At some places it has more slices than at others; the first of them were taken."
    assert load_volume(folder).notes == (more,)


def test_slices_that_are_shifted_to_the_side_are_reported(tmp_path):
    for number, height in enumerate(HEIGHTS):
        write_slice(
            tmp_path / f"{number}.dcm", VALUES[3], np.add(ORIGIN, (3.0 * (number == 9), 0, height)), number=number
        )
    text = "Its slices are shifted sideways by up to 3 mm; they were taken as if in line."
    assert load_volume(tmp_path).notes == (text,)


def test_a_tilted_gantry_keeps_its_angle_and_is_reported(tmp_path):
    tilt = np.tan(np.radians(15.0))
    for number, height in enumerate(HEIGHTS):
        write_slice(tmp_path / f"{number}.dcm", VALUES[3], np.add(ORIGIN, (0, tilt * height, height)), number=number)
    volume = load_volume(tmp_path)
    assert volume.notes == ("Its axes are 15.0° off right angles; lengths were taken as if they were at right angles.",)
    last = volume.geometry.starting_at((19, 0, 0), volume.spacing).origin
    assert last == pytest.approx(np.add(ORIGIN, (0, tilt * HEIGHTS[-1], HEIGHTS[-1])))


def test_a_slice_twice_or_without_a_place_is_not_one_more_plane(tmp_path):
    write_series(tmp_path, HEIGHTS)
    write_slice(tmp_path / "twice.dcm", VALUES[0], np.add(ORIGIN, (0, 0, 8.0)), number=99)
    more = "At some places it has more slices than at others; the first of them were taken."
    volume = load_volume(tmp_path)
    assert (volume.shape[0], volume.notes) == (20, (more,))
    write_slice(tmp_path / "nowhere.dcm", VALUES[0], number=50, ImagePositionPatient=None)
    volume = load_volume(tmp_path)
    assert volume.shape[0] == 20
    assert "2 series" in volume.notes[0]


def test_slices_in_a_fan_are_no_volume_and_the_sentence_says_why(tmp_path):
    for number in range(12):
        angle = np.radians(15.0 * number)
        along = ((1.0, 0.0, 0.0), (0.0, np.cos(angle), np.sin(angle)))
        write_slice(tmp_path / f"{number}.dcm", VALUES[3], ORIGIN, along, number=number)
    with pytest.raises(ValueError, match="Its 12 images have 12 different sizes, directions or series"):
        load_volume(tmp_path)
    assert load_image(tmp_path).shape == VALUES.shape[1:]


@pytest.mark.parametrize("jitter", [0.0, 2e-5, 2e-4])
def test_slices_of_which_each_rounds_its_direction_otherwise_are_one_volume(tmp_path, jitter):
    rng = np.random.default_rng(3)
    for number, height in enumerate(HEIGHTS):
        turn = 0.0005 + rng.uniform(-jitter, jitter)  # at a limit of any number of decimals
        along = ((1.0, 0.0, 0.0), (0.0, np.cos(turn), np.sin(turn)))
        spacing = (0.75 + rng.uniform(-jitter, jitter) / 10, 0.5)
        write_slice(tmp_path / f"{number}.dcm", VALUES[3], np.add(ORIGIN, (0, 0, height)), along, spacing, number)
    volume = load_volume(tmp_path)
    assert (volume.shape[0], volume.notes) == (len(HEIGHTS), ())


@pytest.mark.parametrize(
    ("entries", "in_time"),
    [
        ({"FrameTime": 40.0}, True),
        ({"FrameIncrementPointer": 0x00181063, "FrameTime": 40.0}, True),
        ({"FrameIncrementPointer": 0x00181065, "FrameTimeVector": [40.0] * 10}, True),
        ({"FrameIncrementPointer": 0x00540070, "TimeSlotVector": list(range(1, 11))}, True),
        ({"FrameIncrementPointer": 0x00540080, "SliceVector": list(range(1, 11))}, False),
        ({"FrameIncrementPointer": 0x00540080, "SliceVector": list(range(1, 11)), "FrameTime": 40.0}, False),
        ({"FrameIncrementPointer": 0x00540090, "AngularViewVector": list(range(1, 11))}, False),
        ({}, False),
    ],
)
def test_frames_are_points_in_time_only_where_the_file_says_so(tmp_path, entries, in_time):
    nowhere = {"ImagePositionPatient": None, "ImageOrientationPatient": None}
    write_slice(tmp_path / "a.dcm", VALUES, NumberOfFrames=len(VALUES), **nowhere, **entries)
    stack = open_stack(tmp_path / "a.dcm")
    assert (stack.shape[0], stack.times) == ((1, 10) if in_time else (10, 1))
    volume = load_volume(tmp_path / "a.dcm")
    assert np.array_equal(volume.values, VALUES)
    assert any("time" in note for note in volume.notes) == in_time


@pytest.mark.parametrize(("ratio", "spacing"), [([2, 1], (2.0, 1.0)), ([3, 4], (0.75, 1.0)), ([0, 1], (1.0, 1.0))])
def test_without_a_size_a_pixel_has_the_ratio_of_its_sides(tmp_path, ratio, spacing):
    write_slice(tmp_path / "a.dcm", VALUES[3], PixelSpacing=None, PixelAspectRatio=ratio)
    image = load_image(tmp_path / "a.dcm")
    assert (image.spacing, image.unit) == (spacing, None)
    write_slice(tmp_path / "b.dcm", VALUES[3], PixelAspectRatio=ratio)
    assert load_image(tmp_path / "b.dcm").spacing == (0.75, 0.5)


@pytest.fixture
def disc(tmp_path):
    """A CD with two series of a patient three folders below, and its directory."""
    for number, (folder, count) in enumerate((("SE0", 20), ("SE1", 12))):
        place = tmp_path / "cd" / "DICOM" / "PAT0" / "ST0" / folder
        place.parent.mkdir(parents=True, exist_ok=True)
        write_series(
            place, HEIGHTS[:count], SeriesInstanceUID=f"1.2.{number + 1}", SeriesDescription=f"series {number}"
        )
    (tmp_path / "cd" / "AUTORUN.INF").write_text("[autorun]")
    (tmp_path / "cd" / "DICOM" / "._SE0").write_bytes(b"\0\5\x16\7" + bytes(600))
    directory = dataset(VALUES[0], Rows=None, Columns=None, PixelData=None, FileSetID="DISC")
    directory.SOPClassUID = directory.file_meta.MediaStorageSOPClassUID = pydicom.uid.MediaStorageDirectoryStorage
    directory.save_as(tmp_path / "cd" / "DICOMDIR", enforce_file_format=True)
    return tmp_path / "cd"


@pytest.mark.parametrize("name", ["", "DICOMDIR", "DICOM", "DICOM/PAT0"])
def test_series_in_the_folders_below_are_those_of_a_folder(disc, name):
    stack = open_stack(disc / name)
    assert (stack.series, stack.shape[0]) == (("series 0", "series 1"), 20)
    volume = load_volume(disc / name, series="series 1")
    assert np.array_equal(volume.values, load_volume(disc / "DICOM" / "PAT0" / "ST0" / "SE1").values)
    assert load_volume(disc / name).notes == ('Of its 2 series that with the most images was taken, 1 ("series 0").',)


def test_a_series_in_a_folder_is_not_mixed_with_those_below(disc):
    write_series(disc, HEIGHTS[:10], SeriesInstanceUID="1.2.9")
    assert (open_stack(disc).shape[0], len(open_stack(disc).series)) == (10, 1)


def test_a_folder_with_too_many_files_below_is_not_searched(disc, monkeypatch):
    monkeypatch.setattr(dicom, "_MAX_FILES_BELOW", 5)
    with pytest.raises(ValueError, match="cd has more than 5 files in the folders below it: choose one of these"):
        load_volume(disc)


def nuclear_volume(folder, step, vector):
    """A volume of slices at a detector, in steps and in an order of slices."""
    detector = pydicom.Dataset()
    detector.ImagePositionPatient, detector.ImageOrientationPatient = [-76, -70, 100], [1, 0, 0, 0, 1, 0]
    found = dataset(VALUES, ImagePositionPatient=None, ImageOrientationPatient=None, SpacingBetweenSlices=step)
    found.NumberOfFrames, found.FrameIncrementPointer, found.SliceVector = len(VALUES), 0x00540080, list(vector)
    found.DetectorInformationSequence = [detector]
    found.save_as(folder / "a.dcm", enforce_file_format=True)
    return load_volume(folder / "a.dcm")


@pytest.mark.parametrize("step", [3.0, -3.0])
def test_slices_of_nuclear_medicine_against_the_standard_have_no_place(tmp_path, step):
    assert nuclear_volume(tmp_path, step, range(10, 0, -1)).geometry is None  # none is known to be the first


@pytest.mark.parametrize("step", [3.0, -3.0])
def test_the_place_of_slices_of_nuclear_medicine_is_that_of_the_detector(tmp_path, step):
    volume = nuclear_volume(tmp_path, step, range(1, 11))
    first = 0 if step > 0 else -1  # planes lie in the order of their normal
    assert np.array_equal(volume.values[first], VALUES[0])
    assert volume.spacing == (3.0, 0.75, 0.5)
    assert volume.geometry.origin == (-76, -70, 100 if step > 0 else 100 + 9 * step)
    assert volume.geometry.letters == ("S", "P", "L")
