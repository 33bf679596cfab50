"""The architecture: what may import what, what a module may be called, and how large a thing may grow."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
LAYERS = ("cpm_core", "app.model", "app.session", "app.views", "app.__main__")
"""From the bottom to the top: a layer imports itself and those before it."""

QT = ("PySide6", "shiboken6", "pyqtgraph", "qtpy", "PyQt5", "PyQt6")
WIDGETS = ("PySide6.QtWidgets", "PySide6.QtOpenGLWidgets", "pyqtgraph")
FORBIDDEN = {"cpm_core": QT, "app.model": QT, "app.session": WIDGETS}
CORE_LIBRARIES = {"numpy", "scipy", "skimage", "numba", "PIL", "tifffile", "roifile"}

LATE_LIBRARIES = {
    "cpm_core.cli.figures.plotting": {"matplotlib"},
    "cpm_core.formats.animations.mp4": {"imageio_ffmpeg"},
    "cpm_core.cli.workers": {"distributed"},
}
"""What these modules import as well, and only where it is needed: inside functions, and for types."""

LONGEST_MODULE, LONGEST_CLASS, LONGEST_FUNCTION = 500, 300, 80

SOURCES = sorted(path for package in ("cpm_core", "app") for path in (ROOT / package).rglob("*.py"))


def module_name(path):
    """Dotted name of a source file."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imports(source, name, is_package):
    """Dotted names of all that a source imports, wherever in it, relative imports resolved."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                parents = name.split(".")[: len(name.split(".")) - node.level + is_package]
                base = ".".join([*parents, base] if base else parents)
            found += [f"{base}.{alias.name}" for alias in node.names]
    return found


def layer_of(name):
    """Layer that a dotted name belongs to; None for other packages."""
    return next((layer for layer in LAYERS if belongs(name, layer)), None)


def belongs(name, package):
    return name == package or name.startswith(package + ".")


def imported_by(path):
    return imports(path.read_text(encoding="utf-8"), module_name(path), path.name == "__init__.py")


def rules_broken(name, imported):
    """Sentences on what a module imports against the rules."""
    layer = layer_of(name)
    broken = []
    for other in imported:
        above = layer_of(other)
        if layer is not None and above is not None and LAYERS.index(above) > LAYERS.index(layer):
            broken.append(f"{name} imports {other}, which stands above it")
        if any(belongs(other, package) for package in FORBIDDEN.get(layer, ())):
            broken.append(f"{name} imports {other}, which {layer} must do without")
    return broken


@pytest.mark.parametrize("path", SOURCES, ids=module_name)
def test_imports_point_one_way(path):
    assert rules_broken(module_name(path), imported_by(path)) == []


@pytest.mark.parametrize(
    ("name", "source"),
    [
        ("cpm_core.segmentation.engine", "from app.model.document.document import Document"),
        ("cpm_core.segmentation.engine", "def late():\n    import PySide6.QtCore"),
        ("cpm_core.field.pppm", "from ...app import views"),
        ("app.model.document.edits", "from ...session import session"),
        ("app.model.document.edits", "from pyqtgraph import Point"),
        ("app.session.worker.worker_thread", "from PySide6 import QtWidgets"),
        ("app.session.worker.worker_thread", "import app.views.canvas.canvas"),
        ("app.views.canvas.canvas", "from app.__main__ import main"),
    ],
)
def test_the_rules_see_an_import_that_breaks_them(name, source):
    assert len(rules_broken(name, imports(source, name, is_package=False))) == 1


@pytest.mark.parametrize(
    ("name", "source"),
    [
        (
            "cpm_core.segmentation.engine",
            "import numpy\nfrom cpm_core.particles import State\nfrom . import coulomb",
        ),
        ("app.session.session", "from PySide6.QtCore import QObject\nfrom app.model.document.document import Document"),
        (
            "app.views.canvas.canvas",
            "import pyqtgraph\nfrom app.session.session import Session\nfrom ..model import edits",
        ),
    ],
)
def test_the_rules_let_proper_imports_pass(name, source):
    assert rules_broken(name, imports(source, name, is_package=False)) == []


def at_once(source):
    """The statements of a source that are executed when it is imported: all but those for types."""
    tree = ast.parse(source)
    tree.body = [
        node for node in tree.body if not (isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test))
    ]
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            node.body = [ast.Pass()]
    return ast.unparse(tree)


def libraries(names):
    """Packages of others among dotted names."""
    return {name.split(".")[0] for name in names} - set(sys.stdlib_module_names) - {"cpm_core"}


@pytest.mark.parametrize(
    "path", [path for path in SOURCES if module_name(path).startswith("cpm_core")], ids=module_name
)
def test_the_core_stands_on_few_libraries(path):
    name, source = module_name(path), path.read_text(encoding="utf-8")
    assert libraries(imported_by(path)) <= CORE_LIBRARIES | LATE_LIBRARIES.get(name, set())
    assert libraries(imports(at_once(source), name, path.name == "__init__.py")) <= CORE_LIBRARIES


def test_what_is_imported_late_is_told_from_what_is_imported_at_once():
    source = (
        "import numpy\nif TYPE_CHECKING:\n    import scipy\ndef f():\n    import numba\nclass A:\n    import PIL\n"
        "    def g(self):\n        import matplotlib\n"
    )
    assert libraries(imports(at_once(source), "cpm_core.a", is_package=False)) == {"numpy", "PIL"}


def test_parts_of_large_libraries_are_loaded_when_they_are_asked_for():
    """Loading these parts takes longer than all the rest, and a window wants to be seen before they are needed."""
    slow = {
        "scipy.ndimage",
        "scipy.spatial",
        "scipy.fft",
        "scipy.special",
        "scipy.sparse",
        "skimage.measure",
        "matplotlib",
    }
    code = "import sys, cpm_core, app.model.document.document; print(*sys.modules)"
    command = [sys.executable, "-c", code]
    loaded = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    assert "cpm_core.segmentation.engine" in loaded
    assert slow.isdisjoint(loaded)


@pytest.mark.parametrize("path", SOURCES, ids=module_name)
def test_no_module_is_a_box_for_odds_and_ends(path):
    assert path.stem not in {"utils", "util", "utilities", "helpers", "helper", "common", "misc", "tools_"}


@pytest.mark.parametrize("path", SOURCES, ids=module_name)
def test_modules_classes_and_functions_stay_small(path):
    source = path.read_text(encoding="utf-8")
    assert len(source.splitlines()) <= LONGEST_MODULE
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ClassDef):
            assert node.end_lineno - node.lineno < LONGEST_CLASS, node.name
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            assert node.end_lineno - node.lineno < LONGEST_FUNCTION, node.name


def test_the_top_level_holds_what_it_should_and_nothing_else():
    if (ROOT / ".git").exists():
        listing = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
        files = subprocess.run(listing, cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()
        names = {file.split("/")[0] for file in files}
    else:  # an unpacked archive; environments and build products may lie beside the source
        names = {path.name for path in ROOT.iterdir()} - {"build", "dist", "venv", "__pycache__", "PKG-INFO"}
    visible = {name for name in names if not name.startswith(".")}
    assert visible == {"pyproject.toml", "app", "cpm_core", "tests", "assets", "README.md", "LICENSE"}
