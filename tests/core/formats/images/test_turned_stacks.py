"""Stacks whose pages lie on their side, count from white to black, or stand in other files."""

import struct
import uuid

import numpy as np
import PIL.Image
import pytest
import tifffile

from cpm_core import load_image, load_pages, load_volume

PIXELS = (np.arange(9 * 12 * 20) * 29 % 60_000).reshape(9, 12, 20).astype(np.uint16)
TURNS = {
    1: lambda page: page,
    2: lambda page: page[:, ::-1],
    3: lambda page: page[::-1, ::-1],
    4: lambda page: page[::-1],
    5: lambda page: page.T,
    6: lambda page: page.T[:, ::-1],
    7: lambda page: page.T[::-1, ::-1],
    8: lambda page: page.T[::-1],
}


def with_one_directory(path):
    """Leave but the first directory of a TIFF that ImageJ could have written, as ImageJ does with large ones."""
    with tifffile.TiffFile(path) as file:
        page = file.pages.first
        place, order = page.offset, file.byteorder
        count = len(page.tags)
    content = bytearray(path.read_bytes())
    struct.pack_into(order + "I", content, place + 2 + 12 * count, 0)
    path.write_bytes(content)
    with tifffile.TiffFile(path) as file:
        assert len(file.pages) == 1


def write(path, orientation, white, alone):
    tifffile.imwrite(
        path,
        PIXELS,
        imagej=True,
        photometric="miniswhite" if white else "minisblack",
        resolution=(4, 2),
        metadata={"axes": "ZYX", "unit": "um"},
        extratags=[(274, "H", 1, orientation, False)],
    )
    if alone:
        with_one_directory(path)


@pytest.mark.parametrize("alone", [False, True])
@pytest.mark.parametrize("white", [False, True])
@pytest.mark.parametrize("orientation", [1, 2, 6, 7])
def test_each_page_is_turned_and_inverted_as_the_first_one(tmp_path, orientation, white, alone):
    path = tmp_path / "a.tif"
    write(path, orientation, white, alone)
    expected = np.stack([TURNS[orientation](65535.0 - page if white else page) for page in PIXELS])
    spacing = (0.5, 0.25) if orientation < 5 else (0.25, 0.5)
    pages, volume = load_pages(path), load_volume(path)
    assert np.array_equal(volume.values, expected)
    assert volume.spacing[1:] == pytest.approx(spacing)
    for number in (1, 3, 9):
        image = load_image(path, page=number)
        assert np.array_equal(image.values, expected[number - 1])
        assert image.spacing == pytest.approx(spacing)
        assert np.array_equal(pages[number - 1].values, image.values)
    first = load_image(path)
    assert np.array_equal(first.values, expected[0])
    assert first.spacing == pytest.approx(spacing)


@pytest.mark.parametrize("compression", ["none", "tiff_lzw", "jpeg"])
def test_pages_in_other_files_are_those_of_their_files(tmp_path, compression):
    pages = [(np.add.outer(np.arange(16) * (index + 1), np.arange(24))).astype(np.uint8) for index in range(9)]
    names = [uuid.uuid4() for _ in pages]
    places = "".join(
        f'<TiffData FirstZ="{index}" IFD="0"><UUID FileName="{index}.ome.tif">urn:uuid:{name}</UUID></TiffData>'
        for index, name in enumerate(names)
    )
    for index, (page, name) in enumerate(zip(pages, names, strict=True)):
        ome = (
            f'<OME xmlns="http://www.openmicroscopy.org/Schemas/OME/2016-06" UUID="urn:uuid:{name}">'
            '<Image ID="Image:0"><Pixels ID="Pixels:0" DimensionOrder="XYZCT" Type="uint8" SizeX="24" SizeY="16" '
            'SizeZ="9" SizeC="1" SizeT="1">'
            f'<Channel ID="Channel:0:0" SamplesPerPixel="1"/>{places}</Pixels></Image></OME>'
        )
        picture = PIL.Image.fromarray(page)
        picture.save(tmp_path / f"{index}.ome.tif", compression=None if compression == "none" else compression,
                     tiffinfo={270: ome})  # fmt: skip
    volume = load_volume(tmp_path / "0.ome.tif")
    assert np.abs(volume.values - np.stack(pages)).max() <= (4 if compression == "jpeg" else 0)
    fourth = load_image(tmp_path / "0.ome.tif", page=4)
    assert np.array_equal(fourth.values, volume.values[3])


def test_a_page_without_any_data_is_left_out_of_its_volume(tmp_path):
    values = np.add.outer(np.zeros(9), np.add.outer(np.arange(12.0), np.arange(20.0))).astype(np.float32)
    values[4], values[:, :3] = -9999.0, -9999.0
    told = [(42113, "s", 0, "-9999", False)]
    tifffile.imwrite(tmp_path / "a.tif", values, photometric="minisblack", extratags=told)
    volume = load_volume(tmp_path / "a.tif")
    assert volume.values.min() >= 0.0
    assert any("have no data" in note for note in volume.notes)
    page = load_image(tmp_path / "a.tif", page=5)
    assert np.ptp(page.values) == 0.0
    assert [note.startswith("240 pixels ") for note in page.notes] == [True]
