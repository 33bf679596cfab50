"""Files of microscopes: each axis gets its role, whatever its letter and place, and each side its size."""

import itertools
import struct
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from cpm_core import load_image, load_pages, load_volume
from cpm_core.formats import open_stack
from cpm_core.formats.images import microscopy

SIZES = {"T": 2, "C": 3, "Z": 9, "Y": 10, "X": 12}
VALUES = (np.arange(np.prod(list(SIZES.values()))) * 7 % 60_000).astype(np.uint16).reshape(tuple(SIZES.values()))
STEPS = {"Z": 2e-6, "Y": 0.5e-6, "X": 0.25e-6}


def pack_segment(kind, content):
    """A segment of a CZI, which begins at a multiple of 32 bytes."""
    content += bytes(-len(content) % 32)
    return struct.pack("<16s2q", kind, len(content), len(content)) + content


def write_czi(path, values=VALUES, axes="TCZYX", begin=0):
    """A CZI of a plane in each of its subblocks, as in the format by Zeiss, with axes that begin at a number."""
    pytest.importorskip("czifile")
    outer = [dict(zip(axes[:-2], at, strict=True)) for at in itertools.product(*map(range, values.shape[:-2]))]
    blocks, entries, place = [], [], 544
    for at in outer:
        sizes = {"X": values.shape[-1], "Y": values.shape[-2], **dict.fromkeys(at, 1)}
        entry = struct.pack("<2siqii6xi", b"DV", 1, place, 0, 0, len(sizes))
        for axis, size in sizes.items():
            start = at[axis] + begin if axis in at else 0
            entry += struct.pack("<4siifi", axis.encode(), start, size, float(start), size)
        pixels = np.ascontiguousarray(values[tuple(at.values())]).tobytes()
        head = struct.pack("<iiq", 0, 0, len(pixels)) + entry
        block = pack_segment(b"ZISRAWSUBBLOCK", head + bytes(max(0, 256 - len(head))) + pixels)
        blocks.append(block)
        entries.append(entry)
        place += len(block)
    directory = pack_segment(b"ZISRAWDIRECTORY", struct.pack("<i124x", len(entries)) + b"".join(entries))
    steps = "".join(f'<Distance Id="{axis}"><Value>{step}</Value></Distance>' for axis, step in STEPS.items())
    text = f"<ImageDocument><Metadata><Scaling><Items>{steps}</Items></Scaling></Metadata></ImageDocument>".encode()
    metadata = pack_segment(b"ZISRAWMETADATA", struct.pack("<ii248x", len(text), 0) + text)
    header = struct.pack("<4i32xiqqiq", 1, 0, 0, 0, 0, place, place + len(directory), 0, 0)
    path.write_bytes(
        pack_segment(b"ZISRAWFILE", header + bytes(512 - len(header))) + b"".join(blocks) + directory + metadata
    )


