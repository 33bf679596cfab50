"""Whole slides in DICOM: levels of tiles in files of their own, in full grids or only where there is something."""

import numpy as np
import pytest
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.encaps import encapsulate
from pydicom.uid import ExplicitVRLittleEndian, JPEG2000Lossless, generate_uid

from cpm_core import load_image
from cpm_core.chunked.grid import ChunkedSource
from cpm_core.formats.images import stack
from cpm_core.formats.images.reading import Reading

SHAPE = (230, 310)
COLORS = np.random.default_rng(1).integers(0, 256, (*SHAPE, 3), np.uint8)
LUMINANCE = COLORS @ [0.2125, 0.7154, 0.0721]
WHOLE_SLIDE = "1.2.840.10008.5.1.4.1.1.77.1.6"
TILE = (64, 48)


def item(**entries):
    found = Dataset()
    for name, value in entries.items():
        setattr(found, name, value)
    return found


def write_level(path, pixels, side=0.5, series="1.2.3", kind="VOLUME", sparse=None, packed=False, paths=1, **changes):
    """Write the tiles of pixels, shape (H, W[, 3]), or of several optical paths; `sparse` tells which of them."""
    layers = pixels if paths > 1 else pixels[None]
    rows, cols = layers.shape[1:3]
    tiles, places = [], []
    for layer in range(paths):
        for top in range(0, rows, TILE[0]):
            for left in range(0, cols, TILE[1]):
                part = layers[layer, top : top + TILE[0], left : left + TILE[1]]
                tile = np.full((*TILE, *layers.shape[3:]), 7, pixels.dtype)
                tile[: part.shape[0], : part.shape[1]] = part
                if sparse is None or sparse(top, left):
                    tiles.append(tile)
                    places.append((layer, top, left))
    colored = layers.ndim == 4
    file = Dataset()
    file.file_meta = FileMetaDataset()
    file.file_meta.TransferSyntaxUID = JPEG2000Lossless if packed else ExplicitVRLittleEndian
    file.file_meta.MediaStorageSOPClassUID = file.SOPClassUID = WHOLE_SLIDE
    file.file_meta.MediaStorageSOPInstanceUID = file.SOPInstanceUID = generate_uid()
    file.SeriesInstanceUID, file.StudyInstanceUID, file.SeriesDescription, file.Modality = series, "1.2", series, "SM"
    file.FrameOfReferenceUID = "1.2.9"
    file.ImageType = ["DERIVED", "PRIMARY", kind, "NONE"]
    file.Rows, file.Columns = TILE
    file.TotalPixelMatrixRows, file.TotalPixelMatrixColumns = rows, cols
    file.TotalPixelMatrixOriginSequence = [item(XOffsetInSlideCoordinateSystem=1, YOffsetInSlideCoordinateSystem=2)]
    file.ImageOrientationSlide = [0, -1, 0, -1, 0, 0]
    file.DimensionOrganizationType = "TILED_FULL" if sparse is None else "TILED_SPARSE"
    file.NumberOfFrames, file.NumberOfOpticalPaths, file.TotalPixelMatrixFocalPlanes = len(tiles), paths, 1
    file.OpticalPathSequence = [item(OpticalPathIdentifier=str(number)) for number in range(paths)]
    measures = item(PixelSpacing=[side / 1000, side / 1000], SliceThickness=0.001)
    file.SharedFunctionalGroupsSequence = [item(PixelMeasuresSequence=[measures])]
    if sparse is not None:
        file.PerFrameFunctionalGroupsSequence = [
            item(
                PlanePositionSlideSequence=[
                    item(
                        RowPositionInTotalImagePixelMatrix=top + 1,
                        ColumnPositionInTotalImagePixelMatrix=left + 1,
                        XOffsetInSlideCoordinateSystem=0,
                        YOffsetInSlideCoordinateSystem=0,
                        ZOffsetInSlideCoordinateSystem=0,
                    )
                ],
                OpticalPathIdentificationSequence=[item(OpticalPathIdentifier=str(layer))],
            )
            for layer, top, left in places
        ]
    file.SamplesPerPixel = 3 if colored else 1
    file.PhotometricInterpretation = "RGB" if colored else "MONOCHROME2"
    if colored:
        file.PlanarConfiguration = 0
    file.BitsAllocated = file.BitsStored = 8 * pixels.dtype.itemsize
    file.HighBit, file.PixelRepresentation = file.BitsStored - 1, 0
    if packed:
        imagecodecs = pytest.importorskip("imagecodecs")
        file.PixelData = encapsulate([imagecodecs.jpeg2k_encode(tile, level=0, codecformat="j2k") for tile in tiles])
        file["PixelData"].is_undefined_length = True
    else:
        content = np.stack(tiles).tobytes()
        file.PixelData = content + b"\0" * (len(content) % 2)
        file["PixelData"].VR = "OB" if pixels.dtype.itemsize == 1 else "OW"
    for name, value in changes.items():
        setattr(file, name, value)
    file.save_as(path, enforce_file_format=True)


