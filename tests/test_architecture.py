"""The architecture: what may import what, what names stand for, and what its page says of it."""

import ast
import re
import shutil
import subprocess
import sys
from collections import defaultdict
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parent.parent
LAYERS = ("cpm_core", "cpm_app.model", "cpm_app.session", "cpm_app.views", "cpm_app.__main__")
"""From the bottom to the top: a layer imports itself and those before it."""

QT = ("PySide6", "shiboken6", "pyqtgraph", "qtpy", "PyQt5", "PyQt6")
WIDGETS = ("PySide6.QtWidgets", "PySide6.QtOpenGLWidgets", "pyqtgraph")
FORBIDDEN = {"cpm_core": QT, "cpm_app.model": QT, "cpm_app.session": WIDGETS}
CORE_LIBRARIES = {
    "numpy", "scipy", "skimage", "numba", "llvmlite", "PIL", "tifffile", "roifile", "argcomplete", "threadpoolctl",
}  # fmt: skip

LATE_LIBRARIES = {
    "cpm_core.image.drawing": {"matplotlib"},
    "cpm_core.notebook.view": {"anywidget", "traitlets"},
    "cpm_core.objects.prior.larger_models": {"loguru", "onnxruntime", "osam"},
    "cpm_core.objects.prior.server": {"httpx", "nnInteractive"},
    "cpm_core.objects.segmented.areas": {"shapely"},
    "cpm_core.objects.segmented.by_hand": {"shapely"},
    "cpm_core.numerics.polyline": {"shapely"},
    "cpm_core.numerics.segments": {"shapely"},
    "cpm_core.contours.faces": {"shapely"},
    "cpm_core.contours.region_table": {"shapely"},
    "cpm_core.image.regions": {"shapely"},
    "cpm_core.image.geometry": {"nibabel"},
    "cpm_core.formats.animation": {"imageio_ffmpeg"},
    "cpm_core.formats.common.content": {"fsspec"},
    "cpm_core.formats.images.nifti": {"nibabel"},
    "cpm_core.formats.images.nrrd": {"nrrd"},
    "cpm_core.formats.images.dicom": {"pydicom", "imagecodecs"},
    "cpm_core.formats.images.dicom_slide": {"pydicom"},
    "cpm_core.formats.images.raster": {"imagecodecs"},
    "cpm_core.cli.workers": {"dask", "distributed"},
    "cpm_core.chunked.seams": {"shapely"},
    "cpm_core.chunked.results": {"pyarrow"},
    "cpm_core.formats.images.ome_zarr": {"zarr"},
    "cpm_core.formats.images.tiff": {"zarr"},
    "cpm_core.formats.contours.dxf": {"ezdxf"},
    "cpm_core.formats.contours.geojson": {"shapely"},
    "cpm_core.formats.contours.svg": {"svgelements"},
    "cpm_core.formats.meshes.simplification": {"fast_simplification"},
    "cpm_core.formats.masks.dicom_seg": {"highdicom", "pydicom"},
    "cpm_core.formats.masks.nifti": {"nibabel"},
    "cpm_core.formats.surface_file": {"nibabel"},
}
"""What these modules import as well, and only where it is needed: inside functions, and for types."""

FLOORS = (
    "cpm_core.parameters",
    "cpm_core.numerics",
    "cpm_core.image",
    "cpm_core.field",
    "cpm_core.model",
    "cpm_core.contours",
    "cpm_core.reconstruction",
    "cpm_core.medial_axis",
    "cpm_core.objects",
    "cpm_core.results",
    "cpm_core.published",
    "cpm_core.segmentation",
    "cpm_core.methods",
    "cpm_core.notebook",
    "cpm_core.shapes",
    "cpm_core.pages",
    "cpm_core.formats",
    "cpm_core.chunked",
    "cpm_core.cli",
)
"""Rooms of the core from the ground floor up: each imports itself and those before it."""

SOURCES = sorted(path for package in ("cpm_core", "app/cpm_app") for path in (ROOT / package).rglob("*.py"))
CORE = [path for path in SOURCES if path.is_relative_to(ROOT / "cpm_core")]


