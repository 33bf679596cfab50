"""Stacks of pictures: pages of TIFF with channels and times, frames, arrays, and what is chosen of them."""

import json

import numpy as np
import PIL.Image
import pytest
import tifffile

from cpm_core import load_image, load_volume
from cpm_core.formats.images.readers import open_stack
from cpm_core.formats.images.reading import Reading

from .made import VALUES

PIXELS = (VALUES + 500).astype(np.uint16)
BYTES = (VALUES % 251).astype(np.uint8)
HYPER = np.stack([[PIXELS + 100 * time + channel for channel in range(2)] for time in range(3)]).transpose(
    0, 2, 1, 3, 4
)
"""Axes TZCYX, the order of ImageJ."""


def imagej(path):
    metadata = {"axes": "TZCYX", "spacing": 3.0, "unit": "um"}
    tifffile.imwrite(path, HYPER, imagej=True, resolution=(4, 2), metadata=metadata)


def ome(path, axes="TCZYX"):
    sizes = {"PhysicalSizeX": 250.0, "PhysicalSizeXUnit": "nm", "PhysicalSizeY": 500.0, "PhysicalSizeYUnit": "nm"}
    metadata = {"axes": axes, "PhysicalSizeZ": 3.0, "PhysicalSizeZUnit": "µm", **sizes}
    tifffile.imwrite(path, HYPER.transpose(["TZCYX".index(axis) for axis in axes]), ome=True, metadata=metadata)


@pytest.mark.parametrize("write", [imagej, ome, lambda path: ome(path, "CTZYX"), lambda path: ome(path, "ZTCYX")])
def test_hyperstacks_give_every_channel_and_time_with_sizes(tmp_path, write):
    path = tmp_path / "a.ome.tif"
    write(path)
    volume = load_volume(path, time=2, channel=2)
    assert np.array_equal(volume.values, PIXELS + 101)
    known = (3.0, 0.5, 0.25) if volume.unit == "µm" else (3000.0, 500.0, 250.0)
    assert volume.spacing == pytest.approx(known)
    assert volume.notes == ()
    first = load_volume(path)
    assert np.array_equal(first.values, PIXELS)
    assert first.notes == ("Only the first of its 2 channels was taken.",
                           "Only the first of its 3 points in time was taken.")  # fmt: skip
    image = load_image(path, page=4, time=3)
    assert np.array_equal(image.values, PIXELS[3] + 200)
    assert image.spacing == pytest.approx(known[1:])
    assert image.notes == first.notes[:1]


@pytest.mark.parametrize("options", [{}, {"compression": "zlib"}, {"byteorder": ">"}, {"tile": (16, 16)}])
def test_pages_without_a_meaning_are_planes(tmp_path, options):
    tifffile.imwrite(tmp_path / "a.tif", PIXELS, photometric="minisblack", **options)
    volume = load_volume(tmp_path / "a.tif")
    assert np.array_equal(volume.values, PIXELS)
    assert (volume.spacing, volume.unit, volume.notes) == ((1.0, 1.0, 1.0), None, ())
    assert np.array_equal(load_image(tmp_path / "a.tif", page=10).values, PIXELS[9])
    with pytest.raises(ValueError, match=r"page is 11, but a\.tif has 10 of them: choose 1 to 10"):
        load_image(tmp_path / "a.tif", page=11)


def test_a_volume_in_one_page_and_a_stack_of_colors_are_read(tmp_path):
    values = np.zeros((16, 16, 16), np.uint8)
    values[3:9, 4:12] = 200
    tifffile.imwrite(tmp_path / "a.tif", values, volumetric=True, tile=(16, 16, 16), photometric="minisblack")
    assert np.array_equal(load_volume(tmp_path / "a.tif").values, values)
    colors = np.stack([BYTES, BYTES[::-1], 255 - BYTES], -1)
    tifffile.imwrite(tmp_path / "b.tif", colors, photometric="rgb")
    volume = load_volume(tmp_path / "b.tif")
    assert np.allclose(volume.values, colors @ (0.2125, 0.7154, 0.0721))
    assert np.array_equal(volume.colors.samples, colors)
    assert ["luminance" in note for note in volume.notes] == [True]
    assert np.array_equal(load_volume(tmp_path / "b.tif", color="red").values, BYTES)


