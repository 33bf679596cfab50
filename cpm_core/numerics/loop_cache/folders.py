"""The folders in which loops are kept for a user, one for each version of a module's loops."""

from __future__ import annotations

import hashlib
import os
import shutil
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import numba

from cpm_core.numerics.loop_cache.shipped import host, shipped
from cpm_core.numerics.loop_cache.versions import version

SUFFIX = ".nbc"

PLACE = Path("cpm", "loops")
"""Place of the loops within the user's caches, or within the folder that is chosen for Numba."""

_SETTINGS: Any = numba.config  # its names are made when it is loaded, so that type checkers do not know them

_UNUSED_DAYS = 30.0
"""Days after which the folder of another version is removed if no program has used it."""


def kept_folder() -> Path | None:
    """Folder of all loops that are kept for the user: in the folder chosen for Numba, or among the user's caches.

    Where these cannot be written to it lies beside the sources; None when nothing can be written at all.
    """
    return _first_usable(str(_SETTINGS.CACHE_DIR))


@cache
def _first_usable(chosen: str) -> Path | None:
    places: tuple[Callable[[], Path], ...] = (
        lambda: Path(chosen) if chosen else user_cache(),
        lambda: Path(__file__).parents[2] / "__pycache__",
    )
    for place in places:
        with suppress(OSError, RuntimeError):  # no home, or one that cannot be written to
            folder = place() / PLACE
            folder.mkdir(parents=True, exist_ok=True)
            if os.access(folder, os.W_OK):
                return folder
    return None


def user_cache() -> Path:
    """Folder for the user's caches, by the rules of the platform; `RuntimeError` when the user has no home."""
    if sys.platform == "win32":
        given = os.environ.get("LOCALAPPDATA", "")
        return Path(given) if given else Path.home() / "AppData" / "Local"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches"
    given = os.environ.get("XDG_CACHE_HOME", "")
    return Path(given) if Path(given).is_absolute() else Path.home() / ".cache"


def of_module(module: str) -> tuple[Path | None, Path | None]:
    """The folder in which the program brings loops of a module, and that in which they are kept for the user.

    The second is one for each kind of processor, since computers may share the user's folders.
    """
    brought, kept = shipped(), kept_folder()
    package = brought.of_module(module, version(module)) if brought is not None else None
    name = f"{module}-{version(module)}" if version(module) else package.name if package is not None else ""
    return package, kept / f"{name}-{_processor()}" if kept is not None and name else None


def has_loops(module: str) -> bool:
    """Whether loops of a module are kept, or brought by the program."""
    return any(folder is not None and any(folder.glob(f"*{SUFFIX}")) for folder in of_module(module))


@cache
def _processor() -> str:
    """Eight hexadecimal digits for a kind of processor."""
    return hashlib.sha256(repr(host()).encode()).hexdigest()[:8]


def in_use(folder: Path) -> None:
    """Note that the loops of a module are used, so that they are not taken for old ones."""
    with suppress(OSError):
        os.utime(folder)


def remove_unused(folder: Path) -> None:
    """Remove the loops of versions that no program has used for long, also those that were kept in another way."""
    oldest = time.time() - _UNUSED_DAYS * 86400.0
    for other in (*folder.iterdir(), *folder.parent.glob("loops-*")):
        with suppress(OSError):  # another program may be removing it as well
            if other.stat().st_mtime < oldest:
                shutil.rmtree(other)
