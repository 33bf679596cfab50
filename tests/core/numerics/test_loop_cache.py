"""Compiled loops are kept by the sources that they are made of, and nothing that is kept is ever wrong."""

import hashlib
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numba
import pytest

import cpm_core
from cpm_core.numerics.loop_cache import folders, versions
from cpm_core.numerics.loop_cache.shipped import Shipped, Target, shipped
from cpm_core.objects.warm_up.__main__ import common_target, ship

INNER = "from cpm_core.numerics.jit import compiled\n\n@compiled\ndef inner(x):\n    return x + {}\n"
OUTER = (
    "import sys\nimport numba\nfrom cpm_core.numerics.jit import compiled\nfrom cpm_core.inner import inner\n"
    "from cpm_core.constants import FACTOR\n\n@compiled\ndef outer(x):\n    return FACTOR * inner(x)\n\n"
    "@numba.njit(cache=True)\ndef foreign(x):\n    return x\n\n"
    "kept = outer.stats\n"
    "print(outer(10.0), kept.cache_path, foreign.stats.cache_path, sum(outer.stats.cache_hits.values()), sep='|')\n"
)


@pytest.fixture(scope="module")
def original(tmp_path_factory):
    """A small package of the same name, with the real modules that decide where loops are kept."""
    made = tmp_path_factory.mktemp("package") / "cpm_core"
    (made / "numerics").mkdir(parents=True)
    (made / "__init__.py").touch()
    real = Path(cpm_core.__file__).parent / "numerics"
    for name in ("__init__.py", "jit.py"):
        shutil.copy(real / name, made / "numerics")
    shutil.copytree(real / "loop_cache", made / "numerics" / "loop_cache", ignore=shutil.ignore_patterns("__pycache__"))
    (made / "inner.py").write_text(INNER.format(1.0))
    (made / "constants.py").write_text("FACTOR = 2.0\n")
    (made / "other.py").write_text("OTHER = 3.0\n")
    (made / "outer.py").write_text(OUTER)
    return made


@pytest.fixture
def package(original, tmp_path):
    """The small package, to be changed."""
    return Path(shutil.copytree(original, tmp_path / "package" / "cpm_core"))


def run(package, **environment):
    """What the outer loop gives, where it and a loop of another package are kept, and whether it was found there."""
    kept = {name: value for name, value in os.environ.items() if name not in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME")}
    kept |= {"PYTHONPATH": str(package.parent), "PYTHONDONTWRITEBYTECODE": "1", **environment}
    command = [sys.executable, "-m", "cpm_core.outer"]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=kept, cwd=package.parent)
    value, ours, foreign, hits = done.stdout.strip().split("|")
    return float(value), Path(ours), Path(foreign), int(hits)


@pytest.fixture(scope="module")
def first_run(original, tmp_path_factory):
    """The folder chosen for Numba after a first run, and what that run has told."""
    chosen = tmp_path_factory.mktemp("chosen")
    return chosen, run(original, NUMBA_CACHE_DIR=str(chosen))


@pytest.fixture
def filled(first_run, tmp_path):
    """A folder chosen for Numba that holds the loops of the small package."""
    return Path(shutil.copytree(first_run[0], tmp_path / "filled"))


def loops(folder):
    """Files of loops below a folder."""
    return sorted(folder.rglob("*.nbc"))


def test_a_loop_called_by_another_may_change_in_a_file_of_its_own(package, tmp_path):
    home = {"XDG_CACHE_HOME": str(tmp_path / "cache"), "LOCALAPPDATA": str(tmp_path / "cache"), "HOME": str(tmp_path)}
    value, ours, foreign, hits = run(package, **home)
    assert (value, hits) == (22.0, 0)
    assert tmp_path in ours.parents
    assert foreign == package / "__pycache__"
    assert run(package, **home)[::3] == (22.0, 1)
    (package / "inner.py").write_text(INNER.format(5.0))
    value, another, _, hits = run(package, **home)
    assert (value, hits) == (30.0, 0)
    assert another != ours
    assert another.parent == ours.parent


def test_a_home_that_cannot_be_written_to_is_no_obstacle(package, tmp_path):
    (tmp_path / "file").touch()
    nowhere = str(tmp_path / "file")  # nothing can be made below a file, by any user
    value, ours, _, _ = run(package, XDG_CACHE_HOME=nowhere, LOCALAPPDATA=nowhere, HOME=nowhere)
    assert value == 22.0
    assert package / "__pycache__" in ours.parents


def test_a_folder_chosen_for_numba_is_respected(first_run):
    chosen, (value, ours, foreign, hits) = first_run
    assert (value, hits) == (22.0, 0)
    assert chosen in ours.parents
    assert foreign.parent == chosen


@pytest.fixture
def version_of_outer(package, monkeypatch):
    """The version of the loops of the module `outer` of the small package, as another process would tell it."""

    def version():
        for remembered in (versions._version, versions._source, versions._imported):
            remembered.cache_clear()
        return versions.version("cpm_core.outer")

    monkeypatch.setattr(versions, "_folder", lambda name: package if name == "cpm_core" else None)
    yield version
    for remembered in (versions._version, versions._source, versions._imported):
        remembered.cache_clear()


