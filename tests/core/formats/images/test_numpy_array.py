"""NumPy arrays: gray levels and colours as they were saved."""

import re
from pathlib import Path

import numpy as np
import pytest

from cpm_core.formats import load_image
from cpm_core.formats.images import readers

RAMP = np.arange(12 * 20).reshape(12, 20)


@pytest.mark.parametrize("kind", [bool, np.uint8, np.int64, np.float16, np.float32])
def test_values_are_kept_as_they_are(tmp_path, kind):
    np.save(tmp_path / "a.npy", RAMP.astype(kind))
    assert np.array_equal(load_image(tmp_path / "a.npy").values, RAMP.astype(kind))


def test_columns_first_arrays_are_not_turned(tmp_path):
    np.save(tmp_path / "a.npy", np.asfortranarray(RAMP))
    assert np.array_equal(load_image(tmp_path / "a.npy").values, RAMP)


def test_three_channels_are_colour(tmp_path):
    np.save(tmp_path / "a.npy", np.stack([RAMP, 2 * RAMP, 3 * RAMP], axis=2))
    image = load_image(tmp_path / "a.npy")
    assert np.allclose(image.values, (0.2125 + 2 * 0.7154 + 3 * 0.0721) * RAMP)


@pytest.mark.parametrize(
    ("array", "words"),
    [
        (np.zeros((3, 4, 5, 6)), "a.npy holds an array of shape (3, 4, 5, 6)"),
        (np.zeros((2, 20, 20, 20)), "a.npy holds an array of shape (2, 20, 20, 20)"),
        (np.zeros(100), "a.npy holds an array of shape (100,)"),
        (np.zeros((10, 10), dtype=complex), "a.npy holds values of type complex128"),
        (np.full((10, 10), "x"), "a.npy holds values of type <U1"),
        (np.full((10, 10), np.inf), "a.npy holds 100 infinite values"),
        (np.zeros((3, 3)), "a.npy is 3 x 3 px"),
    ],
)
def test_arrays_that_are_no_image_are_refused_in_one_sentence(tmp_path, array, words):
    np.save(tmp_path / "a.npy", array)
    with pytest.raises(ValueError, match=re.escape(words)) as caught:
        load_image(tmp_path / "a.npy")
    assert "\n" not in str(caught.value)


def test_an_array_of_python_objects_is_never_unpickled(tmp_path):
    np.save(tmp_path / "a.npy", np.array([["x", None]] * 10, dtype=object), allow_pickle=True)
    with pytest.raises(ValueError, match=r"a\.npy is damaged"):
        load_image(tmp_path / "a.npy")


def test_a_header_that_promises_more_than_there_is_is_refused(tmp_path):
    np.save(tmp_path / "a.npy", RAMP)
    (tmp_path / "a.npy").write_bytes((tmp_path / "a.npy").read_bytes()[:-8])
    with pytest.raises(ValueError, match=r"a\.npy is damaged"):
        load_image(tmp_path / "a.npy")


def test_whether_a_file_is_a_folder_is_asked_without_an_error_that_nobody_expects(tmp_path, monkeypatch):
    np.save(tmp_path / "a.npy", np.eye(16))

    def closed(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(readers, "compute_fingerprint", lambda *_: "0" * 64)
    monkeypatch.setattr(Path, "is_dir", closed)
    assert load_image(tmp_path / "a.npy").file_sha256 == "0" * 64