def module_name(path):
    """Dotted name of a source file."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    parts = parts[1:] if parts[0] == "app" else parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def statements(tree, at_once=False):
    """All statements of a module; `at_once`, those that are executed when it is imported, without those for types."""
    waiting = [tree]
    for node in waiting:
        yield node
        inside = ("body", "orelse", "handlers", "finalbody", "cases")
        if at_once and isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            continue
        if at_once and isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            inside = ("orelse",)
        for field in inside:
            waiting += getattr(node, field, ())


def imports(tree, name, is_package, at_once=False):
    """Dotted names of all that a module imports, wherever in it or `at_once`, relative imports resolved."""
    found = []
    for node in statements(tree, at_once):
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


class Module(NamedTuple):
    """What the rules are about in a module: read once, as a tree of each of them would fill the memory."""

    imported: list  # dotted names, wherever in it
    imported_at_once: list
    classes: list  # public ones, wherever in it
    constants: list  # without the underscore that makes them private
    packed: list  # constants that one assignment defines together


@cache
def module(path):
    tree, name = ast.parse(path.read_text(encoding="utf-8")), module_name(path)
    classes = [node.name for node in ast.walk(tree) if isinstance(node, ast.ClassDef) and node.name[0] != "_"]
    return Module(
        *(imports(tree, name, path.name == "__init__.py", at_once) for at_once in (False, True)),
        classes,
        *constants(tree),
    )


def constants(tree):
    """Names of the constants of a module, and those among them that one assignment defines together."""
    found, packed = [], []
    for node in tree.body:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        for target in targets:
            together = target.elts if isinstance(target, ast.Tuple | ast.List) else [target]
            names = [one.id for one in together if isinstance(one, ast.Name) and one.id.isupper()]
            found += [name.strip("_") for name in names]
            packed += names if len(together) > 1 else []
    return found, packed


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


def test_imports_point_one_way():
    broken = [rule for path in SOURCES for rule in rules_broken(module_name(path), module(path).imported)]
    assert broken == []


@pytest.mark.parametrize(
    ("name", "source"),
    [
        ("cpm_core.segmentation.engine", "from cpm_app.model.document.document import Document"),
        ("cpm_core.segmentation.engine", "def late():\n    import PySide6.QtCore"),
        ("cpm_core.field.convolution", "from ...cpm_app import views"),
        ("cpm_app.model.document.edits", "from ...session import session"),
        ("cpm_app.model.document.edits", "from pyqtgraph import Point"),
        ("cpm_app.session.worker.worker_thread", "from PySide6 import QtWidgets"),
        ("cpm_app.session.worker.worker_thread", "import cpm_app.views.canvas.canvas"),
        ("cpm_app.views.canvas.canvas", "from cpm_app.__main__ import main"),
    ],
)
def test_the_rules_see_an_import_that_breaks_them(name, source):
    assert len(rules_broken(name, imports(ast.parse(source), name, is_package=False))) == 1


@pytest.mark.parametrize(
    ("name", "source"),
    [
        (
            "cpm_core.segmentation.engine",
            "import numpy\nfrom cpm_core.model import State\nfrom . import coulomb",
        ),
        (
            "cpm_app.session.session",
            "from PySide6.QtCore import QObject\nfrom cpm_app.model.document.document import Document",
        ),
        (
            "cpm_app.views.canvas.canvas",
            "import pyqtgraph\nfrom cpm_app.session.session import Session\nfrom ..model import edits",
        ),
    ],
)
def test_the_rules_let_proper_imports_pass(name, source):
    assert rules_broken(name, imports(ast.parse(source), name, is_package=False)) == []


def libraries(names):
    """Packages of others among dotted names."""
    return {name.split(".")[0] for name in names} - set(sys.stdlib_module_names) - {"cpm_core"}


def test_the_core_stands_on_few_libraries():
    late = {module_name(path): libraries(module(path).imported) - CORE_LIBRARIES for path in CORE}
    assert {name: others for name, others in late.items() if others} == LATE_LIBRARIES
    assert set().union(*(libraries(module(path).imported_at_once) for path in CORE)) <= CORE_LIBRARIES


def test_what_is_imported_late_is_told_from_what_is_imported_at_once():
    source = (
        "import numpy\nif TYPE_CHECKING:\n    import scipy\ndef f():\n    import numba\nclass A:\n    import PIL\n"
        "    def g(self):\n        import matplotlib\n"
    )
    assert libraries(imports(ast.parse(source), "cpm_core.a", is_package=False, at_once=True)) == {"numpy", "PIL"}


def test_parts_of_large_libraries_are_loaded_when_they_are_asked_for():
    """Loading these parts takes longer than all the rest, and a window wants to be seen before they are needed."""
    slow = {
        "scipy.linalg",
        "scipy.ndimage",
        "scipy.spatial",
        "scipy.fft",
        "scipy.special",
        "scipy.sparse",
        "skimage.measure",
        "matplotlib",
        "asyncio",
        "importlib.metadata",
    }
    code = "import sys, cpm_core.cli, cpm_app.model.document.document; print(*sys.modules)"
    command = [sys.executable, "-c", code]
    loaded = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    assert "cpm_core.segmentation.engine" in loaded
    assert slow.isdisjoint(loaded)


def test_no_part_of_a_large_library_is_named_where_a_module_is_loaded():
    """Such a part loads others with it, not the same in all releases; `skimage.draw.line(...)` loads it when called."""
    named = {
        f"{module_name(path)} imports {other}"
        for path in SOURCES
        for other in module(path).imported_at_once
        if other.startswith(("scipy.", "skimage."))
    }
    assert named == set()


SHARED_CONSTANTS = {
    "LOG": "each module has its own logger",
    "FILE_KINDS": "the reader of each format of images says what it reads",
    "WRITERS": "the results of images and of volumes in chunks are modules with the same face",
}
"""Names of constants that several modules define all the same, and why."""


def places_by_name(kind):
    """Modules that define each public class or constant, more than once if they do so."""
    places = defaultdict(list)
    for path in SOURCES:
        for name in getattr(module(path), kind):
            places[name].append(module_name(path))
    return {name: modules for name, modules in places.items() if len(modules) > 1}


def test_a_public_class_is_the_only_one_of_its_name():
    assert places_by_name("classes") == {}


def test_a_constant_is_the_only_one_of_its_name():
    repeated = places_by_name("constants")
    assert {name: modules for name, modules in repeated.items() if name not in SHARED_CONSTANTS} == {}
    assert SHARED_CONSTANTS.keys() <= repeated.keys(), "a permission that nobody needs any more"


def test_each_constant_has_an_assignment_of_its_own():
    assert {module_name(path): module(path).packed for path in SOURCES if module(path).packed} == {}


def test_constants_are_found():
    tree = ast.parse("A_B = 1\n_C_D: int = 2\n_E_F, G_H = 3, 4\nfield = 5\ndef f():\n    I_J = 6")
    assert constants(tree) == (["A_B", "C_D", "E_F", "G_H"], ["_E_F", "G_H"])


def test_no_module_is_a_box_for_odds_and_ends():
    boxes = {"utils", "util", "utilities", "helpers", "helper", "common", "misc", "tools_"}
    assert [path for path in SOURCES if path.stem in boxes] == []


def circles(arrows):
    """Groups of names that import one another, however indirectly; `arrows` maps each name to those it imports."""
    reached = {name: set() for name in arrows}
    for name in arrows:
        waiting = list(arrows[name])
        while waiting:
            other = waiting.pop()
            if other not in reached[name]:
                reached[name].add(other)
                waiting += arrows.get(other, ())
    groups = {
        frozenset(o for o in reached[name] if name in reached.get(o, ())) for name in arrows if name in reached[name]
    }
    return sorted(map(sorted, groups))


def arrows_between(names, depth=None):
    """What each module imports of the others, by dotted names cut to so many parts."""
    found = {}
    for path in SOURCES:
        name = module_name(path)
        at = ".".join(name.split(".")[:depth])
        for other in module(path).imported:
            known = next((part for part in prefixes(other) if part in names), None)
            if known is not None and known != name:
                to = ".".join(known.split(".")[:depth])
                if to != at:
                    found.setdefault(at, set()).add(to)
    return found


def prefixes(name):
    """A dotted name and the packages that it lies in, the longest first."""
    parts = name.split(".")
    return [".".join(parts[:length]) for length in range(len(parts), 0, -1)]


def test_no_module_imports_itself_by_way_of_others_not_even_for_types():
    assert circles(arrows_between({module_name(path) for path in SOURCES})) == []


@pytest.mark.parametrize("depth", [2, 3, 4])
def test_no_room_imports_itself_by_way_of_others(depth):
    names = {module_name(path) for path in SOURCES if path.name != "__init__.py" or path.parent.parent != ROOT}
    assert circles(arrows_between(names, depth)) == []


def folders_that_import_one_another():
    """Pairs of folders, a folder's own files taken as the folder."""
    folders = {module_name(path): path.parent.relative_to(ROOT).as_posix() for path in SOURCES}
    arrows = set()
    for path in SOURCES:
        for other in module(path).imported:
            known = next((part for part in prefixes(other) if part in folders), None)
            if known is not None:
                arrows.add((path.parent.relative_to(ROOT).as_posix(), folders[known]))
    return {(one, other) for one, other in arrows if one < other and (other, one) in arrows}


