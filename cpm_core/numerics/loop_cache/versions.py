"""The version of a module's loops: a name that changes with every source that they may depend on."""

from __future__ import annotations

import hashlib
import re
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numba

_IMPORT = re.compile(r"^(?:from ([\w.]+) )?import (\([^)]*\)|.*)", re.MULTILINE)

_OURS = __name__.partition(".")[0]


def module_of(function: Callable[..., Any]) -> str:
    """Name under which the module of a function is imported, also where the module is started as a program."""
    spec = function.__globals__.get("__spec__")
    return str(spec.name if spec is not None else function.__module__)


def version(module: str) -> str:
    """Name of the version of a module's loops: sixteen hexadecimal digits; empty when there is no source to read.

    It changes with the source of the module, with those of all modules of the program that it imports, and so on: a
    loop holds copies of the constants that it uses, which may depend on other constants, and of tuple classes. It
    changes with Numba and Python as well, and not with the place of the sources or their dates.
    """
    return _version(module, numba.__version__)


@cache
def _version(module: str, of_numba: str) -> str:
    if _source(module) is None:
        return ""
    ours = {_OURS, module.partition(".")[0]}
    needed: set[str] = set()
    waiting = [module]
    while waiting:
        name = waiting.pop()
        if name not in needed and name.partition(".")[0] in ours and _source(name) is not None:
            needed.add(name)
            waiting += _imported(name)
    found = hashlib.sha256(f"{of_numba} {sys.implementation.cache_tag}".encode())
    for name in sorted(needed):
        found.update(name.encode() + b"\0" + (_source(name) or b"") + b"\0")
    return found.hexdigest()[:16]


@cache
def _source(module: str) -> bytes | None:
    """Source of a module; None where there is no file with it, as when the program is frozen."""
    package, *inner = module.split(".")
    folder = _folder(package)
    if folder is None:
        return None
    path = folder.joinpath(*inner)
    found = next((file for file in (path / "__init__.py", path.with_name(f"{path.name}.py")) if file.is_file()), None)
    return found.read_bytes() if found is not None else None


def _folder(package: str) -> Path | None:
    """Folder of a package that has been imported."""
    file = getattr(sys.modules.get(package), "__file__", None)
    return Path(file).parent if file else None


@cache
def _imported(module: str) -> frozenset[str]:
    """Names of everything that a module imports at its top: modules, or what may be a module of a package.

    The source is read as text: parsing all sources would take longer than the start of the program.
    """
    source = (_source(module) or b"").decode()
    names: set[str] = set()
    for package, what in _IMPORT.findall(re.sub("#.*", "", source)):
        parts = [part.split()[0] for part in what.strip("()").split(",") if part.strip()]
        names |= {package, *(f"{package}.{part}" for part in parts)} if package else set(parts)
    return frozenset(names)
