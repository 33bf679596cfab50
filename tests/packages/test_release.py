"""What desktops, hosts and readers are told of the program agrees with the program."""

import importlib
import re
import shutil
import subprocess
import tomllib
from configparser import ConfigParser
from importlib import metadata
from xml.etree import ElementTree

import pytest
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet

from cpm_core.formats.common.provenance import VERSION
from cpm_core.formats.sessions.session_file import SESSION_MARK, SESSION_SUFFIX
from tests.packages.places import ROOT

LINUX = ROOT / "release" / "linux"
RECIPE = (ROOT / "release" / "conda" / "recipe.yaml").read_text("utf-8")
CONDA = {"PySide6-Essentials": "pyside6"}
NAMESPACE = {"m": "http://www.freedesktop.org/standards/shared-mime-info"}


@pytest.fixture(scope="module")
def entry():
    """The desktop entry."""
    read = ConfigParser(interpolation=None, delimiters="=")
    read.optionxform = str
    read.read(LINUX / "cpm.desktop", encoding="utf-8")
    return read["Desktop Entry"]


@pytest.fixture(scope="module")
def kind():
    """The type of session files."""
    return ElementTree.parse(LINUX / "cpm-session.xml").getroot().find("m:mime-type", NAMESPACE)


@pytest.fixture(scope="module")
def told():
    """The data for software centers."""
    return ElementTree.parse(LINUX / "cpm.metainfo.xml").getroot()


def test_the_desktop_entry_starts_the_program_and_names_its_icon_and_files(entry, kind) -> None:
    assert entry["Exec"] == "cpm %f"
    assert (ROOT / "assets" / "icons" / f"{entry['Icon']}.svg").is_file()
    assert kind.get("type") in entry["MimeType"].split(";")


def test_the_version_is_the_same_for_readers_and_software_centers(told) -> None:
    assert re.search(r"^version: (.*)$", (ROOT / "CITATION.cff").read_text("utf-8"), re.MULTILINE)[1] == VERSION
    assert re.search(r"^## (\S+)", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.MULTILINE)[1] == VERSION
    assert told.find("releases/release").get("version").replace("~", "") == VERSION
    assert f"  version: {VERSION}\n" in RECIPE


def test_conda_installs_what_pip_installs_with_the_window() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    wanted = map(Requirement, (*project["dependencies"], *project["optional-dependencies"]["gui"]))
    run = re.findall(r"^    - (\S+) (\S+)$", RECIPE.partition("  run:\n")[2].partition("tests:")[0], re.MULTILINE)
    assert {(name, SpecifierSet(bounds)) for name, bounds in run} == {
        (CONDA.get(each.name, each.name), each.specifier) for each in wanted
    }


def test_session_files_are_known_by_name_and_content(kind) -> None:
    assert kind.find("m:glob", NAMESPACE).get("pattern") == f"*{SESSION_SUFFIX}"
    assert kind.find("m:magic/m:match", NAMESPACE).get("value") == SESSION_MARK


@pytest.mark.parametrize(
    ("tool", "arguments"),
    [
        ("desktop-file-validate", [LINUX / "cpm.desktop"]),
        ("appstreamcli", ["validate", "--no-net", LINUX / "cpm.metainfo.xml"]),
    ],
)
def test_the_tools_of_desktops_find_nothing_wrong(tool, arguments) -> None:
    if shutil.which(tool) is None:
        pytest.skip(f"{tool} is not there")
    done = subprocess.run([tool, *arguments], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_licenses_of_all_that_is_handed_out_are_gathered(monkeypatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "release"))
    licenses = importlib.import_module("licenses")
    found = licenses.distributions("scikit-image", ())
    assert {"numpy", "scipy", "pillow"} <= set(found)
    assert all(len(licenses.license_of(each)) > 2 for each in found.values())
    assert "not told" not in map(licenses.license_of, found.values())
    assert licenses.gathered().startswith("CPM\n\nMIT License")


def test_readers_in_the_application_without_python_are_named_by_their_distributions(monkeypatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "release"))
    modules = metadata.packages_distributions()
    for name, module in importlib.import_module("freeze").MEDICAL.items():
        assert modules[module] == [name]


def test_the_application_without_python_leaves_out_nothing_that_the_program_names(monkeypatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "release"))
    freeze = importlib.import_module("freeze")
    assert {"scipy.ndimage", "scipy.sparse.csgraph", "skimage.segmentation"} <= set(freeze.lazy())
    assert not set(freeze.lazy()) & set(freeze.LEFT_OUT)
