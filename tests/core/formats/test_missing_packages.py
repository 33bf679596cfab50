"""What few files need is not installed by default: one sentence says so when such a file is met."""

import sys

import numpy as np
import PIL.Image
import pytest

import cpm_core as cpm
from cpm_core.formats import read_contours

VALUES = np.zeros((32, 32), np.uint8)
VALUES[8:20, 8:20] = 200


@pytest.fixture(autouse=True)
def bare(monkeypatch):
    for package in ("ezdxf", "imagecodecs", "matplotlib"):
        monkeypatch.setitem(sys.modules, package, None)


@pytest.mark.parametrize(("name", "how"), [("a.jp2", {}), ("a.jpg", {}), ("a.png", {}), ("a.tif", {}),
                                           ("a.tif", {"compression": "packbits"})])  # fmt: skip
def test_common_pictures_need_nothing_else(tmp_path, name, how):
    PIL.Image.fromarray(VALUES).save(tmp_path / name, **how)
    assert np.abs(cpm.load_image(tmp_path / name).values - VALUES).max() <= (20 if name == "a.jpg" else 0)


@pytest.mark.parametrize(
    ("package", "work"),
    [
        ("ezdxf", lambda result, folder: cpm.export(result, folder / "a.dxf")),
        ("matplotlib", lambda result, folder: cpm.export(result, folder / "a.figure.png")),
        ("matplotlib", lambda result, _folder: result.plot()),
        ("imagecodecs", lambda _result, folder: cpm.load_image(folder / "packed.tif")),
        ("ezdxf", lambda _result, folder: read_contours(folder / "empty.dxf")),
    ],
)
def test_a_sentence_says_what_to_install(tmp_path, package, work):
    PIL.Image.fromarray(VALUES).save(tmp_path / "packed.tif", compression="tiff_lzw")
    (tmp_path / "empty.dxf").write_text("0\nEOF\n")
    result = cpm.segment(VALUES, cpm.circle((14, 14), 9), max_steps=1)
    with pytest.raises(ValueError, match=rf"needs the package {package}, .*: run pip install {package}\."):
        work(result, tmp_path)


def test_a_notebook_shows_the_line_instead_of_the_picture():
    assert cpm.Image(VALUES)._repr_png_() is None
