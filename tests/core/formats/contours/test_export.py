"""Export: by suffix, all or nothing, and never half a file."""

import os
import re
import sys
from dataclasses import replace

import numpy as np
import pytest

from cpm_core.contours.contour import Contour
from cpm_core.contours.result import Result
from cpm_core.formats import WRITABLE, check_export, encoded, export, suffix_of

TRIANGLE = np.array([[5.0, 5.0], [5.0, 20.0], [20.0, 5.0]])


def result_of(closed):
    contours = (Contour(TRIANGLE, closed=closed, strength=1.0),)
    return Result(TRIANGLE, contours, None, 1, True, "at rest", (30, 30), (1.0, 1.0), None, "a.png")


CLOSED = result_of(True)


@pytest.mark.parametrize(
    ("suffix", "written"),
    [
        (".svg", b'data-by-hand="15.000"'),
        (".csv", b",by_hand"),
        (".measures.csv", b",by_hand_px"),
        (".json", b'"by_hand": 15.0'),
        (".geojson", b'"Length by hand px": 15.0'),
    ],
)
def test_the_length_drawn_by_hand_is_told(suffix, written):
    by_hand = replace(CLOSED, contours=(replace(CLOSED.contours[0], by_hand=(TRIANGLE[:2],)),))
    assert written in encoded(by_hand, suffix) and written not in encoded(CLOSED, suffix)


@pytest.mark.parametrize("suffix", WRITABLE)
@pytest.mark.parametrize("change", [str.lower, str.upper])
def test_the_suffix_chooses_the_format_in_small_and_capital_letters(tmp_path, suffix, change):
    path = tmp_path / f"out{change(suffix)}"
    export(CLOSED, path)
    beginnings = {
        ".svg": b"<?xml",
        ".csv": b"contour,closed,",
        ".measures.csv": b"contour,label,",
        ".json": b'{\n"format": "cpm-contours"',
        ".geojson": b'{\n"type": "FeatureCollection"',
        ".zip": b"PK",
        ".roi": b"Iout",
        ".labelme.json": b'{\n"version"',
        ".coco.json": b'{\n"info"',
        ".png": b"\x89PNG",
        ".tif": b"II*\0",
        ".tiff": b"II*\0",
        ".nii": b"\x5c\x01\0\0",
        ".nii.gz": b"\x1f\x8b",
        ".dxf": b"999\nprogram: CPM",
        ".figure.svg": b"<?xml",
        ".figure.png": b"\x89PNG",
        ".figure.pdf": b"%PDF",
    }
    assert path.read_bytes().startswith(beginnings[suffix])


@pytest.mark.parametrize("name", ["out.xyz", "out", "out.svg.gz", ".svg", ".nii.gz", ".coco.json", "outsvg"])
def test_an_unknown_suffix_is_refused_with_the_known_ones(tmp_path, name):
    with pytest.raises(ValueError, match=re.escape(name)) as caught:
        export(CLOSED, tmp_path / name)
    assert all(suffix in str(caught.value) for suffix in WRITABLE)
    assert list(tmp_path.iterdir()) == []


def test_the_same_result_makes_the_same_bytes(tmp_path):
    for suffix in WRITABLE:
        export(CLOSED, tmp_path / f"a{suffix}", tmp_path / f"b{suffix}")
        assert (tmp_path / f"a{suffix}").read_bytes() == (tmp_path / f"b{suffix}").read_bytes()


def test_a_file_that_exists_is_replaced_and_nothing_else_is_left(tmp_path):
    (tmp_path / "out.csv").write_text("old", encoding="utf-8")
    export(CLOSED, tmp_path / "out.csv")
    assert (tmp_path / "out.csv").read_text(encoding="utf-8").startswith("contour,")
    assert [path.name for path in tmp_path.iterdir()] == ["out.csv"]


def test_when_one_of_several_cannot_be_made_none_is_written(tmp_path):
    with pytest.raises(ValueError, match="is closed"):
        export(result_of(False), tmp_path / "a.svg", tmp_path / "b.csv", tmp_path / "c.png")
    assert list(tmp_path.iterdir()) == []


