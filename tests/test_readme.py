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
PAGES = {path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8") for path in (ROOT / "docs").glob("*.md")}
BLOCKS = [
    (kind, block)
    for page in (TEXT, *PAGES.values())
    for kind, block in re.findall(r"^```(\w+)\n(.*?)^```$", page, flags=re.MULTILINE | re.DOTALL)
]
COMMANDS = [line for kind, block in BLOCKS if kind == "sh" for line in block.splitlines()]
RUNS = sorted({line for line in COMMANDS if line.startswith("cpm ")})
EXAMPLES = [block for kind, block in BLOCKS if kind == "python" and "rings.svg" in block]


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


@pytest.mark.parametrize("line", RUNS)
def test_commands_of_the_tour_work_as_they_stand(compiled_loops, place, capsys, line):
    assert cli.main(shlex.split(line)[1:]) == 0
    output = capsys.readouterr()
    assert output.out
    assert output.err == ""
    for name in re.findall(r"\b\w+\.(?:svg|csv)\b", line):
        assert (place / name).stat().st_size > 0


@pytest.mark.parametrize("example", EXAMPLES)
def test_the_library_examples_work_as_they_stand(place, capsys, example):
    exec(compile(example, "example", "exec"), {})
    output = capsys.readouterr().out
    assert output.count("closed: True") == 5
    assert "at rest" in output or "Engine" not in example
    assert (place / "rings.svg").exists()


def test_the_tour_has_commands_and_an_example():
    assert len(RUNS) >= 3
    assert len(EXAMPLES) == 2


def test_pictures_and_files_that_it_points_to_are_there():
    for page, text in {"README.md": TEXT, **PAGES}.items():
        for target in re.findall(r"\]\((?!http|#)([^)#]+)[^)]*\)", text):
            assert (ROOT / page).parent.joinpath(target).is_file(), (page, target)


def test_each_command_stands_on_one_line_and_the_continuous_check_runs_those_that_check():
    assert "python3 -m venv .venv && .venv/bin/pip install '.[gui]' && .venv/bin/cpm" in COMMANDS
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    patterns = re.findall(r"grep -m 1 '(.*)' README.md", script)
    assert [[line for line in TEXT.splitlines() if re.search(pattern, line)] for pattern in patterns] == [
        ["python3 -m venv .venv && .venv/bin/pip install -e '.[test]' && .venv/bin/python -m pytest"],
        [".venv/bin/python -m mypy"],
    ]
    assert len(re.findall(r"^sudo apt-get install -y ", TEXT, flags=re.MULTILINE)) == 1
