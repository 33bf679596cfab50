"""The documentation is made from the program, names tests that there are, and its notebooks run."""

from __future__ import annotations

import ast
import doctest
import json
import re
import shutil
from pathlib import Path

import matplotlib as mpl
import pytest
from matplotlib import pyplot

import cpm_core as cpm
from cpm_core.formats import CENTERLINES_WRITABLE, CONTOURS_WRITABLE, VOLUMES_WRITABLE
from cpm_core.parameters import PARAMETERS
from cpm_core.parameters.choices import CHOICE_PARAMETERS
from docs.making import command_line, formats, headers, notebooks, pages, parameters, reference

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"

SCRIPTS = sorted((DOCS / "notebooks").glob("*.py"))
PAGES = sorted(path for path in DOCS.rglob("*.md") if not {"_made", "_build"} & set(path.parts))


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A folder with the samples, and plots without a window."""
    (tmp_path / "assets").mkdir()
    shutil.copytree(ROOT / "assets" / "samples", tmp_path / "assets" / "samples")
    monkeypatch.chdir(tmp_path)
    before = mpl.get_backend()
    pyplot.switch_backend("agg")
    yield tmp_path
    pyplot.close("all")
    pyplot.switch_backend(before)


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_a_notebook_runs(script, place):
    cells = notebooks.cells(script.read_text(encoding="utf-8"))
    assert cells[0].text.startswith("# ")
    names = {}
    outputs = [notebooks.run(cell, names) for cell in cells if cell.code]
    assert isinstance(names["result" if script.stem != "artery" else "bones"], cpm.Result | cpm.Skeleton)
    assert pyplot.get_fignums()
    assert any(printed for printed, _ in outputs)


def test_there_are_notebooks_of_four_tasks():
    assert len(SCRIPTS) == 4


def test_a_script_becomes_a_notebook_with_the_same_cells():
    cells = notebooks.cells("# %% [markdown]\n# # Title\n#\n# Text.\n\n# %%\na = 1\na + 1\n")
    assert [(cell.text, cell.code) for cell in cells] == [("# Title\n\nText.", False), ("a = 1\na + 1", True)]
    assert notebooks.run(cells[1], {}) == ("", 2)
    made = json.loads(notebooks.jupyter(cells))
    assert [cell["cell_type"] for cell in made["cells"]] == ["markdown", "code"]
    assert "".join(made["cells"][1]["source"]) == "a = 1\na + 1"


def test_each_expectation_names_a_test_that_there_is():
    rows = re.findall(r"^\| \d.*$", (DOCS / "expectations.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert len(rows) > 30
    for row in rows:
        path, name = re.fullmatch(r".*`(.*)::(\w+)` \|", row).groups()
        assert f"def {name}(" in (ROOT / path).read_text(encoding="utf-8"), row


def test_the_continuous_check_builds_it_by_the_command_of_the_readme():
    script = (ROOT / ".ci" / "docs").read_text(encoding="utf-8")
    pattern = re.search(r"grep -m 1 '(.*)' README.md", script).group(1)
    lines = [line for line in (ROOT / "README.md").read_text(encoding="utf-8").splitlines() if re.search(pattern, line)]
    assert len(lines) == 1
    assert "-e '.[docs]'" in lines[0]


def test_every_public_name_is_on_one_page_of_the_reference():
    text = "\n".join(reference.pages().values())
    for name in cpm.__all__:
        assert (
            len(re.findall(rf"^\.\. (?:py:data|autoclass|autofunction):: cpm_core\.{name}$", text, re.MULTILINE)) == 1
        )


@pytest.mark.parametrize("name", [name for name in cpm.__all__ if not hasattr(getattr(cpm, name), "__qualname__")])
def test_the_example_of_a_table_gives_what_it_says(name):
    _, example = reference.TABLES[name]
    report = []
    test = doctest.DocTestParser().get_doctest(example, {"cpm": cpm}, name, None, None)
    assert test.examples
    assert doctest.DocTestRunner().run(test, out=report.append).failed == 0, "".join(report)


def test_tables_hold_every_parameter_format_and_command():
    assert all(f"| `{name}` |" in parameters.table() for name in (*PARAMETERS, *CHOICE_PARAMETERS))
    assert all(f"| `{name}` |" in parameters.presets() for name in cpm.PRESETS)
    assert all(
        f"| `{suffix}` |" in formats.writable()
        for suffix in {**CONTOURS_WRITABLE, **VOLUMES_WRITABLE, **CENTERLINES_WRITABLE}
    )
    commands = command_line.text()
    assert {"## cpm run", "## cpm batch", "## cpm skeleton", "## cpm info"} <= set(commands.splitlines())
    assert "--time-step" in commands


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_pages_point_to_what_is_there_without_building_them(page):
    for target in re.findall(r"\]\((?!http|#)([^)#]+)[^)]*\)", page.read_text(encoding="utf-8")):
        assert (page.parent / target).is_file(), target


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_tables_in_pages_are_those_of_the_program(page):
    text = page.read_text(encoding="utf-8")
    assert pages.with_current_tables(text) == text, "python -m docs.making brings it up to date"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_examples_of_pages_are_python_that_names_what_there_is(page):
    blocks = re.findall(r"^```python\n(.*?)^```$", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    named = {
        node.attr
        for block in blocks
        for node in ast.walk(ast.parse(block))
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "cpm"
    }
    assert named <= set(cpm.__all__)


@pytest.mark.parametrize(
    ("kind", "entry", "note"),
    [
        ("TIFF", "PhysicalSize", "Gray levels were calibrated as its description says."),
        ("NIfTI, Analyze 7.5", "sform_code", "Its qform is not valid and was left out."),
        ("DICOM", "ImagePositionPatient", "It counts from white to black and was inverted."),
        ("MetaImage", "elementspacing", ""),
        ("NRRD", "space directions", ""),
    ],
)
def test_what_readers_take_and_report_is_listed(kind, entry, note):
    (line,) = (line for line in headers.headers().splitlines() if line.startswith(f"| {kind} |"))
    _, _, entries, notes, _ = line.split("|")
    assert f"`{entry}`" in entries
    assert note in notes
    assert "is damaged" not in notes