def test_pages_of_several_sizes_are_several_series(tmp_path):
    with tifffile.TiffWriter(tmp_path / "a.tif") as writer:
        writer.write(PIXELS, photometric="minisblack")
        writer.write(PIXELS[:, :9] + 1, photometric="minisblack")
    assert load_volume(tmp_path / "a.tif").notes == ("Only the first of its 2 series was taken.",)
    assert np.array_equal(load_volume(tmp_path / "a.tif", series=2).values, PIXELS[:, :9] + 1)


@pytest.mark.parametrize("size", [{}, {"unit": "um"}])
def test_pages_of_a_film_become_planes_and_it_is_said(tmp_path, size):
    resolution = (2.0, 2.0) if size else None
    tifffile.imwrite(tmp_path / "a.tif", PIXELS, imagej=True, resolution=resolution, metadata={"axes": "TYX", **size})
    volume = load_volume(tmp_path / "a.tif")
    assert np.array_equal(volume.values, PIXELS)
    assert volume.notes == ("Its 10 pages, which are points in time, were taken as planes.",)
    assert np.array_equal(load_image(tmp_path / "a.tif", page=4).values, PIXELS[3])


@pytest.mark.parametrize("kind", ["gif", "png", "webp"])
def test_frames_of_animations_are_points_in_time(tmp_path, kind):
    pages = [PIL.Image.fromarray(plane) for plane in BYTES]
    options = {"lossless": True} if kind == "webp" else {}
    pages[0].save(tmp_path / f"a.{kind}", save_all=True, append_images=pages[1:], **options)
    image = load_image(tmp_path / f"a.{kind}", page=4)
    assert np.array_equal(image.values, BYTES[3])
    assert image.notes == load_image(tmp_path / f"a.{kind}", time=4).notes
    volume = load_volume(tmp_path / f"a.{kind}")
    assert np.array_equal(volume.values, BYTES)
    assert volume.notes[0] == "Its 10 frames, which are points in time, were taken as planes."
    with pytest.raises(ValueError, match="page is 11"):
        load_image(tmp_path / f"a.{kind}", page=11)


def test_a_picture_that_stands_still_is_no_volume(tmp_path):
    PIL.Image.fromarray(BYTES[0]).save(tmp_path / "a.png", dpi=(25400, 25400))
    with pytest.raises(ValueError, match=r"a\.png has the shape \(12, 14\)"):
        load_volume(tmp_path / "a.png")
    image = load_image(tmp_path / "a.png", page=1)
    assert (image.spacing, image.unit) == (pytest.approx((1.0, 1.0), rel=1e-3), "µm")
    assert image.notes == ()


def test_of_an_array_of_three_axes_the_middle_plane_is_an_image(tmp_path):
    np.save(tmp_path / "a.npy", VALUES)
    image = load_image(tmp_path / "a.npy")
    assert np.array_equal(image.values, VALUES[5])
    assert image.notes == ("It is a volume, of which plane 6 of 10 was taken.",)
    assert np.array_equal(load_volume(tmp_path / "a.npy").values, VALUES)


