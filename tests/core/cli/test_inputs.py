"""Inputs of commands: which images a folder stands for."""

import numpy as np
import pytest

import cpm_core as cpm
from cpm_core.cli.inputs import expand_paths, find_only_image
from tests.core.formats.images.made import write_series


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "cells").mkdir()
    for name in ("a2", "a10"):
        np.save(tmp_path / "cells" / f"{name}.npy", np.eye(12))
        (tmp_path / "cells" / f"._{name}.npy").write_bytes(b"\0\5\x16\7" + bytes(60))
    return tmp_path / "cells"


def test_a_folder_with_a_series_below_stands_for_itself_unless_it_has_images(folder):
    disc = folder.parent / "cd"
    (disc / "DICOM").mkdir(parents=True)
    write_series(disc / "DICOM" / "SE0", range(10))
    assert expand_paths([str(disc)]) == [str(disc)]
    (disc / "DICOM").rename(folder / "DICOM")
    assert expand_paths([str(folder)]) == [str(folder / "a2.npy"), str(folder / "a10.npy")]  # and not ._a2.npy
    with pytest.raises(ValueError, match="is a folder without images"):
        expand_paths([str(disc)])


def test_an_address_is_kept_as_the_name_of_its_file_unless_a_file_is_named_like_it(folder, monkeypatch):
    fsspec = pytest.importorskip("fsspec")
    with fsspec.open("memory://plate/b.npy", "wb") as stream:
        stream.write((folder / "a2.npy").read_bytes())
    assert expand_paths(["memory://plate/b.npy"]) == ["memory://plate/b.npy"]
    assert np.array_equal(np.load(find_only_image("memory://plate/b.npy")), np.eye(12))
    with pytest.raises(ValueError, match=r"memory://none\.npy cannot be read"):
        find_only_image("memory://none.npy")
    monkeypatch.chdir(folder)
    (folder / "a2.npy").rename("a::2.npy")
    assert cpm.load_image("a::2.npy").shape == (12, 12)
