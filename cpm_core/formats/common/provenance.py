"""Provenance in files: program version, image and hash, method, its inputs, and the outcome.

The same result always gives the same text, so no file holds a time. Of the image only the file name is stated, never
its folder.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from dataclasses import asdict, replace
from pathlib import PurePosixPath, PureWindowsPath
from typing import Any

from cpm_core.formats.common.printable import make_printable
from cpm_core.image.region import Region
from cpm_core.image.regions import Regions
from cpm_core.image.volume_regions import Extrusion
from cpm_core.medial_axis.skeleton import Skeleton
from cpm_core.numerics.types import JsonDict, JsonObject
from cpm_core.parameters.provenance import Provenance
from cpm_core.results.result import Result
from cpm_core.shapes import SHAPES_BY_NAME, EnclosedRegion, EnclosingWall, Measure, Shape

Outcome = Result | Skeleton
"""Outcome of a run on an image: contours, or a skeleton."""

VERSION = "1.0.0rc1"
"""Version of CPM; the package is built with it."""

PROGRAM_NAME = f"CPM {VERSION}"
"""Name and version of the program, as files state them."""

PROVENANCE_KEY = "provenance"
"""Key of the provenance in JSON files."""

_MAX_LISTED_POSITIONS = 32
"""Number of positions of a shape up to which they are listed; beyond it only their number is."""


def describe_provenance(result: Outcome) -> JsonDict:
    """Describe the provenance of a result as JSON."""
    facts = describe_image_provenance(result.source, result.provenance, _describe_limits(result))
    if isinstance(result, Result) and result.provenance.method != "objects":
        facts |= {"steps": result.steps, "stop_reason": result.stop_reason}
    return facts


def describe_image_provenance(source: str, provenance: Provenance, shapes: Iterable[JsonObject] = ()) -> JsonDict:
    """Describe the provenance for an image of this name as JSON, adding those of `shapes` that it lacks."""
    image = {"name": make_printable(PurePosixPath(PureWindowsPath(source).name).name)}
    if provenance.sha256:
        image["sha256" if provenance.of_file else "array_sha256"] = provenance.sha256
    facts: JsonDict = {"program": "CPM", "version": VERSION, "image": image}
    if provenance.method:
        facts["method"] = provenance.method
    if provenance.model:
        facts["model"] = provenance.model
    if provenance.parameters:
        facts["parameters"] = dict(provenance.parameters)
    if provenance.seeds is not None:
        facts["seeds"] = provenance.seeds
    drawn = [*provenance.shapes, *(shape for shape in shapes if shape not in provenance.shapes)]
    if drawn:
        facts["shapes"] = [
            {
                name: len(value) if isinstance(value, list | tuple) and len(value) > _MAX_LISTED_POSITIONS else value
                for name, value in shape.items()
            }
            for shape in drawn
        ]
    if provenance.scale is not None:
        facts["scale"] = provenance.scale
    if provenance.steered:
        facts["steered"] = True
    return facts


def dump_provenance(facts: JsonObject) -> str:
    """Dump a provenance as JSON on one line of ASCII, for a comment or description in a file."""
    return json.dumps(facts, allow_nan=False, separators=(",", ":"))


def flatten_provenance(facts: JsonObject) -> dict[str, str]:
    """Flatten a provenance to names and short texts, for files that hold no JSON, such as tables.

    Only the name of an image may contain a comma: many programs that read tables do not understand quoted cells.
    """
    image = facts["image"]
    hashes = {f"image_{name}": value for name, value in image.items() if name != "name"}
    entries = {"program": f"{facts['program']} {facts['version']}", "image": image["name"], **hashes}
    for name, value in facts.items():
        if name == "parameters":
            entries[name] = _format_values(value)
        elif name == "shapes":
            entries[name] = "; ".join(map(_format_values, value))
        elif name not in ("program", "version", "image"):
            entries[name] = str(value).replace(",", ";")
    return entries


def _format_values(values: JsonObject) -> str:
    """Format names with their values, flattening nested lists."""
    return " ".join(f"{name}={' '.join(_iterate_leaves(value))}" for name, value in values.items())


def _iterate_leaves(value: Any) -> Iterator[str]:
    """Yield the leaves of nested lists as texts."""
    if isinstance(value, (list, tuple)):
        for part in value:
            yield from _iterate_leaves(part)
    else:
        yield str(value).replace(",", ";")


def describe_shapes(shapes: Iterable[Shape]) -> tuple[JsonDict, ...]:
    """Describe shapes for `Provenance.shapes`, with the kinds and fields of session files.

    Measures, which act on no run, are left out.
    """
    kinds = {kind: name for name, kind in SHAPES_BY_NAME.items()}
    found = []
    for shape in shapes:
        if isinstance(shape, Measure):
            continue
        fields = {}
        if isinstance(shape, EnclosedRegion | EnclosingWall):  # these may have many thousand triangles
            fields = {"triangles": len(shape.region.find_surface().faces), "voxels": int(shape.limit.mask.sum())}
        found.append({"shape": kinds[type(shape)], **(fields or asdict(shape))})
    return tuple(found)


def record_drawn_shapes(result: Result, shapes: Iterable[Shape], described: Iterable[JsonObject] = ()) -> Result:
    """Record the shapes that seeds, limits and charges of a run come from, and those already `described` as JSON."""
    return replace(result, provenance=replace(result.provenance, shapes=(*describe_shapes(shapes), *described)))


def _describe_limits(result: Outcome) -> list[JsonDict]:
    """Describe the regions of interest and barriers of a run as shapes."""
    known = (result.regions if isinstance(result, Result) else None) or Regions()
    limits = {"region": known.interest, "barrier": known.barriers}
    return [{"shape": shape, **_describe_limit(limit)} for shape, several in limits.items() for limit in several]


def _describe_limit(limit: Any) -> JsonDict:
    """Describe the extent of a region of interest or a barrier."""
    if isinstance(limit, Extrusion):
        return {"points": limit.line, "axis": limit.axis, "first": limit.first, "last": limit.last}
    return {"voxels": int(limit.mask.sum())} if isinstance(limit, Region) else {"points": limit}