def test_of_an_archive_the_only_image_is_taken_or_the_one_that_is_named(tmp_path):
    np.savez(tmp_path / "a.npz", volume=VALUES, spacing=np.ones(3), note="what it is")
    assert np.array_equal(load_volume(tmp_path / "a.npz").values, VALUES)
    np.savez_compressed(tmp_path / "b.npz", brain=VALUES > 0, skull=VALUES)
    with pytest.raises(ValueError, match=r"b\.npz holds 2 images and volumes, of 2 arrays: choose one by series"):
        load_volume(tmp_path / "b.npz")
    for chosen in ("skull", 2):
        assert np.array_equal(load_volume(tmp_path / "b.npz", series=chosen).values, VALUES)
    assert np.array_equal(load_image(tmp_path / "b.npz", series="brain", page=1).values, VALUES[0] > 0)
    with pytest.raises(ValueError, match='series is "bone", but b.npz has "brain", "skull"'):  # noqa: RUF043
        load_volume(tmp_path / "b.npz", series="bone")


@pytest.mark.parametrize("load", [load_image, load_volume])
def test_sizes_are_set_by_hand_where_a_file_does_not_tell(tmp_path, load):
    np.save(tmp_path / "a.npy", VALUES)
    axes = 3 if load is load_volume else 2
    found = load(tmp_path / "a.npy", spacing=0.25, unit="um")
    assert (found.spacing, found.unit) == ((0.25,) * axes, "µm")
    found = load(tmp_path / "a.npy", spacing=(2.0, 0.5, 0.25)[-axes:], unit="mm")
    assert (found.spacing, found.unit) == ((2.0, 0.5, 0.25)[-axes:], "mm")
    for given, words in (
        ({"spacing": (1.0,) * 4, "unit": "mm"}, "The spacing of a.npy"),
        ({"spacing": 0.0}, "must be"),
        ({"spacing": 1.0, "unit": "feet"}, 'unit is "feet" but must be nm, µm, mm, cm or m'),
        ({"unit": "mm"}, "there is no spacing"),
        ({"color": "gray"}, 'color is "gray" but must be one of'),
        ({"time": 0}, "time is 0 but must be a whole number from 1 up"),
        ({"channel": "red"}, 'channel is "red" but must be a whole number'),
        ({"series": 1.5}, "series is 1.5 but must be a whole number"),
    ):
        with pytest.raises(ValueError, match=words):
            load(tmp_path / "a.npy", **given)


def test_a_volume_larger_than_memory_is_refused_before_it_is_read(tmp_path, monkeypatch):
    np.save(tmp_path / "a.npy", VALUES)
    monkeypatch.setattr("cpm_core.numerics.memory.available_memory", lambda: 1000.0)
    with pytest.raises(ValueError, match=r"a\.npy has 10 × 12 × 14 px, which need .* make it smaller"):
        load_volume(tmp_path / "a.npy")
    assert load_image(tmp_path / "a.npy").shape == (12, 14)


@pytest.mark.parametrize("kind", [np.int64, np.uint8])
def test_a_part_is_chosen_by_numbers_of_numpy_as_well(tmp_path, kind):
    imagej(tmp_path / "a.tif")
    chosen = load_image(tmp_path / "a.tif", page=kind(4), time=kind(3), channel=kind(2))
    assert np.array_equal(chosen.values, PIXELS[3] + 201)
    assert np.array_equal(load_volume(tmp_path / "a.tif", time=kind(2)).values, PIXELS + 100)
    reading = Reading(page=kind(2), spacing=(np.float32(0.5), kind(2)), unit="mm")
    assert json.loads(json.dumps(reading.arguments)) == {"page": 2, "spacing": [0.5, 2.0], "unit": "mm"}


@pytest.mark.parametrize("sides", [(10, 7), BYTES.shape[1:][::-1]])
def test_what_a_phone_adds_to_a_photo_is_no_frame(tmp_path, sides):
    more = PIL.Image.new("L", sides, 90)
    PIL.Image.fromarray(BYTES[0]).save(tmp_path / "a.jpg", format="MPO", save_all=True, append_images=[more])
    image = load_image(tmp_path / "a.jpg")
    assert (image.shape, image.notes) == (BYTES.shape[1:], ())
    with pytest.raises(ValueError, match="has 1 of them"):
        load_image(tmp_path / "a.jpg", page=2)


