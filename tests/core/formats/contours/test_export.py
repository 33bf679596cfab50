"""Export: by suffix, all or nothing, and never half a file."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cpm_core.contours.contour import Contour
from cpm_core.formats import CONTOURS_WRITABLE, check_export, export, find_format_suffix
from cpm_core.results.result import Result

TRIANGLE = np.array([[5.0, 5.0], [5.0, 20.0], [20.0, 5.0]])


def result_of(closed):
    contours = (Contour(TRIANGLE, closed=closed, strength=1.0),)
    return Result(TRIANGLE, contours, None, 1, True, "at rest", (30, 30), (1.0, 1.0), None, "a.png")


CLOSED = result_of(True)


@pytest.mark.parametrize("suffix", CONTOURS_WRITABLE)
def test_the_suffix_chooses_the_format_in_small_and_capital_letters(tmp_path, suffix):
    path = tmp_path / f"out{suffix.upper()}"
    export(CLOSED, path)
    beginnings = {
        ".svg": b"<?xml",
        ".csv": b"contour,closed,",
        ".measures.csv": b"contour,label,",
        ".table.csv": b"label,name,area_",
        ".json": b'{\n  "format": "cpm-contours"',
        ".geojson": b'{\n  "type": "FeatureCollection"',
        ".zip": b"PK",
        ".roi": b"Iout",
        ".labelme.json": b'{\n  "version"',
        ".coco.json": b'{\n  "info"',
        ".png": b"\x89PNG",
        ".tif": b"II*\0",
        ".tiff": b"II*\0",
        ".nii": b"\x5c\x01\0\0",
        ".nrrd": b"NRRD0004\ntype: uint16\n",
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
    assert all(suffix in str(caught.value) for suffix in CONTOURS_WRITABLE)
    assert list(tmp_path.iterdir()) == []


def test_when_one_of_several_cannot_be_made_none_is_written(tmp_path):
    with pytest.raises(ValueError, match="is closed"):
        export(result_of(False), tmp_path / "a.svg", tmp_path / "b.csv", tmp_path / "c.png")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("path", ["none/out.svg", "folder.svg"])
def test_a_place_where_no_file_can_be_is_told_beforehand(tmp_path, path):
    (tmp_path / "folder.svg").mkdir()
    with pytest.raises(ValueError, match=rf"^{Path(path).name} in .*{(tmp_path / path).parent.name}"):
        check_export(tmp_path / path)


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
    assert find_format_suffix(name) == suffix


def test_what_a_file_leaves_out_is_told_before_it_is_written(tmp_path, caplog):
    result = replace(CLOSED, contours=(*CLOSED.contours, *result_of(False).contours * 2))
    told = []
    files = [tmp_path / "a.png", tmp_path / "a.coco.json", tmp_path / "a.svg"]
    export(result, *files, warn=lambda sentence: told.append((sentence, any(file.exists() for file in files))))
    png, coco = f"{files[0]}: 2 of 3 contours are open and not in a mask.", "not in a COCO file."
    assert told == [(png, False), (f"{files[1]}: 2 of 3 contours are open and {coco}", False)]
    export(result, *files[:1])
    assert png in caplog.text
    export(result, *files[:1], outlines=True, warn=told.append)
    assert len(told) == 2
