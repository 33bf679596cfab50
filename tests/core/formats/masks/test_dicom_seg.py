"""DICOM SEG: segments refer to the series in which objects were found, and become objects in it again."""

import sys
from dataclasses import replace

import numpy as np
import pydicom
import pytest
from pydicom.dataset import Dataset
from pydicom.uid import SegmentationStorage, generate_uid

from cpm_core import Result, export, load_surface, load_volume, load_volume_truth
from cpm_core.contours import join_surfaces, label_voxels
from cpm_core.contours.surface import surface_from_labels
from cpm_core.image.surface import Label

from ..images.made import ACROSS, OBLIQUE, VALUES, dataset, write_nifti, write_series

HEADER = {
    "StudyInstanceUID": generate_uid(entropy_srcs=["study"]),
    "FrameOfReferenceUID": generate_uid(entropy_srcs=["frame"]),
    **{"PatientID": "1", "PatientName": "Made^Up", "PatientBirthDate": "", "PatientSex": "", "StudyID": "1"},
    **{"StudyDate": "20200101", "StudyTime": "120000", "AccessionNumber": "", "ReferringPhysicianName": ""},
    "SeriesNumber": 3,
}
HEIGHTS = 2.0 * np.arange(10)
NAMES = (Label(3, "right kidney", "#ff8000"), Label(7, "Gefäß", "#0010ff"))
LABELS = np.zeros(VALUES.shape, np.int32)
LABELS[2:5, 3:6, 4:9] = 3
LABELS[6:9, 5:9, 5:12] = 7


def found_in(volume):
    bodies = [(n, surface_from_labels((n == LABELS).astype(np.int32), volume.spacing, volume.unit)) for n in (3, 7)]
    surface = replace(join_surfaces(bodies, volume.spacing, volume.unit), labels=NAMES)
    nothing, shape = np.empty((0, 3)), volume.shape
    return Result(nothing, (), surface, 0, True, "", shape, volume.spacing, volume.unit, volume.source, image=volume)


@pytest.mark.parametrize("along", [ACROSS, OBLIQUE], ids=["across", "oblique"])
def test_segments_refer_to_their_series_and_come_back(tmp_path, along):
    highdicom = pytest.importorskip("highdicom")
    series = write_series(tmp_path / "series", HEIGHTS, along, **HEADER)
    volume = load_volume(series)
    export(found_in(volume), tmp_path / "a.seg.dcm", image=series)
    segments = highdicom.seg.segread(tmp_path / "a.seg.dcm")
    assert segments.FrameOfReferenceUID == HEADER["FrameOfReferenceUID"]
    assert segments.PatientID == "1"
    assert [segments.get_segment_description(n).segment_label for n in (1, 2)] == [label.name for label in NAMES]
    slices = sorted(
        map(pydicom.dcmread, series.iterdir()), key=lambda one: np.dot(one.ImagePositionPatient, np.cross(*along))
    )
    found = segments.get_pixels_by_source_instance([one.SOPInstanceUID for one in slices], combine_segments=True)
    expected = np.searchsorted([0, 3, 7], LABELS)
    assert np.array_equal(found, expected)
    surface = load_surface(tmp_path / "a.seg.dcm", volume)
    assert np.array_equal(label_voxels(surface, volume.shape), expected)
    assert surface.labels == (replace(NAMES[0], number=1), replace(NAMES[1], number=2))


def test_of_two_series_at_one_place_segments_refer_to_the_one_that_was_opened(tmp_path):
    pytest.importorskip("highdicom")
    series = write_series(tmp_path / "series", HEIGHTS, **HEADER)
    uid = generate_uid(entropy_srcs=["after contrast"])
    for path in write_series(tmp_path / "other", HEIGHTS, values=VALUES + 5, SeriesInstanceUID=uid, **HEADER).iterdir():
        path.rename(series / f"after {path.name}")
    for number in (1, 2):
        volume = load_volume(series, series=number)
        export(found_in(volume), tmp_path / "a.seg.dcm", image=series)
        (referred,) = pydicom.dcmread(tmp_path / "a.seg.dcm").ReferencedSeriesSequence
        assert (referred.SeriesInstanceUID == uid) == np.array_equal(volume.values, VALUES + 5)


