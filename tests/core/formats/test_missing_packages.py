"""What few files need is not installed by default: one sentence says so when such a file is met."""

import sys
from pathlib import Path

import numpy as np
import PIL.Image
import pytest
from tifffile import _imagecodecs

import cpm_core as cpm
from cpm_core import cli
from cpm_core.formats import read_contours
from cpm_core.formats.sessions.session_file import SessionFile, save_session
from cpm_core.shapes import Everywhere

VALUES = np.zeros((32, 32), np.uint8)
VALUES[8:20, 8:20] = 200


@pytest.fixture(autouse=True)
def bare(monkeypatch):
    for package in ("ezdxf", "imagecodecs", "matplotlib"):
        monkeypatch.setitem(sys.modules, package, None)
    monkeypatch.setattr("tifffile.tifffile.imagecodecs", _imagecodecs)  # it may have imported the other before


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


@pytest.mark.parametrize("line", ["run a.npy --auto grid --export a.svg a.dxf",
                                  "batch a.npy --session a.cpm --output out --export svg dxf"])  # fmt: skip
def test_a_command_says_so_before_it_runs(tmp_path, monkeypatch, capsys, line):
    monkeypatch.chdir(tmp_path)
    np.save("a.npy", VALUES)
    save_session(SessionFile(shapes=(Everywhere("grid"),)), Path("a.cpm"))
    assert cli.main(line.split()) == 2
    assert "run pip install ezdxf" in capsys.readouterr().err
    assert not [*tmp_path.rglob("*.svg")]


def test_a_notebook_shows_the_line_instead_of_the_picture():
    assert cpm.Image(VALUES)._repr_png_() is None