@pytest.mark.parametrize("kept", [0.5, 0.9])
def test_a_stack_of_imagej_with_fewer_images_than_it_says_is_no_single_image(tmp_path, kept):
    tifffile.imwrite(tmp_path / "a.tif", np.zeros((10, 20, 30), np.uint16), imagej=True, metadata={"axes": "ZYX"})
    content = (tmp_path / "a.tif").read_bytes()
    assert load_volume(tmp_path / "a.tif").shape == (10, 20, 30)
    (tmp_path / "a.tif").write_bytes(content[: int(kept * len(content))])
    with pytest.raises(ValueError, match=r"a\.tif is damaged or cut short"):
        load_image(tmp_path / "a.tif")


def test_channels_have_the_names_and_colors_that_ome_and_imagej_state(tmp_path):
    planes, path = PIXELS[:3], tmp_path / "a.ome.tif"
    stated = {"Name": ["DAPI", "GFP", ""], "Color": [0x0000FFFF, -16776961, -1]}  # the last byte is the opacity
    tifffile.imwrite(path, planes, photometric="minisblack", metadata={"axes": "CYX", "Channel": stated})
    assert open_stack(path).channel_styles == (("DAPI", "#0000ff"), ("GFP", "#ff0000"), ("", "#ffffff"))
    stated = {"Name": ["Fluorescence", "Ch2", "Brightfield"]}
    stated["ContrastMethod"] = ["Fluorescence", "Fluorescence", "Brightfield"]
    tifffile.imwrite(path, planes, photometric="minisblack", metadata={"axes": "CYX", "Channel": stated})
    assert [name for name, _ in open_stack(path).channel_styles] == ["Fluorescence", "Ch2", "Brightfield"]
    tables = [np.outer(color, np.arange(256)).astype(np.uint8) for color in ((0, 1, 1), (1, 0, 1), (1, 1, 1))]
    tables[2] = tables[2][:, ::-1]  # inverted
    metadata = {"axes": "CYX", "mode": "composite", "LUTs": tables, "Ranges": (1.0, 99.0, 2.0, 98.0, 3.0, 97.0)}
    tifffile.imwrite(tmp_path / "b.tif", planes, imagej=True, metadata=metadata)
    assert open_stack(tmp_path / "b.tif").channel_styles == (("", "#00ffff"), ("", "#ff00ff"), ("", "#ffffff"))
    assert [load_image(tmp_path / "b.tif", channel=channel).window for channel in (1, 3)] == [(1.0, 99.0), (3.0, 97.0)]
    imagej(tmp_path / "c.tif")
    assert open_stack(tmp_path / "c.tif").channel_styles == () and load_image(tmp_path / "c.tif").window is None


def test_a_label_of_imagej_that_all_planes_of_a_channel_have_is_its_name(tmp_path):
    planes = PIXELS[:6].reshape(2, 3, *PIXELS.shape[1:])
    stacks = {"named": ["DAPI", "c:2 z:1", "GFP", "DAPI", "c:2 z:2", "GFP"], "plain": ["z:1"] * 3 + ["z:2"] * 3}
    for name, labels in stacks.items():
        metadata = {"axes": "ZCYX", "Labels": labels}
        tifffile.imwrite(tmp_path / f"{name}.tif", planes, imagej=True, metadata=metadata)
    assert open_stack(tmp_path / "named.tif").channel_styles == (("DAPI", ""), ("", ""), ("GFP", ""))
    assert open_stack(tmp_path / "plain.tif").channel_styles == ()


def test_of_ranges_of_imagej_only_whole_ones_count(tmp_path):
    metadata = {"axes": "CYX", "Ranges": (1.0, 99.0, 2.0)}
    tifffile.imwrite(tmp_path / "a.tif", PIXELS[:3], imagej=True, metadata=metadata)
    windows = [load_image(tmp_path / "a.tif", channel=channel).window for channel in (1, 2, 3)]
    assert windows == [(1.0, 99.0), None, None]
