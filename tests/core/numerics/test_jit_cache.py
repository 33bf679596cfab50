"""Compiled loops are kept by the sources that they are made of, and nothing that is kept is ever wrong."""

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numba
import pytest

import cpm_core
from cpm_core.numerics import jit_cache

INNER = "from cpm_core.numerics.jit import compiled\n\n@compiled\ndef inner(x):\n    return x + {}\n"
OUTER = (
    "import sys\nimport numba\nfrom cpm_core.numerics.jit import compiled\nfrom cpm_core.inner import inner\n"
    "from cpm_core.constants import FACTOR\n\n@compiled\ndef outer(x):\n    return FACTOR * inner(x)\n\n"
    "@numba.njit(cache=True)\ndef foreign(x):\n    return x\n\n"
    "kept = outer.stats\n"
    "print(outer(10.0), kept.cache_path, foreign.stats.cache_path, sum(outer.stats.cache_hits.values()), sep='|')\n"
)


@pytest.fixture
def package(tmp_path):
    """A small package of the same name, with the real modules that decide where loops are kept."""
    made = tmp_path / "cpm_core"
    (made / "numerics").mkdir(parents=True)
    (made / "__init__.py").touch()
    for name in ("__init__.py", "jit.py", "jit_cache.py", "kept_loops.py"):
        shutil.copy(Path(cpm_core.__file__).parent / "numerics" / name, made / "numerics")
    (made / "inner.py").write_text(INNER.format(1.0))
    (made / "constants.py").write_text("FACTOR = 2.0\n")
    (made / "other.py").write_text("OTHER = 3.0\n")
    (made / "outer.py").write_text(OUTER)
    return made


def run(package, **environment):
    """What the outer loop gives, where it and a loop of another package are kept, and whether it was found there."""
    kept = {name: value for name, value in os.environ.items() if name not in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME")}
    kept |= {"PYTHONPATH": str(package.parent), "PYTHONDONTWRITEBYTECODE": "1", **environment}
    command = [sys.executable, "-m", "cpm_core.outer"]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=kept, cwd=package.parent)
    value, ours, foreign, hits = done.stdout.strip().split("|")
    return float(value), Path(ours), Path(foreign), int(hits)


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


def test_a_home_that_cannot_be_written_to_is_no_obstacle(package, tmp_path):
    (tmp_path / "file").touch()
    nowhere = str(tmp_path / "file")  # nothing can be made below a file, by any user
    value, ours, _, _ = run(package, XDG_CACHE_HOME=nowhere, LOCALAPPDATA=nowhere, HOME=nowhere)
    assert value == 22.0
    assert ours == package / "__pycache__"


def test_a_folder_chosen_for_numba_is_respected(package, tmp_path):
    value, ours, foreign, _ = run(package, NUMBA_CACHE_DIR=str(tmp_path / "chosen"))
    assert value == 22.0
    assert ours.parent.parent == foreign.parent == tmp_path / "chosen"


@pytest.mark.parametrize(
    ("name", "source", "another"),
    [
        ("inner.py", INNER.format(7.0), True),
        ("constants.py", "FACTOR = 9.0\n", True),
        ("other.py", "OTHER = 4.0\n", False),
        ("further.py", INNER.format(1.0), True),
    ],
)
def test_another_source_that_loops_depend_on_gives_another_version(package, name, source, another):
    before = jit_cache.digest(package)
    assert jit_cache.digest(package) == before
    (package / name).write_text(source)
    assert (jit_cache.digest(package) != before) == another


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
def test_imports_of_every_form_are_followed_to_every_depth(package, imported):
    (package / "between.py").write_text("from cpm_core.other import OTHER\n\nBETWEEN = 2.0 * OTHER\n")
    (package / "inner.py").write_text(f"{imported}\n{INNER.format(1.0)}")
    before = jit_cache.digest(package)
    (package / "other.py").write_text("OTHER = 4.0\n")
    assert jit_cache.digest(package) != before


@pytest.mark.parametrize("imported", ["from cpm_core.numerics import jit", "import cpm_core.numerics.jit as jit"])
def test_loops_are_found_in_every_form_of_the_import_of_their_compiler(package, imported):
    before = jit_cache.digest(package)
    (package / "other.py").write_text(f"{imported}\n\n@jit.compiled\ndef other(x):\n    return x\n")
    assert jit_cache.digest(package) != before


