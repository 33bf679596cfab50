"""MetaImage: values, sizes and place as ITK writes them."""

import numpy as np
import pytest

from cpm_core import load_image, load_volume

from .made import VALUES, affine, write_metaimage


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("beside", [None, "a.raw"])
def test_values_sizes_and_place_are_those_of_the_header(tmp_path, packed, beside):
    write_metaimage(tmp_path / "a.mha", packed=packed, beside=beside)
    volume = load_volume(tmp_path / "a.mha")
    assert np.array_equal(volume.values, VALUES)
    assert volume.spacing == pytest.approx((2.0, 0.75, 0.5))
    np.testing.assert_allclose(volume.geometry.affine(volume.spacing)[:, [2, 1, 0, 3]], affine(), atol=1e-12)
    assert (volume.unit, volume.geometry.convention, volume.notes) == ("mm", "LPS", ())
    assert np.array_equal(load_image(tmp_path / "a.mha", page=10).values, VALUES[9])


def test_the_order_of_bytes_and_a_head_of_the_values_are_heeded(tmp_path):
    write_metaimage(tmp_path / "a.mhd", beside="a.raw", BinaryDataByteOrderMSB="True", HeaderSize=-1)
    (tmp_path / "a.raw").write_bytes(b"head of any length" + VALUES.astype(">i2").tobytes())
    assert np.array_equal(load_volume(tmp_path / "a.mhd").values, VALUES)


@pytest.mark.parametrize("beside", [None, "a.raw"])
@pytest.mark.parametrize("false", ["False", "0"])
@pytest.mark.parametrize("kind", [np.int16, np.float32])
def test_values_may_be_text(tmp_path, kind, false, beside):
    values = VALUES.astype(kind) / kind(4) if kind is np.float32 else VALUES
    write_metaimage(tmp_path / "a.mhd", values, beside=beside, BinaryData=false)
    header = (tmp_path / "a.mhd").read_bytes()
    text = "\n".join(" ".join(map(str, row)) for row in values.reshape(-1, 14).tolist()).encode()
    if beside:
        (tmp_path / beside).write_bytes(text)
    else:
        (tmp_path / "a.mhd").write_bytes(header[: header.index(b"LOCAL") + 6] + text)
    volume = load_volume(tmp_path / "a.mhd")
    assert np.array_equal(volume.values, values)
    assert volume.spacing == pytest.approx((2.0, 0.75, 0.5))


def test_without_sizes_and_place_nothing_is_assumed(tmp_path):
    write_metaimage(tmp_path / "a.mha", TransformMatrix=None, Offset=None, ElementSpacing=None)
    volume = load_volume(tmp_path / "a.mha")
    assert (volume.spacing, volume.unit, volume.geometry) == ((1.0, 1.0, 1.0), None, None)


def test_channels_and_colors_are_told_apart(tmp_path):
    two = np.stack([VALUES, VALUES + 7], -1)
    write_metaimage(tmp_path / "a.mha", two, ElementNumberOfChannels=2)
    assert np.array_equal(load_volume(tmp_path / "a.mha", channel=2).values, VALUES + 7)
    colors = np.stack([VALUES % 40, VALUES % 200, VALUES % 90], -1).astype(np.uint8)
    write_metaimage(tmp_path / "b.mha", colors, ElementNumberOfChannels=3)
    assert np.allclose(load_volume(tmp_path / "b.mha").values, colors @ (0.2125, 0.7154, 0.0721))


@pytest.mark.parametrize(
    ("entries", "words"),
    [
        ({"DimSize": "14 12 11"}, "is damaged"),
        ({"DimSize": "14 12 -10"}, "is damaged"),
        ({"NDims": 4}, "has 3 axes"),
        ({"ElementType": "MET_STRANGE"}, "is damaged"),
        ({"beside": "/dev/zero"}, "is not a single file next to it"),
        ({"beside": "../a.raw"}, "is not a single file next to it"),
        ({"beside": "LIST"}, "is not a single file next to it"),
        ({"beside": "slice%03d.raw"}, "is not a single file next to it"),
    ],
)
def test_what_cannot_be_read_is_said_in_one_sentence(tmp_path, entries, words):
    beside = entries.pop("beside", None)
    write_metaimage(tmp_path / "a.mha", **entries)
    if beside:
        content = (tmp_path / "a.mha").read_bytes()
        (tmp_path / "a.mha").write_bytes(content.replace(b"LOCAL", beside.encode()))
        entries["beside"] = beside
    with pytest.raises(ValueError, match=words) as caught:
        load_volume(tmp_path / "a.mha")
    assert "\n" not in str(caught.value)


def test_a_packed_file_cut_short_is_refused(tmp_path):
    write_metaimage(tmp_path / "a.mha", packed=True)
    content = (tmp_path / "a.mha").read_bytes()
    (tmp_path / "a.mha").write_bytes(content[:-100])
    with pytest.raises(ValueError, match="is damaged"):
        load_volume(tmp_path / "a.mha")
