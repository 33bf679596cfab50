"""Where compiled loops are kept between runs: a folder of the user's for each version of the loops.

Numba tells by the file of a loop alone whether what it has kept of it is still good. A loop that calls another keeps a
copy of it, and names the classes of the tuples that it takes: when these change in a file of their own, what was kept
is stale, or cannot be read and is not replaced either. Here the folder is named after the sources of all loops and the
version of Numba, so that another version of the program never sees what this one has kept.
"""

from __future__ import annotations

import glob
import hashlib
import os
import re
import shutil
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any

import numba

_IMPORT = re.compile(r"^(?:from ([\w.]+) )?import (\([^)]*\)|.*)", re.MULTILINE)

_SETTINGS: Any = numba.config  # its names are made when it is loaded, so that no type checker knows them

_PREFIX = "loops-"
_UNUSED_DAYS = 30.0
"""Days after which the folder of another version is removed if no program has started with it meanwhile."""


@contextmanager
def kept_with_the_sources() -> Iterator[None]:
    """While this lasts, loops that are declared are kept in the folder of their version.

    Numba's setting is put back at once, so that loops of other packages stay where they are.
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
    """Folder in which the loops of this very program are kept; None where Numba chooses."""
    return folder(Path(__file__).parents[1], _SETTINGS.CACHE_DIR)


def take_over(aside: Path, kept: Path) -> None:
    """Move what another process has kept in `aside` to where it would have been, loops that are kept there excepted.

    Of each loop there is an index, which is moved last: it names the files that hold the loop.
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
    """Name of a version of the loops: changes with any source that one may depend on, with Numba and with Python.

    These are the modules of a package that have loops, those of it that they import, and so on: a loop takes over the
    constants that it uses, which may be made of others, and the classes of tuples.

    Parameters
    ----------
    package : Path
        Folder of the package.

    Returns
    -------
    str
        Sixteen hexadecimal digits; empty when there are no sources to be read, as in a frozen program.
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
    """Names of all that a source imports at its top, modules or what may be one of a package.

    Read as text: to parse all sources would take longer than to start the program.
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
    """Folder in which programs of the user keep what they can make anew, by the rules of the platform.

    Raises
    ------
    RuntimeError
        When the user has no home.
    """
    if sys.platform == "win32":
        given = os.environ.get("LOCALAPPDATA", "")
        return Path(given) if given else Path.home() / "AppData" / "Local"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches"
    given = os.environ.get("XDG_CACHE_HOME", "")
    return Path(given) if Path(given).is_absolute() else Path.home() / ".cache"


@cache
def folder(package: Path, chosen: str) -> Path | None:
    """Folder of this version, made if need be; None leaves the choice to Numba.

    Parameters
    ----------
    package : Path
        Where the sources are.
    chosen : str
        Folder that the user has told Numba to keep everything in; empty for none.
    """
    try:
        name = digest(package)
        if not name:
            return None
        made = (Path(chosen) if chosen else user_cache() / "cpm") / f"{_PREFIX}{name}"
        is_new = not made.is_dir()
        made.mkdir(parents=True, exist_ok=True)
        os.utime(made)  # in use
    except (OSError, RuntimeError):  # no home, or one that cannot be written to: Numba has places of its own
        return None
    if is_new:
        _remove_unused(made)
    return made


def _remove_unused(kept: Path) -> None:
    """Remove the folders of other versions that have not been used for long."""
    oldest = time.time() - _UNUSED_DAYS * 86400.0
    for other in kept.parent.glob(f"{_PREFIX}*"):
        with suppress(OSError):  # another program may be removing it as well
            if other != kept and other.stat().st_mtime < oldest:
                shutil.rmtree(other)