def test_another_numba_gives_another_version(package, monkeypatch):
    before = jit_cache.digest(package)
    monkeypatch.setattr(numba, "__version__", "0.1")
    assert jit_cache.digest(package) != before


def test_the_date_of_a_source_does_not_matter(package):
    before = jit_cache.digest(package)
    os.utime(package / "inner.py", (1.0, 1.0))
    assert jit_cache.digest(package) == before


def test_without_sources_the_choice_is_left_to_numba(tmp_path):
    assert jit_cache.folder(tmp_path, str(tmp_path / "chosen")) is None
    assert list(tmp_path.iterdir()) == []


def test_versions_not_used_for_long_are_removed_and_nothing_else(package, tmp_path):
    chosen = tmp_path / "chosen"
    long_ago = time.time() - 40 * 86400.0
    for name in ("loops-old", "loops-recent", "another-program"):
        (chosen / name / "folder").mkdir(parents=True)
        (chosen / name / "folder" / "a.nbc").touch()
    for name in ("loops-old", "another-program"):
        os.utime(chosen / name, (long_ago, long_ago))
    made = jit_cache.folder(package, str(chosen))
    assert made is not None
    assert {path.name for path in chosen.iterdir()} == {"loops-recent", "another-program", made.name}


def test_a_version_in_use_is_not_taken_for_an_old_one(package, tmp_path):
    name = f"loops-{jit_cache.digest(package)}"
    kept = tmp_path / "chosen" / name
    kept.mkdir(parents=True)
    os.utime(kept, (1.0, 1.0))
    assert jit_cache.folder(package, str(tmp_path / "chosen")) == kept
    assert kept.stat().st_mtime > time.time() - 3600.0


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
    assert jit_cache.user_cache() == expected


def test_the_setting_of_numba_is_restored(monkeypatch):
    monkeypatch.setattr(numba.config, "CACHE_DIR", "as it was")
    monkeypatch.setattr(jit_cache, "folder", lambda package, chosen: Path("elsewhere"))
    with pytest.raises(ZeroDivisionError), jit_cache.cached_by_version():
        assert numba.config.CACHE_DIR == "elsewhere"
        raise ZeroDivisionError
    assert numba.config.CACHE_DIR == "as it was"


def cut(content):
    return content[: len(content) // 2]


def spoiled(content):
    """One byte in the middle, where the code is, is another one."""
    middle = len(content) // 2
    return content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :]


@pytest.mark.parametrize(("suffix", "damage"), [(".nbi", cut), (".nbc", cut), (".nbc", spoiled)])
def test_a_damaged_file_is_dropped_and_its_loop_compiled_and_kept_again(package, tmp_path, suffix, damage):
    chosen = {"NUMBA_CACHE_DIR": str(tmp_path / "chosen")}
    _, ours, *_ = run(package, **chosen)
    files = list(ours.glob(f"*{suffix}"))
    assert files
    for file in files:
        file.write_bytes(damage(file.read_bytes()))
    assert run(package, **chosen)[0] == 22.0
    value, *_, hits = run(package, **chosen)
    assert (value, hits) == (22.0, 1)


def test_loops_are_compiled_where_nothing_can_be_kept(package, tmp_path, monkeypatch):
    (package / "outer.py").write_text(
        "import numba.core.caching as caching\n\n"
        "def full(*_):\n    raise OSError(28, 'No space left on device')\n\n"
        f"caching.IndexDataCacheFile._save_data = full\n{OUTER}"
    )
    value, *_, hits = run(package, NUMBA_CACHE_DIR=str(tmp_path / "chosen"))
    assert (value, hits) == (22.0, 0)


def test_what_a_killed_process_has_left_is_no_kept_loop_and_is_removed(package, tmp_path):
    kept = tmp_path / "chosen" / f"loops-{jit_cache.digest(package)}"
    index = kept / "aside-77-step_once" / "loops-x" / "a.nbi"
    fresh = kept / "aside-78-step_once"
    index.parent.mkdir(parents=True)
    fresh.mkdir()
    index.touch()
    assert not jit_cache.has_loops(kept)
    os.utime(kept / "aside-77-step_once", (1.0, 1.0))
    assert jit_cache.folder(package, str(tmp_path / "chosen")) == kept
    assert list(kept.iterdir()) == [fresh]
    (kept / "sub").mkdir()
    (kept / "sub" / "b.nbi").touch()
    assert jit_cache.has_loops(kept)