def write_lif(path, images):
    """A LIF of images by name, each with its values and the letters of its axes."""
    pytest.importorskip("liffile")
    numbers = {"X": 1, "Y": 2, "Z": 3, "T": 4}
    elements, blocks = "", b""
    for number, (name, (values, axes)) in enumerate(images.items()):
        stride, parts, steps = values.itemsize, "", [0]
        for axis, size in zip(axes[::-1], values.shape[::-1], strict=True):
            if axis == "C":
                steps = [stride * k for k in range(size)]
            else:
                length = STEPS.get(axis, 1.0) * (size - 1)
                parts += f'<DimensionDescription DimID="{numbers[axis]}" NumberOfElements="{size}" Origin="0" '
                parts += f'Length="{length}" Unit="m" BytesInc="{stride}" BitInc="0"/>'
            stride *= size
        channels = "".join(
            '<ChannelDescription DataType="0" ChannelTag="0" Resolution="16" NameOfMeasuredQuantity="" Min="0" Max="1" '
            f'Unit="" LUTName="" IsLUTInverted="0" BytesInc="{step}" BitInc="0"/>'
            for step in steps
        )
        elements += f'<Element Name="{name}"><Data><Image><ImageDescription><Channels>{channels}</Channels>'
        elements += f"<Dimensions>{parts}</Dimensions></ImageDescription></Image></Data>"
        elements += f'<Memory Size="{values.nbytes}" MemoryBlockID="MemBlock_{number}"/></Element>'
        block = f"MemBlock_{number}".encode("utf-16-le")
        head = struct.pack("<BqBi", 0x2A, values.nbytes, 0x2A, len(block) // 2) + block
        blocks += struct.pack("<ii", 0x70, len(head)) + head + values.tobytes()
    text = f'<LMSDataContainerHeader Version="2"><Element Name="a"><Children>{elements}</Children></Element>'
    content = (text + "</LMSDataContainerHeader>").encode("utf-16-le")
    head = struct.pack("<Bi", 0x2A, len(content) // 2) + content
    path.write_bytes(struct.pack("<ii", 0x70, len(head)) + head + blocks)


@pytest.mark.parametrize("begin", [0, 4])
@pytest.mark.parametrize("axes", ["TCZYX", "ZTCYX", "CZTYX"])
@pytest.mark.skipif(sys.version_info < (3, 12), reason="czifile reads scenes from Python 3.12 on")
def test_a_czi_has_its_planes_times_channels_and_sizes(tmp_path, axes, begin):
    values = VALUES.transpose(["TCZYX".index(axis) for axis in axes])
    write_czi(tmp_path / "a.czi", values, axes, begin)
    check_parts(tmp_path / "a.czi")


@pytest.mark.parametrize("axes", ["TZCYX", "TCZYX", "ZTCYX"])
def test_a_lif_has_its_planes_times_channels_and_sizes(tmp_path, axes):
    values = np.ascontiguousarray(VALUES.transpose(["TCZYX".index(axis) for axis in axes]))
    write_lif(tmp_path / "a.lif", {"cells": (values, axes)})
    check_parts(tmp_path / "a.lif")


def check_parts(path):
    volume = load_volume(path, time=2, channel=3)
    assert np.array_equal(volume.values, VALUES[1, 2])
    assert volume.spacing == pytest.approx((2.0, 0.5, 0.25))
    assert (volume.unit, volume.notes) == ("µm", ())
    plane = load_image(path, page=3)
    assert np.array_equal(plane.values, VALUES[0, 0, 2])
    assert [("2 points" in note, "3 channels" in note) for note in plane.notes] == [(True, False), (False, True)]
    assert len(load_pages(path)) == SIZES["Z"]


def test_the_images_of_a_lif_are_series_and_their_last_axes_in_space_rows_and_columns(tmp_path):
    across = VALUES[0, 0].transpose(1, 0, 2)  # y, z, x: planes across the second axis
    write_lif(tmp_path / "a.lif", {"xyz": (VALUES[0, 0], "ZYX"), "xzy": (np.ascontiguousarray(across), "YZX")})
    assert open_stack(tmp_path / "a.lif").series == ("xyz", "xzy")
    assert any("2 series" in note for note in load_volume(tmp_path / "a.lif").notes)
    volume = load_volume(tmp_path / "a.lif", series="xzy")
    assert np.array_equal(volume.values, across)
    assert volume.spacing == pytest.approx((0.5, 2.0, 0.25))
    with pytest.raises(ValueError, match=r'series is "xyt", but a\.lif has "xyz", "xzy"'):
        load_volume(tmp_path / "a.lif", series="xyt")


def test_a_damaged_file_is_called_that(tmp_path):
    write_lif(tmp_path / "a.lif", {"cells": (VALUES[0, 0], "ZYX")})
    (tmp_path / "b.lif").write_bytes((tmp_path / "a.lif").read_bytes()[:-500])
    with pytest.raises(ValueError, match=r"b\.lif is damaged"):
        load_volume(tmp_path / "b.lif")


def test_a_missing_package_is_named(tmp_path, monkeypatch):
    (tmp_path / "a.nd2").write_bytes(b"\xda\xce\xbe\x0a" + bytes(600))
    monkeypatch.setitem(sys.modules, "nd2", None)
    with pytest.raises(ValueError, match=r"a\.nd2 needs the package nd2, .* run pip install nd2\."):
        load_image(tmp_path / "a.nd2")


@pytest.mark.parametrize("calibrated", [True, False])
def test_positions_of_an_nd2_are_series(calibrated):
    values = np.stack([VALUES[0], VALUES[1]])
    volume = SimpleNamespace(axesCalibrated=(calibrated,) * 3, axesCalibration=(0.25, 0.5, 2.0))
    color = SimpleNamespace(as_hex=lambda: "#0000ff")
    dapi = SimpleNamespace(volume=volume, channel=SimpleNamespace(name="DAPI", color=color))
    metadata = SimpleNamespace(channels=[dapi])
    sizes = {"P": 2, "C": 3, "Z": 9, "Y": 10, "X": 12}
    file = SimpleNamespace(metadata=metadata, sizes=sizes, dtype=values.dtype, to_dask=lambda: values)
    first, second = microscopy._list_nd2_positions(file)
    assert first.channel_styles == (("DAPI", "#0000ff"),)
    assert first.steps == (pytest.approx(STEPS) if calibrated else {})
    assert np.array_equal(second.read_part({"C": 1, "Z": slice(2, 4)}), VALUES[1, 1, 2:4])