def test_no_folder_lies_both_above_and_below_another():
    """So that rooms can be drawn as floors: the files of a folder lie above all its subfolders, or below them."""
    assert folders_that_import_one_another() == set()


def test_circles_are_seen():
    arrows = {"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": {"a"}}
    assert circles(arrows) == [["b", "c"]]
    assert circles({"a": {"b"}, "b": {"c"}}) == []


def test_the_rooms_of_the_core_stand_on_those_before_them():
    def floor(name):
        return next((number for number, room in enumerate(FLOORS) if belongs(name, room)), None)

    above = {}
    for path in CORE:
        own = floor(module_name(path))
        if own is not None:
            above[module_name(path)] = [other for other in module(path).imported if (floor(other) or 0) > own]
    assert {name: others for name, others in above.items() if others} == {}


def test_the_top_level_holds_what_it_should_and_nothing_else():
    if (ROOT / ".git").exists() and shutil.which("git"):
        listing = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
        files = subprocess.run(listing, cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()
        names = {file.split("/")[0] for file in files}
    else:  # environments and build products may lie next to the source
        names = {path.name for path in ROOT.iterdir()} - {"build", "dist", "venv", "__pycache__", "PKG-INFO"}
    visible = {name for name in names if not name.startswith(".")}
    assert visible == {
        "pyproject.toml",
        "app",
        "cpm_core",
        "docs",
        "tests",
        "assets",
        "README.md",
        "ARCHITECTURE.md",
        "CHANGELOG.md",
        "CITATION.cff",
        "CONTRIBUTING.md",
        "LICENSE",
        "release",
    }


PAGE = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
NAMED = set(re.findall(r"`((?:[a-z_]+/)*[a-z_]+(?:/|\.py))`", PAGE))
"""Files and folders that the page on the architecture names."""

DIAGRAM = PAGE.split("```")[1]
MOST_WORDS = 1500


def rooms_in(folder):
    """Folders in this one that hold modules."""
    return sorted(path.parent.name for path in (ROOT / folder).glob("*/__init__.py"))


def test_the_page_names_what_is_there():
    assert [
        name for name in NAMED if not any((ROOT / at / name).exists() for at in (".", "cpm_core", "app/cpm_app"))
    ] == []


@pytest.mark.parametrize("folder", ["cpm_core", "app/cpm_app"])
def test_the_page_names_every_room(folder):
    short = "" if folder == "cpm_core" else "cpm_app/"
    unnamed = {room for room in rooms_in(folder) if not {f"{folder}/{room}/", f"{short}{room}/"} & NAMED}
    assert unnamed == set()


def rows_of_the_diagram():
    """Rooms of the core that each row of the diagram names before it says what they hold, from the top down."""
    rows = []
    for line in DIAGRAM.splitlines():
        for cell in re.split(r"[│▼]", line):
            names = re.split(r"\s{2,}", cell.strip())[0].replace("cpm_core/", "").split(", ")
            if set(names) <= set(rooms_in("cpm_core")):
                rows.append(names)
    return rows


def test_the_diagram_shows_the_rooms_of_the_core_in_their_order():
    floors = [room.removeprefix("cpm_core.") for room in FLOORS]
    assert sorted(floors) == rooms_in("cpm_core")
    rows = rows_of_the_diagram()
    assert sorted(room for row in rows for room in row) == sorted(floors)
    for upper, lower in pairwise(rows):
        assert min(map(floors.index, upper)) > max(map(floors.index, lower)), f"{upper} above {lower}"


def test_the_page_is_short():
    assert len(PAGE.split()) <= MOST_WORDS