@pytest.mark.parametrize(
    ("name", "source", "another"),
    [
        ("outer.py", OUTER + "# changed", True),
        ("inner.py", INNER.format(7.0), True),
        ("constants.py", "FACTOR = 9.0\n", True),
        ("other.py", "OTHER = 4.0\n", False),
        ("further.py", INNER.format(1.0), False),
    ],
)
def test_another_source_that_loops_depend_on_gives_another_version(package, version_of_outer, name, source, another):
    before = version_of_outer()
    assert version_of_outer() == before
    (package / name).write_text(source)
    assert (version_of_outer() != before) == another


@pytest.mark.parametrize(
    "imported",
    [
        "from cpm_core import other",
        "from cpm_core import (\n    constants,  # a comment, with a comma\n    other as another,\n)",
        "import cpm_core.other",
        "import sys, cpm_core.other as another",
        "from cpm_core.other import OTHER",
        "from cpm_core.between import BETWEEN",
    ],
)
def test_imports_of_every_form_are_followed_to_every_depth(package, version_of_outer, imported):
    (package / "between.py").write_text("from cpm_core.other import OTHER\n\nBETWEEN = 2.0 * OTHER\n")
    (package / "inner.py").write_text(f"{imported}\n{INNER.format(1.0)}")
    before = version_of_outer()
    (package / "other.py").write_text("OTHER = 4.0\n")
    assert version_of_outer() != before


def test_another_numba_gives_another_version(version_of_outer, monkeypatch):
    before = version_of_outer()
    monkeypatch.setattr(numba, "__version__", "0.1")
    assert version_of_outer() != before


def test_the_date_of_a_source_does_not_matter(package, version_of_outer):
    before = version_of_outer()
    os.utime(package / "inner.py", (1.0, 1.0))
    assert version_of_outer() == before


def test_the_sources_of_other_packages_do_not_matter(package, version_of_outer, monkeypatch):
    other = package.parent / "numba"
    other.mkdir()
    (other / "__init__.py").write_text("A = 1")
    monkeypatch.setattr(versions, "_folder", lambda name: package.parent / name)
    before = version_of_outer()
    (other / "__init__.py").write_text("A = 2")
    assert version_of_outer() == before


def test_without_sources_there_is_no_version(monkeypatch, tmp_path, version_of_outer):
    monkeypatch.setattr(versions, "_folder", lambda name: tmp_path / "frozen")
    assert version_of_outer() == ""


def test_versions_not_used_for_long_are_removed_and_nothing_else(tmp_path):
    kept = tmp_path / "cpm" / "loops"
    long_ago = time.time() - 40 * 86400.0
    for path in (kept / "a-old", kept / "a-recent", kept.parent / "loops-0123456789abcdef", kept.parent / "pictures"):
        (path / "folder").mkdir(parents=True)
        (path / "folder" / "a.nbc").touch()
        if path.name != "a-recent":
            os.utime(path, (long_ago, long_ago))
    folders.remove_unused(kept)
    assert {path.name for path in kept.parent.glob("**/*-*")} == {"a-recent"}
    assert (kept.parent / "pictures" / "folder" / "a.nbc").exists()


def test_a_version_in_use_is_not_taken_for_an_old_one(tmp_path):
    os.utime(tmp_path, (1.0, 1.0))
    folders.in_use(tmp_path)
    assert tmp_path.stat().st_mtime > time.time() - 3600.0


