"""What the program depends on: its requirements, their oldest allowed releases, and licenses."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping
from email.message import Message
from importlib.metadata import distributions
from itertools import chain
from pathlib import Path
from typing import cast

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[2]

_GPL = re.compile(r"\bA?GPL|(?<!LESSER )\bGENERAL PUBLIC LICENSE")
_CHOICE = re.compile(r"\bOR\b|;")


def requirements() -> list[Requirement]:
    """All requirements of the program at run time, with those of its optional parts but the plugin for napari."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    parts = (project["optional-dependencies"][part] for part in ("gui", "formats", "scale", "all"))
    named = map(Requirement, (*project["dependencies"], *chain.from_iterable(parts)))
    return [required for required in named if required.name != project["name"]]


def oldest(required: Requirement) -> str:
    """The oldest allowed release of a requirement, as a requirement; ValueError when none is named."""
    lowest = [bound.version for bound in required.specifier if bound.operator == ">="]
    if len(lowest) != 1:
        raise ValueError(f'"{required}" must name its oldest allowed release, as in {required.name}>=1.0.')
    return f"{required.name}=={lowest[0]}"


def licenses(folders: Iterable[str]) -> dict[str, str]:
    """License of each distribution that the program needs at run time and that is installed in one of the folders."""
    known = {canonicalize_name(found.metadata["Name"]): found for found in distributions(path=list(folders))}
    waiting, taken = requirements(), dict[str, str]()
    while waiting:
        required = waiting.pop()
        name = canonicalize_name(required.name)
        if (
            name in taken
            or name not in known
            or not (required.marker is None or required.marker.evaluate({"extra": ""}))
        ):
            continue
        found = known[name]
        taken[name] = license_in(cast(Message, found.metadata))
        waiting += map(Requirement, found.requires or ())
    return dict(sorted(taken.items()))


def license_in(metadata: Message) -> str:
    """License that metadata names: an expression, classifiers, or the first line of a text."""
    if metadata.get("License-Expression"):
        return str(metadata["License-Expression"])
    classified = [
        line.rpartition(" :: ")[2]
        for line in metadata.get_all("Classifier", [])
        if line.startswith("License :: OSI Approved :: ")
    ]
    text = str(metadata.get("License") or "").strip()
    return "; ".join(classified) or (text.splitlines()[0] if text else "unknown")


def under_gpl(named: Mapping[str, str]) -> dict[str, str]:
    """Those of some licenses that are unknown, or leave no choice but the GPL."""
    return {name: license for name, license in named.items() if all(map(_refused, _CHOICE.split(license)))}


def _refused(license: str) -> bool:
    return license == "unknown" or _GPL.search(license.upper()) is not None