@pytest.mark.parametrize("packed", [False, True])
def test_a_level_is_the_image_that_its_tiles_make_up(tmp_path, packed):
    write_level(tmp_path / "a.dcm", COLORS, packed=packed)
    slide = load_image(tmp_path / "a.dcm")
    assert np.array_equal(slide.colors.samples, COLORS)
    assert (slide.spacing, slide.unit) == (pytest.approx((0.5, 0.5)), "µm")
    other = pytest.importorskip("highdicom").imread(tmp_path / "a.dcm")
    assert np.array_equal(other.get_total_pixel_matrix(apply_icc_profile=False), slide.colors.samples)


def test_where_no_tile_lies_a_slide_is_white(tmp_path):
    write_level(tmp_path / "a.dcm", COLORS, sparse=lambda top, left: (top + left) % 5)
    slide = load_image(tmp_path / "a.dcm").colors.samples
    for top in range(0, SHAPE[0], TILE[0]):
        for left in range(0, SHAPE[1], TILE[1]):
            here = np.s_[top : top + TILE[0], left : left + TILE[1]]
            wanted = COLORS[here] if (top + left) % 5 else 255
            assert (slide[here] == wanted).all()


def test_optical_paths_are_channels(tmp_path):
    layers = np.random.default_rng(2).integers(0, 4000, (3, *SHAPE), np.uint16)
    for name, sparse in (("full", None), ("sparse", lambda *_: True)):
        write_level(tmp_path / f"{name}.dcm", layers, paths=3, sparse=sparse)
        for channel in (1, 3):
            assert np.array_equal(load_image(tmp_path / f"{name}.dcm", channel=channel).values, layers[channel - 1])


@pytest.fixture
def folder(tmp_path):
    """Three levels of a slide, its label, and one level of another one."""
    for step, name in ((1, "c"), (2, "a"), (4, "b")):
        write_level(tmp_path / f"{name}.dcm", COLORS[::step, ::step], side=0.5 * step)
    write_level(tmp_path / "label.dcm", COLORS[:70, :50], kind="LABEL")
    write_level(tmp_path / "other.dcm", COLORS[:90], series="1.2.4")
    return tmp_path


def test_a_folder_is_the_slide_whose_levels_lie_in_it(folder, monkeypatch):
    monkeypatch.setattr(stack, "MAXIMUM_PIXELS", 150**2)
    slide = load_image(folder)
    assert np.array_equal(slide.colors.samples, COLORS[::2, ::2][:115, :155])
    assert slide.spacing == pytest.approx((1.0, 1.0))
    assert any("of which level 1 was opened" in note for note in slide.notes)
    (finer,) = slide.finer
    np.testing.assert_allclose(finer[slice(100, 140), slice(3, 300)], LUMINANCE[100:140, 3:300], atol=0.51)
    assert load_image(folder, series="1.2.4").shape == (90, 310)


def test_a_file_is_its_level_and_the_coarser_ones(folder, monkeypatch):
    assert np.array_equal(load_image(folder / "a.dcm").colors.samples, COLORS[::2, ::2])
    assert load_image(folder / "label.dcm").shape == (70, 50)
    monkeypatch.setattr(stack, "MAXIMUM_PIXELS", 60 * 80)
    assert load_image(folder / "a.dcm").shape == (58, 78)


def test_chunks_of_a_slide_are_read_at_full_resolution(folder):
    source = ChunkedSource(folder / "c.dcm", Reading(color="green"))
    window = slice(50, 130), slice(40, 205)
    assert np.array_equal(source.read_grays(window), COLORS[..., 1][window])


def test_a_slide_whose_pixels_are_cut_is_called_damaged(tmp_path):
    write_level(tmp_path / "a.dcm", COLORS)
    content = (tmp_path / "a.dcm").read_bytes()
    (tmp_path / "a.dcm").write_bytes(content[: len(content) // 2])
    with pytest.raises(ValueError, match=r"a\.dcm is damaged"):
        load_image(tmp_path / "a.dcm")
