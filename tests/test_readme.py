"""README and guide promise nothing that is not so: their commands, examples and tables are run and compared."""

import re
import shlex
import shutil
from pathlib import Path

import pytest

from cpm_core import cli
from cpm_core.formats import CONTOURS_WRITABLE, IMAGES_READABLE
from cpm_core.parameters import PRESETS

ROOT = Path(__file__).parent.parent
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")
FORMATS = (ROOT / "docs" / "formats.md").read_text(encoding="utf-8")
PAGES = {
    path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8")
    for path in (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")))
}
SNIPPETS = {
    name: re.findall(r"^```([^\n]*)\n(.*?)^```$", page, flags=re.MULTILINE | re.DOTALL) for name, page in PAGES.items()
}
QUICK = ("README.md", "docs/start.md", "docs/library.md", "docs/volumes.md")
"""Pages whose snippets take no longer than a few seconds."""


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A folder that looks like the project's, where files may be written."""
    shutil.copytree(ROOT / "assets" / "samples", tmp_path / "assets" / "samples")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_presets_and_formats_are_named():
    assert all(f"`{name}`" in PAGES["docs/parameters.md"] for name in PRESETS)
    assert all(f"`{suffix}`" in FORMATS.split("## What is written")[1] for suffix in CONTOURS_WRITABLE)
    names = {
        "PNG": ".png",
        "TIFF": ".tif .tiff",
        "whole slides": ".svs .ndpi .scn",
        "CZI": ".czi",
        "LIF": ".lif",
        "ND2": ".nd2",
        "JPEG": ".jpg .jpeg",
        "BMP": ".bmp",
        "PNM": ".pbm .pgm .ppm .pnm",
        "GIF": ".gif",
        "WebP": ".webp",
        "JPEG 2000": ".jp2",
        "NumPy arrays": ".npy .npz",
        "NIfTI": ".nii .nii.gz .hdr",
        "DICOM": ".dcm .dicom .ima",
        "NRRD": ".nrrd .nhdr",
        "MetaImage": ".mha .mhd",
        "OME-Zarr": ".zarr",
    }
    assert {suffix for suffixes in names.values() for suffix in suffixes.split()} == set(IMAGES_READABLE)
    assert all(name in " ".join(TEXT.split()) for name in names)
    assert all(f"`{suffix}`" in FORMATS for suffix in IMAGES_READABLE)


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(name, marks=() if name in QUICK else pytest.mark.long)
        for name, snippets in SNIPPETS.items()
        if any(kind == "python" or (kind == "sh" and "cpm " in block) for kind, block in snippets)
    ],
)
def test_snippets_run_one_after_the_other_on_files_that_ship_or_that_they_make(compiled_loops, place, capsys, page):
    for kind, block in SNIPPETS[page]:
        if kind == "python":
            exec(compile(block, page, "exec"), {})
        for line in block.splitlines() if kind == "sh" else ():
            if line.startswith("cpm "):
                assert cli.main(shlex.split(line)[1:]) == 0, line
                written = re.search(r" --(?:export|to) ((?:(?!--)\S+ ?)+)", line)
                for name in written[1].split() if written else ():
                    assert "." not in name or list(place.glob(f"{name.partition('.')[0]}*")), line
    output = capsys.readouterr()
    assert output.out or not any(kind == "sh" for kind, _ in SNIPPETS[page])
    assert output.err == ""


def test_no_command_hides_in_a_snippet_of_no_kind():
    assert not [block for snippets in SNIPPETS.values() for kind, block in snippets if not kind and "cpm " in block]


def test_pictures_and_files_that_it_points_to_are_there():
    for page, text in PAGES.items():
        for target in re.findall(r"\]\((?!http|#)([^)#]+)[^)]*\)", text):
            assert (ROOT / page).parent.joinpath(target).is_file(), (page, target)


def test_each_command_stands_on_one_line_and_the_continuous_check_runs_those_that_check():
    assert "python3 -m venv .venv && .venv/bin/pip install --no-compile '.[gui]' && .venv/bin/cpm" in TEXT.splitlines()
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    patterns = re.findall(r"grep -m 1 '(.*)' README.md", script)
    assert [[line for line in TEXT.splitlines() if re.search(pattern, line)] for pattern in patterns] == [
        ["python3 -m venv .venv && .venv/bin/pip install -e '.[test]' && .venv/bin/python -m pytest"],
        [".venv/bin/python -m mypy"],
    ]
    (libraries,) = re.findall(r"^sudo apt-get install -y .*", TEXT, flags=re.MULTILINE)
    assert libraries in PAGES["docs/start.md"]
