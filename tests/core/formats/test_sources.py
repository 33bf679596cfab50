"""Open files and addresses of fsspec are read where a path is."""

import io
import zipfile

import numpy as np
import pytest

import cpm_core as cpm

VALUES = np.arange(24 * 20, dtype=np.uint8).reshape(24, 20)


@pytest.fixture
def content():
    stream = io.BytesIO()
    np.save(stream, VALUES)
    return stream.getvalue()


def test_an_open_file_is_read_under_its_name(tmp_path, content):
    (tmp_path / "cells.npy").write_bytes(content)
    with (tmp_path / "cells.npy").open("rb") as stream:
        image = cpm.load_image(stream)
    assert image.source == "cells.npy"
    assert np.array_equal(cpm.load_image(io.BytesIO(content)).values, VALUES)
    drawing = io.BytesIO(b'<svg viewBox="0 0 64 64"><rect x="8" y="8" width="9" height="4"/></svg>')
    drawing.name = "box.svg"
    assert cpm.load_contours(drawing)[0].area == 36.0


def test_an_address_is_read_as_a_file_of_its_name(tmp_path, content):
    fsspec = pytest.importorskip("fsspec")
    with fsspec.open("memory://folder/cells.npy", "wb") as stream:
        stream.write(content)
    image = cpm.load_image("memory://folder/cells.npy")
    assert (image.source, image.sha256) == ("cells.npy", cpm.load_image(io.BytesIO(content)).sha256)
    with zipfile.ZipFile(tmp_path / "all.zip", "w") as archive:
        archive.writestr("inner/cells.npy", content)
    assert np.array_equal(cpm.load_image(f"zip://inner/cells.npy::{tmp_path}/all.zip").values, VALUES)


def test_each_address_is_read_anew_whatever_has_its_name(content):
    fsspec = pytest.importorskip("fsspec")
    other = io.BytesIO()
    np.save(other, VALUES[::-1])
    for folder, written in (("day1", content), ("day2", other.getvalue())):
        with fsspec.open(f"memory://{folder}/cells.npy", "wb") as stream:
            stream.write(written)
    assert np.array_equal(cpm.load_image("memory://day1/cells.npy").values, VALUES)
    assert np.array_equal(cpm.load_image("memory://day2/cells.npy").values, VALUES[::-1])
    with fsspec.open("memory://day1/cells.npy", "wb") as stream:
        stream.write(other.getvalue())
    assert np.array_equal(cpm.load_image("memory://day1/cells.npy").values, VALUES[::-1])


@pytest.mark.parametrize("address", ["memory://nothing.npy", "nosuch://a/b.npy"])
def test_an_address_without_a_file_is_told_in_a_sentence(address):
    with pytest.raises(ValueError, match=address):
        cpm.load_image(address)
