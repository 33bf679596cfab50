"""The library and the command line need no Qt: ``pip install .`` brings none."""

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

FORBIDDEN = """
import sys

QT = {"PySide6", "shiboken6", "pyqtgraph", "qtpy", "PyQt5", "PyQt6"}

class NoQt:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in QT:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, NoQt())
"""
"""Makes Python behave as if Qt were not installed."""


def run(code, *arguments):
    """What a process without Qt printed, and with which status it ended."""
    command = [sys.executable, "-c", FORBIDDEN + code, *map(str, arguments)]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, encoding="utf-8", check=False)


def test_all_of_the_core_is_imported_and_runs(tmp_path) -> None:
    done = run(
        """
import importlib, pkgutil
import cpm_core, cpm_app.model
for package in (cpm_core, cpm_app.model):
    for module in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
from cpm_app.__main__ import main
assert main(["run", sys.argv[1], "--circle", "100,73,38", "--export", sys.argv[2], "--json"]) == 0
assert QT.isdisjoint(name.partition(".")[0] for name in sys.modules)
""",
        ROOT / "assets" / "samples" / "u_shape.png",
        tmp_path / "u.svg",
    )
    assert done.returncode == 0, done.stderr
    assert '"converged": true' in done.stdout
    assert (tmp_path / "u.svg").stat().st_size > 0


@pytest.mark.parametrize("arguments", [(), (ROOT / "assets" / "samples" / "u_shape.png",)], ids=["alone", "an image"])
def test_a_window_without_qt_says_what_to_install(arguments) -> None:
    done = run("from cpm_app.__main__ import main\nsys.exit(main(sys.argv[1:]))", *arguments)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr == (
        "cpm: The window needs Qt, which is not installed: run pip install '.[gui]' in the folder of the README, or "
        "work without a window by “cpm run IMAGE …”.\n"
    )


def test_qt_is_asked_for_by_the_window_alone() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    window = {line.partition(">")[0] for line in project["optional-dependencies"]["gui"]}
    assert window == {"PySide6-Essentials", "pyqtgraph"}
    assert not [line for line in project["dependencies"] if line.startswith(tuple(window))]
    assert "gui" in project["optional-dependencies"]["test"][0]