def test_what_is_no_series_cannot_be_referred_to(tmp_path):
    pytest.importorskip("highdicom")
    write_nifti(tmp_path / "a.nii")
    volume = load_volume(tmp_path / "a.nii")
    with pytest.raises(ValueError, match=r"a\.nii is no DICOM series"):
        export(found_in(volume), tmp_path / "a.seg.dcm", image=tmp_path / "a.nii")


def test_a_series_without_what_a_segmentation_needs_is_called_that(tmp_path):
    pytest.importorskip("highdicom")
    series = write_series(tmp_path / "series", HEIGHTS)
    with pytest.raises(ValueError, match="series lacks what a segmentation refers to"):
        export(found_in(load_volume(series)), tmp_path / "a.seg.dcm", image=series)


def test_without_the_package_the_sentence_names_it(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "highdicom", None)
    series = write_series(tmp_path / "series", HEIGHTS)
    with pytest.raises(ValueError, match="run pip install highdicom"):
        export(found_in(load_volume(series)), tmp_path / "a.seg.dcm", image=series)


def written(path, frames, kind="BINARY"):
    """A segmentation whose frames are (number of a segment, position, pixels)."""
    pixels = np.stack([mask for _, _, mask in frames])
    found = dataset(pixels.astype(np.uint8), along=ACROSS, SOPClassUID=SegmentationStorage)
    found.Modality, found.SegmentationType, found.NumberOfFrames = "SEG", kind, len(frames)
    found.file_meta.MediaStorageSOPClassUID = SegmentationStorage
    if kind == "BINARY":
        found.BitsAllocated = found.BitsStored = 1
        found.HighBit = 0
        bits = np.packbits(pixels.ravel() > 0, bitorder="little").tobytes()
        found.PixelData = bits + bytes(len(bits) % 2)
    else:
        found.MaximumFractionalValue = 200
    found.SegmentSequence = []
    for number in (1, 2):
        segment = Dataset()
        segment.SegmentNumber, segment.SegmentLabel = number, f"segment {number}"
        found.SegmentSequence.append(segment)
    found.PerFrameFunctionalGroupsSequence = []
    for number, position, _ in frames:
        group, place, identity = Dataset(), Dataset(), Dataset()
        place.ImagePositionPatient, identity.ReferencedSegmentNumber = list(position), number
        group.PlanePositionSequence, group.SegmentIdentificationSequence = [place], [identity]
        found.PerFrameFunctionalGroupsSequence.append(group)
    del found.ImagePositionPatient
    found.save_as(path, enforce_file_format=True)


@pytest.mark.parametrize("kind", ["BINARY", "FRACTIONAL"])
def test_frames_of_overlapping_segments_lie_in_any_order_and_may_be_cropped(tmp_path, kind):
    series = write_series(tmp_path / "series", HEIGHTS, **HEADER)
    volume = load_volume(series)
    masks = {1: LABELS == 3, 2: LABELS > 0}
    frames = [
        (number, (-20.0 + 2 * 0.5, 10.0 + 1 * 0.75, 5.0 + HEIGHTS[plane]), 200 * mask[plane, 1:-1, 2:-1])
        for plane in reversed(range(10))
        for number, mask in masks.items()
        if mask[plane].any()
    ]
    written(tmp_path / "a.dcm", frames, kind)
    surface = load_surface(tmp_path / "a.dcm", volume)
    assert [label.name for label in surface.labels] == ["segment 1", "segment 2"]
    for number, mask in masks.items():
        alone = replace(surface, faces=surface.faces[surface.numbers == number], numbers=None)
        assert np.array_equal(label_voxels(alone, volume.shape) > 0, mask)
    assert np.array_equal(load_volume_truth(tmp_path / "a.dcm", volume).labels, 2 * (LABELS > 0))  # the last one has it


def test_segments_of_another_series_and_without_one_are_refused(tmp_path):
    series = write_series(tmp_path / "series", HEIGHTS, **HEADER)
    written(tmp_path / "a.dcm", [(1, (-20.0, 10.0, 6.0), 200 * (LABELS[3] > 0))])
    with pytest.raises(ValueError, match="lies elsewhere in space"):
        load_surface(tmp_path / "a.dcm", load_volume(series))
    with pytest.raises(ValueError, match="name it with --image"):
        load_surface(tmp_path / "a.dcm")