def test_a_disk_that_fails_leaves_the_old_file_and_no_draft(tmp_path, monkeypatch):
    (tmp_path / "out.csv").write_text("old", encoding="utf-8")

    def full(_descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(ValueError, match=r"out\.csv cannot be written: No space left on device\."):
        export(CLOSED, tmp_path / "out.csv")
    assert (tmp_path / "out.csv").read_text(encoding="utf-8") == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["out.csv"]


def test_a_link_stays_a_link_to_the_new_content(tmp_path):
    (tmp_path / "real").mkdir()
    target = tmp_path / "real" / "kept.csv"
    target.write_text("old", encoding="utf-8")
    (tmp_path / "link.csv").symlink_to(target)
    export(CLOSED, tmp_path / "link.csv")
    assert (tmp_path / "link.csv").is_symlink()
    assert target.read_text(encoding="utf-8").startswith("contour,")


@pytest.mark.parametrize("path", ["none/out.svg", "folder.svg"])
def test_a_place_where_no_file_can_be_is_told_beforehand(tmp_path, path):
    (tmp_path / "folder.svg").mkdir()
    with pytest.raises(ValueError, match=re.escape(str(tmp_path / path))):
        check_export(tmp_path / path)


def test_a_folder_that_must_not_be_written_to_is_told_beforehand(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "access", lambda path, mode: not (mode == os.W_OK and path == tmp_path))
    with pytest.raises(ValueError, match="no permission to write"):
        check_export(tmp_path / "out.svg")


@pytest.mark.parametrize(
    ("name", "suffix"),
    [
        ("a.json", ".json"),
        ("a.COCO.json", ".coco.json"),
        ("a.labelme.json", ".labelme.json"),
        ("a.b.json", ".json"),
        ("coco.json", ".json"),
        ("a.measures.csv", ".measures.csv"),
        ("measures.csv", ".csv"),
        ("scan.nii.gz", ".nii.gz"),
        ("scan.nii", ".nii"),
        ("scan.gz", ""),
        (".json", ""),
        ("a", ""),
    ],
)
def test_of_several_suffixes_the_longest_counts(name, suffix):
    assert suffix_of(name) == suffix


@pytest.mark.parametrize("suffix", WRITABLE)
def test_what_is_made_without_a_file_is_the_content_of_the_file(tmp_path, suffix):
    export(CLOSED, tmp_path / f"a{suffix}")
    assert encoded(CLOSED, suffix) == (tmp_path / f"a{suffix}").read_bytes()


def test_text_for_the_clipboard_of_an_unknown_kind_is_refused_with_the_known_ones():
    with pytest.raises(ValueError, match=re.escape('".xyz" names no format')) as caught:
        encoded(CLOSED, ".xyz")
    assert all(suffix in str(caught.value) for suffix in WRITABLE)


def test_what_a_file_leaves_out_is_told_before_it_is_written(tmp_path, caplog):
    result = replace(CLOSED, contours=(*CLOSED.contours, *result_of(False).contours * 2))
    told = []
    files = [tmp_path / "a.png", tmp_path / "a.coco.json", tmp_path / "a.svg"]
    export(result, *files, tell=lambda sentence: told.append((sentence, any(file.exists() for file in files))))
    png, coco = f"{files[0]}: 2 of 3 contours are open and not in a mask.", "not in a COCO file."
    assert told == [(png, False), (f"{files[1]}: 2 of 3 contours are open and {coco}", False)]
    export(result, *files[:1])
    assert png in caplog.text
    export(result, *files[:1], outlines=True, tell=told.append)
    assert len(told) == 2


def test_figures_say_what_to_install_before_anything_is_written(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(ValueError, match="Figures are drawn by matplotlib, which is not installed: get it with pip"):
        export(CLOSED, tmp_path / "a.svg", tmp_path / "a.figure.pdf")
    assert not list(tmp_path.iterdir())
