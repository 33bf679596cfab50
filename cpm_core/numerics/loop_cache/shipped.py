"""Loops that the program brings compiled, in a folder that is only read.

Code for one processor runs on another if that has every feature the code makes use of. The folder says for which Numba,
Python, system and features its loops are compiled; where these do not fit, or are not as they were, it counts for
nothing, and the loops are compiled on the first start.
"""

from __future__ import annotations

import json
import os
import re
import sys
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numba
from llvmlite import binding as llvmlite
from numba.core.codegen import get_host_cpu_features

FOLDER_VARIABLE = "CPM_LOOPS"
"""Environment variable that names another folder of loops than the package's own; empty for none."""

_OWN = Path(__file__).parents[2] / "compiled"
_TARGET = "target.json"

_SETTINGS: Any = numba.config  # its names are made when it is loaded, so that type checkers do not know them


class Target(NamedTuple):
    """What code is compiled for, as Numba names it."""

    triple: str
    processor: str
    features: str

    def runs_on(self, host: Target) -> bool:
        """Whether code for this target runs on another."""
        return _system(self.triple) == _system(host.triple) and _used(self.features) <= _used(host.features)


class Shipped(NamedTuple):
    """A folder of compiled loops, and what they are compiled for."""

    folder: Path
    target: Target

    def of_module(self, module: str, version: str) -> Path | None:
        """Folder of a module's loops; of the one version that there is, where no source tells a version."""
        if version:
            return self.folder / f"{module}-{version}"
        return next(iter(sorted(self.folder.glob(f"{module}-*"))), None)


def shipped() -> Shipped | None:
    """The folder of loops that the program brings, if they run with this Numba and Python on this computer."""
    return _read(os.environ.get(FOLDER_VARIABLE, str(_OWN)))


@cache
def _read(folder: str) -> Shipped | None:
    if not folder:
        return None
    try:
        told = json.loads((Path(folder) / _TARGET).read_text(encoding="utf-8"))
        made_with = told["numba"], told["python"]
        target = Target(str(told["triple"]), str(told["processor"]), str(told["features"]))
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return Shipped(Path(folder), target) if made_with == _versions() and target.runs_on(host()) else None


def host() -> Target:
    """What Numba compiles for on this computer; as it names it itself, but known before it has begun."""
    name, features = _SETTINGS.CPU_NAME, _SETTINGS.CPU_FEATURES
    return Target(
        llvmlite.get_default_triple(),
        llvmlite.get_host_cpu_name() if name is None else name,
        get_host_cpu_features() if features is None else features,
    )


def describe(folder: Path, target: Target) -> None:
    """Write beside loops what they are compiled for."""
    numba_version, python = _versions()
    told = {"numba": numba_version, "python": python, **target._asdict()}
    (folder / _TARGET).write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")


def _versions() -> tuple[str, str | None]:
    return numba.__version__, sys.implementation.cache_tag


def _system(triple: str) -> tuple[str, str]:
    """Processor family and system of a triple, without the version of the system."""
    return triple.partition("-")[0], re.sub(r"[\d.]", "", triple.partition("-")[2])


def _used(features: str) -> set[str]:
    return {name for name in features.split(",") if name.startswith("+")}
