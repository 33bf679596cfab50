"""Bad files of volumes: any file either loads or is refused in one sentence, and nothing else is said or left open."""

import gc
import gzip
import io
import re
import struct
import zipfile
import zlib

import numpy as np
import pytest
import tifffile

from cpm_core.formats.images.readers import load_volume

VOLUME = (np.indices((9, 10, 11)).sum(0) * 9 % 251).astype(np.uint8)


def refusal(path):
    """The sentence with which a volume is refused; fails when it is not, or not in one line."""
    with pytest.raises(ValueError, match=path.name) as caught:
        load_volume(path)
    text = str(caught.value)
    assert "\n" not in text
    assert text.endswith(".")
    return text


def nifti():
    nibabel = pytest.importorskip("nibabel")
    return bytearray(nibabel.Nifti1Image(VOLUME.T, np.eye(4)).to_bytes())


def archive(content):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr("volume.npy", content)
    return stream.getvalue()


def array(shape=VOLUME.shape):
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"descr": "|u1", "fortran_order": False, "shape": shape})
    return stream.getvalue() + VOLUME.tobytes()


def stack(**options):
    stream = io.BytesIO()
    tifffile.imwrite(stream, VOLUME, photometric="minisblack", **options)
    return stream.getvalue()


SOUND = {
    ".npy": array,
    ".npz": lambda: archive(array()),
    ".tif": stack,
    ".nii": nifti,
    ".nii.gz": lambda: gzip.compress(nifti(), mtime=0),
}


@pytest.mark.parametrize("suffix", SOUND)
def test_a_volume_cut_short_is_refused_in_one_line_and_closed(tmp_path, capfd, suffix):
    path = tmp_path / f"cut{suffix}"
    content = bytes(SOUND[suffix]())
    path.write_bytes(content)
    assert np.array_equal(load_volume(path).values, VOLUME)
    for share in (0.01, 0.3, 0.45, 0.95):
        path.write_bytes(content[: int(share * len(content))])
        refusal(path)
    gc.collect()  # what is left open warns now
    assert capfd.readouterr() == ("", "")


def test_a_packed_volume_whose_sum_is_wrong_is_damaged(tmp_path):
    content = bytearray(gzip.compress(nifti(), mtime=0))
    content[-8] ^= 1
    (tmp_path / "wrong.nii.gz").write_bytes(content)
    assert "is damaged" in refusal(tmp_path / "wrong.nii.gz")


def flipped(content, place):
    return bytes((*content[:place], content[place] ^ 0xFF, *content[place + 1 :]))


def nrrd(packed):
    content = VOLUME.tobytes()
    head = f"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 11 10 9\nencoding: {'gzip' if packed else 'raw'}\n\n"
    return head.encode() + (gzip.compress(content, mtime=0) if packed else content)


