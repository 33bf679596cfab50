"""Advisories: records of known faults in the format of OSV, and which of some distributions they concern."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from packaging.utils import canonicalize_name
from packaging.version import InvalidVersion, Version

_INDEX = "PyPI"


def read(path: Path) -> list[dict[str, Any]]:
    """Records of a file: one of them, a list, or a ZIP archive of them; ValueError when it holds none."""
    try:
        return list(_records(path))
    except (OSError, ValueError, zipfile.BadZipFile) as error:
        raise ValueError(f"The advisories cannot be read from {path}: {error}.") from error


def _records(path: Path) -> Iterator[dict[str, Any]]:
    if zipfile.is_zipfile(path):
        with zipfile.ZipFile(path) as archive:
            contents = [archive.read(name) for name in archive.namelist() if name.endswith(".json")]
    else:
        contents = [path.read_bytes()]
    for content in contents:
        found = json.loads(content)
        records = found if isinstance(found, list) else [found]
        if not all(isinstance(record, dict) and "affected" in record for record in records):
            raise ValueError("a record without what it affects")
        yield from records


def known_faults(installed: Mapping[str, str], records: Iterable[Mapping[str, Any]]) -> list[str]:
    """A sentence for each fault of an installed distribution (name -> version) that a record knows of."""
    versions = {canonicalize_name(name): version for name, version in installed.items()}
    found = []
    for record in records:
        if record.get("withdrawn"):
            continue
        for affected in record["affected"]:
            package = affected.get("package", {})
            name = canonicalize_name(package.get("name", ""))
            if package.get("ecosystem") == _INDEX and name in versions and _is_affected(versions[name], affected):
                summary = " ".join(str(record.get("summary", "")).split())
                found.append(f"{name} {versions[name]}: {record.get('id', 'no name')} {summary}".rstrip() + ".")
                break
    return sorted(found)


def _is_affected(installed: str, affected: Mapping[str, Any]) -> bool:
    """Whether a release is one of those named, or lies in one of the ranges."""
    if installed in affected.get("versions", ()):
        return True
    version = Version(installed)
    ranges = (found for found in affected.get("ranges", ()) if found.get("type") == "ECOSYSTEM")
    return any(_lies_in(version, found.get("events", ())) for found in ranges)


def _lies_in(version: Version, events: Iterable[Mapping[str, str]]) -> bool:
    """Whether the last event up to a release is one that brings the fault."""
    begun = False
    for event in sorted(events, key=_order):
        (kind, at), *_ = event.items()
        bound = _version(at)
        if kind == "introduced" and version >= bound:
            begun = True
        elif (kind == "fixed" and version >= bound) or (kind == "last_affected" and version > bound):
            begun = False
    return begun


def _order(event: Mapping[str, str]) -> tuple[Version, bool]:
    (kind, at), *_ = event.items()
    return _version(at), kind != "introduced"


def _version(text: str) -> Version:
    try:
        return Version(text)
    except InvalidVersion as error:
        raise ValueError(f'An advisory names the release "{text}", which is none.') from error
