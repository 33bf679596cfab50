"""The cache of compiled loops: a folder of the user for each version of the loops.

Numba decides by the file of a loop alone whether its cached code is still valid. But a loop that calls another one
holds a copy of it, and it names the tuple classes that it takes: when these change in another file, the cached code is
out of date, or cannot be read and is not replaced. Here the folder is named after the sources of all loops and the
version of Numba, so that one version of the program never reads the cache of another.
"""

from __future__ import annotations

import glob
import hashlib
import os
import re
import shutil
import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any

import numba

_IMPORT = re.compile(r"^(?:from ([\w.]+) )?import (\([^)]*\)|.*)", re.MULTILINE)

_SETTINGS: Any = numba.config  # its names are made when it is loaded, so that type checkers do not know them

_PREFIX = "loops-"
ASIDE = "aside-"
"""Beginning of the name of a folder in which another process compiles."""

_ABANDONED_HOURS = 1.0
"""Hours after which the folder of another process is removed: that process was killed."""

_UNUSED_DAYS = 30.0
"""Days after which the folder of another version is removed if no program has used it."""


@contextmanager
def cached_by_version() -> Iterator[None]:
    """Within this context, loops that are declared are cached in the folder of their version.

    Numba's setting is restored at the end, so that loops of other packages are cached as usual.
    """
    before = _SETTINGS.CACHE_DIR
    kept = folder_of_this_package()
    if kept is not None:
        _SETTINGS.CACHE_DIR = str(kept)
    try:
        yield
    finally:
        _SETTINGS.CACHE_DIR = before


def folder_of_this_package() -> Path | None:
    """Cache folder of this program's loops; None where Numba chooses."""
    return folder(Path(__file__).parents[1], _SETTINGS.CACHE_DIR)


def has_loops(kept: Path) -> bool:
    """Whether a folder holds compiled loops; those that other processes make aside do not count."""
    return any(not index.relative_to(kept).parts[0].startswith(ASIDE) for index in kept.rglob("*.nbi"))


def take_over(aside: Path, kept: Path) -> None:
    """Move the loops that another process has cached in `aside` to `kept`, except those that are already there.

    Each loop has an index, which names the files that hold its code and is therefore moved last.
    """
    for source in aside.glob(f"{_PREFIX}*"):
        for index in sorted(source.rglob("*.nbi")):
            target = kept / index.relative_to(source)
            if not target.exists():
                target.parent.mkdir(parents=True, exist_ok=True)
                for file in index.parent.glob(f"{glob.escape(index.stem)}.*.nbc"):
                    file.replace(target.parent / file.name)
                index.replace(target)


def digest(package: Path) -> str:
    """Name of a version of the loops: it changes with every source that a loop may depend on, with Numba and Python.

    These are the modules of a package that have loops, the modules that they import, and so on: a loop holds copies of
    the constants that it uses, which may depend on other constants, and of tuple classes. Returns sixteen hexadecimal
    digits; an empty string when there are no sources to read, as in a frozen program.
    """
    paths = {_dotted(path, package): path for path in sorted(package.rglob("*.py"))}
    sources = {name: path.read_bytes() for name, path in paths.items()}
    imports = {name: _imported(source.decode()) & sources.keys() for name, source in sources.items()}
    waiting = [name for name in sources if f"{package.name}.numerics.jit" in imports[name]]
    needed: set[str] = set()
    while waiting:
        name = waiting.pop()
        if name not in needed:
            needed.add(name)
            waiting += imports[name]
    found = hashlib.sha256(f"{numba.__version__} {sys.implementation.cache_tag}".encode())
    for name in sorted(needed):
        found.update(paths[name].relative_to(package).as_posix().encode() + b"\0" + sources[name] + b"\0")
    return found.hexdigest()[:16] if needed else ""


def _imported(source: str) -> set[str]:
    """Names of everything that a source imports at its top: modules, or what may be a module of a package.

    The source is read as text: parsing all sources would take longer than the start of the program.
    """
    names: set[str] = set()
    for package, what in _IMPORT.findall(re.sub("#.*", "", source)):
        parts = [part.split()[0] for part in what.strip("()").split(",") if part.strip()]
        names |= {package, *(f"{package}.{part}" for part in parts)} if package else set(parts)
    return names


def _dotted(path: Path, package: Path) -> str:
    """Name under which a module of a package is imported."""
    parts = path.relative_to(package.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def user_cache() -> Path:
    """Folder for the user's caches, by the rules of the platform; `RuntimeError` when the user has no home."""
    if sys.platform == "win32":
        given = os.environ.get("LOCALAPPDATA", "")
        return Path(given) if given else Path.home() / "AppData" / "Local"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches"
    given = os.environ.get("XDG_CACHE_HOME", "")
    return Path(given) if Path(given).is_absolute() else Path.home() / ".cache"


@cache
def folder(package: Path, chosen: str) -> Path | None:
    """Cache folder of this version, made if it is missing; None leaves the choice to Numba.

    `package` is the folder of the sources, `chosen` the cache folder that the user has set for Numba, empty for none.
    """
    try:
        name = digest(package)
        if not name:
            return None
        made = (Path(chosen) if chosen else user_cache() / "cpm") / f"{_PREFIX}{name}"
        is_new = not made.is_dir()
        made.mkdir(parents=True, exist_ok=True)
        os.utime(made)  # in use
    except (OSError, RuntimeError):  # no home, or one that cannot be written to: Numba has folders of its own
        return None
    _remove_old(made.glob(f"{ASIDE}*"), _ABANDONED_HOURS / 24.0)
    if is_new:
        _remove_old((other for other in made.parent.glob(f"{_PREFIX}*") if other != made), _UNUSED_DAYS)
    return made


def _remove_old(folders: Iterable[Path], days: float) -> None:
    """Remove folders that have not been used for so long."""
    oldest = time.time() - days * 86400.0
    for other in folders:
        with suppress(OSError):  # another program may be removing it as well
            if other.stat().st_mtime < oldest:
                shutil.rmtree(other)