DAMAGES = {
    "nothing but the length of the header": lambda content: content[:4],
    "cut in the header": lambda content: content[: min(len(content) // 2, 40)],
    "cut in the values": lambda content: content[: len(content) * 9 // 10],
    "cut in the last bytes": lambda content: content[:-2],
    "another mark": lambda content: flipped(content, 344 if len(content) > 1300 else 0),
}


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.parametrize(
    ("name", "kind", "sound"),
    [
        ("a.nii", "NIfTI", lambda: bytes(nifti())),
        ("a.nii.gz", "NIfTI", lambda: gzip.compress(nifti(), mtime=0)),
        ("a.nrrd", "NRRD", lambda: nrrd(packed=False)),
        ("b.nrrd", "NRRD", lambda: nrrd(packed=True)),
    ],
)
def test_a_damaged_volume_is_called_what_it_is(tmp_path, damage, name, kind, sound):
    if name == "b.nrrd" and damage == "cut in the last bytes":
        pytest.skip("the values are complete")
    (tmp_path / name).write_bytes(sound())
    assert np.array_equal(load_volume(tmp_path / name).values, VOLUME)
    (tmp_path / name).write_bytes(DAMAGES[damage](sound()))
    assert re.match(f"{name} is damaged or cut short, or an? {kind} ", refusal(tmp_path / name))


def test_a_header_without_all_its_values_beside_it_is_called_what_it_is(tmp_path):
    pytest.importorskip("nrrd")
    head = nrrd(packed=False)[: -VOLUME.size].replace(b"\n\n", b"\ndata file: a.raw\n\n")
    (tmp_path / "a.nhdr").write_bytes(head)
    (tmp_path / "a.raw").write_bytes(VOLUME.tobytes())
    assert np.array_equal(load_volume(tmp_path / "a.nhdr").values, VOLUME)
    (tmp_path / "a.raw").write_bytes(VOLUME.tobytes()[:-1])
    damaged = "a.nhdr is damaged or cut short, or an NRRD volume of an unknown kind"
    assert damaged in refusal(tmp_path / "a.nhdr")
    (tmp_path / "a.nhdr").write_bytes(head[:30])
    assert damaged in refusal(tmp_path / "a.nhdr")


def test_packed_values_that_a_flipped_bit_changes_are_damaged(tmp_path):
    pytest.importorskip("nrrd")
    content = VOLUME.tobytes()
    stored = zlib.compressobj(0, wbits=31)  # as it is, so that only the sum shows what has changed
    whole = nrrd(packed=True).partition(b"\n\n")[0] + b"\n\n" + stored.compress(content) + stored.flush()
    (tmp_path / "a.nrrd").write_bytes(flipped(whole, len(whole) // 2))
    assert "a.nrrd is damaged" in refusal(tmp_path / "a.nrrd")


def test_a_packed_file_that_cannot_be_unpacked_is_refused(tmp_path):
    (tmp_path / "packed.nii.gz").write_bytes(b"\x1f\x8b\x08" + bytes(7) + b"\xff" * 400)
    assert "packed.nii.gz is damaged" in refusal(tmp_path / "packed.nii.gz")


def of_much():
    header = nifti()
    struct.pack_into("<8h", header, 40, 3, 30000, 30000, 30000, 1, 1, 1, 1)
    return header


@pytest.mark.parametrize(
    ("suffix", "content"),
    [
        (".npy", lambda: array((10**6, 10**6, 10**6))),
        (".npz", lambda: archive(array((10**4, 10**4, 10**4)))),
        (".nii", of_much),
        (".nii.gz", lambda: gzip.compress(of_much())),
        (".tif", lambda: stack().replace(struct.pack("<I", 10), struct.pack("<I", 2**31))),
    ],
)
def test_a_volume_that_names_more_values_than_it_has_is_damaged_and_takes_no_memory(tmp_path, suffix, content):
    path = tmp_path / f"large{suffix}"
    path.write_bytes(content())
    assert re.search("is damaged|make it smaller", refusal(path))


def test_pages_in_a_circle_end(tmp_path):
    path = tmp_path / "circle.tif"
    for page in VOLUME[:2]:
        tifffile.imwrite(path, page, append=True, metadata=None)
    with tifffile.TiffFile(path) as file:
        first, second = (page.offset for page in file.pages)
    content = bytearray(path.read_bytes())
    (tags,) = struct.unpack_from("<H", content, second)
    struct.pack_into("<I", content, second + 2 + 12 * tags, first)
    path.write_bytes(content)
    refusal(path)


def test_what_is_odd_in_a_volume_is_said_nowhere(tmp_path, capfd):
    path = tmp_path / "odd.nii"
    header = nifti()
    struct.pack_into("<8f", header, 76, 1.0, -1.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0)
    struct.pack_into("<h", header, 252, 99)
    path.write_bytes(header)
    load_volume(path)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("odd", [b"\x00\x1b[31m", b"x" * 5000])
@pytest.mark.parametrize(
    "content",
    [
        b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 9 9 9\nencoding: ODD\n\n",
        b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 9 9 9\nencoding: raw\ndata file: ODD\n\n",
        b"ObjectType = Image\nNDims = 3\nDimSize = 9 9 9\nElementType = MET_UCHAR\nElementDataFile = ODD\n",
    ],
)
def test_what_a_header_names_is_quoted_in_one_line_and_cut_short(tmp_path, content, odd):
    path = tmp_path / "odd.vol"
    path.write_bytes(content.replace(b"ODD", odd))
    text = refusal(path)
    assert text.isprintable()
    assert len(text) < 500