@pytest.mark.parametrize(
    ("platform", "environment", "expected"),
    [
        ("linux", {"XDG_CACHE_HOME": "/cache"}, Path("/cache")),
        ("linux", {"XDG_CACHE_HOME": "relative"}, Path("/home/ada/.cache")),
        ("linux", {}, Path("/home/ada/.cache")),
        ("darwin", {"XDG_CACHE_HOME": "/cache"}, Path("/home/ada/Library/Caches")),
        ("win32", {"LOCALAPPDATA": "/local"}, Path("/local")),
        ("win32", {}, Path("/home/ada/AppData/Local")),
    ],
)
def test_each_platform_has_its_place(monkeypatch, platform, environment, expected):
    for name in ("XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(sys, "platform", platform)
    monkeypatch.setattr(Path, "home", lambda: Path("/home/ada"))
    assert folders.user_cache() == expected


def cut(content):
    return content[: len(content) // 2]


def spoiled(content):
    """One byte in the middle, where the code is, is another one."""
    middle = len(content) // 2
    return content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :]


@pytest.mark.parametrize("damage", [cut, spoiled])
def test_a_damaged_file_is_dropped_and_its_loop_compiled_and_kept_again(package, filled, damage):
    whole = {file: file.read_bytes() for file in loops(filled)}
    assert len(whole) == 2
    for file, content in whole.items():
        file.write_bytes(damage(content))
    value, *_, hits = run(package, NUMBA_CACHE_DIR=str(filled))
    assert (value, hits) == (22.0, 0)
    for file in whole:
        content = file.read_bytes()
        assert hashlib.sha256(content[:-32]).digest() == content[-32:]


def test_loops_are_compiled_where_nothing_can_be_kept(package, tmp_path):
    (package / "outer.py").write_text(
        "from pathlib import Path\n\n"
        "def full(*_):\n    raise OSError(28, 'No space left on device')\n\n"
        f"Path.write_bytes = full\n{OUTER}"
    )
    value, *_, hits = run(package, NUMBA_CACHE_DIR=str(tmp_path / "chosen"))
    assert (value, hits) == (22.0, 0)


def test_what_a_killed_process_has_left_is_no_kept_loop(package, filled):
    for file in loops(filled):
        file.replace(file.with_suffix(".tmp"))
    value, *_, hits = run(package, NUMBA_CACHE_DIR=str(filled))
    assert (value, hits) == (22.0, 0)


@pytest.fixture(scope="module")
def made_for_all(original, tmp_path_factory):
    """A folder of loops for all processors of this kind."""
    made, target = tmp_path_factory.mktemp("made"), common_target()
    run(original, NUMBA_CACHE_DIR=str(made), NUMBA_CPU_NAME=target.processor, NUMBA_CPU_FEATURES=target.features)
    assert ship(made / folders.PLACE, made / "compiled", target) == 2
    return made / "compiled"


@pytest.fixture
def bringing(package, made_for_all):
    """The small package with its loops compiled, at another place and of another date."""
    shutil.copytree(made_for_all, package / "compiled")
    os.utime(package / "outer.py", (1.0, 1.0))
    return package


def test_loops_that_a_package_brings_are_not_compiled_and_nothing_is_written(bringing, tmp_path):
    before = sorted((path, path.stat().st_mtime_ns) for path in bringing.rglob("*"))
    value, *_, hits = run(bringing, NUMBA_CACHE_DIR=str(tmp_path / "user"))
    assert (value, hits) == (22.0, 1)
    assert loops(tmp_path / "user") == []
    assert sorted((path, path.stat().st_mtime_ns) for path in bringing.rglob("*")) == before


def test_damaged_loops_that_a_package_brings_count_for_nothing(bringing, tmp_path):
    for file in loops(bringing):
        file.write_bytes(spoiled(file.read_bytes()))
    value, *_, hits = run(bringing, NUMBA_CACHE_DIR=str(tmp_path / "user"))
    assert (value, hits) == (22.0, 0)
    assert len(loops(tmp_path / "user")) == 2


def test_another_folder_of_loops_is_named_by_the_environment(package, made_for_all, tmp_path):
    assert run(package, NUMBA_CACHE_DIR=str(tmp_path / "user"), CPM_LOOPS=str(made_for_all))[3] == 1


@pytest.mark.parametrize(
    ("what", "other"),
    [
        ('"features": "', '"features": "+newer,'),
        ('"numba": "', '"numba": "9'),
        ('"python": "', '"python": "py'),
        ('"triple": "', '"triple": "z'),
        ("{", "["),
        ('"numba"', '"number"'),
    ],
)
def test_loops_for_something_else_count_for_nothing(made_for_all, tmp_path, monkeypatch, what, other):
    target = tmp_path / "compiled" / "target.json"
    target.parent.mkdir()
    target.write_text((made_for_all / target.name).read_text())
    monkeypatch.setenv("CPM_LOOPS", str(made_for_all))
    assert shipped() == Shipped(made_for_all, common_target())
    target.write_text(target.read_text().replace(what, other, 1))
    monkeypatch.setenv("CPM_LOOPS", str(target.parent))
    assert shipped() is None


def test_where_there_are_no_sources_the_loops_that_are_brought_are_those_of_the_program(tmp_path):
    brought = Shipped(tmp_path, Target("", "", ""))
    (tmp_path / "cpm_core.loops-0123456789abcdef").mkdir()
    assert brought.of_module("cpm_core.loops", "") == tmp_path / "cpm_core.loops-0123456789abcdef"
    assert brought.of_module("cpm_core.loop", "") is None


@pytest.mark.parametrize(
    ("triple", "features", "runs"),
    [
        ("x86_64-unknown-linux-gnu", "+sse2,+avx2,-sha", True),
        ("x86_64-unknown-linux-gnu", "+sse2,+avx512f", False),
        ("aarch64-unknown-linux-gnu", "", False),
        ("x86_64-apple-darwin22.4.0", "", False),
    ],
)
def test_code_runs_where_the_system_is_the_same_and_no_feature_is_missing(triple, features, runs):
    here = Target("x86_64-unknown-linux-gnu", "skylake", "+sse2,+avx,+avx2,-avx512f")
    assert Target(triple, "x86-64", features).runs_on(here) == runs


def test_the_version_of_a_system_does_not_matter():
    older, newer = (Target(f"arm64-apple-darwin{version}", "generic", "") for version in ("22.4.0", "23.1.0"))
    assert older.runs_on(newer)
