"""JSON: everything that a result holds, for scripts."""

from __future__ import annotations

from typing import Any

from cpm_core.contours.measurements import measure
from cpm_core.contours.result import Result
from cpm_core.formats.common.provenance import ENTRY, facts_of
from cpm_core.formats.contours.json_text import rounded, text
from cpm_core.medial_axis.skeleton import Skeleton

FORMAT = "cpm-contours"
"""Value of the entry ``format`` of such a file."""


def encode(result: Result | Skeleton) -> bytes:
    """Write an object with the image, the run, the contours and the bridges; `load_contours` reads it back.

    ``points`` are pairs [row, col] in px, pixel centers at integers; lengths are in px, areas in px², strengths in gray
    levels / px. ``gross_area`` is all that a contour encloses, ``net_area`` without the closed contours in it, as in
    the label mask. ``inside`` is the number of the innermost closed contour around, 0 for none; ``contrast`` is null
    where there is no image to measure it in; ``by_hand`` is the length that was drawn by hand [px]; ``reached`` tells
    how particles came to a contour, where it is known. Where the size of a pixel is known, length and areas are given
    in its unit as well. The boundaries of an object have its number as ``object``, and as ``bridged`` the length
    without an edge that was found. The image has the ``channel`` of its colors in which the contours were
    found, unless it is the luminance. ``provenance`` is how they were found (`provenance.facts_of`). Of a
    skeleton the branches are contours with ``radii`` [px], and there is no run.
    """
    content: dict[str, Any] = {"format": FORMAT, "version": 1, "image": image_of(result), ENTRY: facts_of(result)}
    return text(content | found_in(result))


def image_of(result: Result | Skeleton) -> dict[str, Any]:
    """The image of a result: its name, its shape and the size of a pixel."""
    image: dict[str, Any] = {"name": result.source, "shape": list(result.shape)}
    image |= {"spacing": list(result.spacing), "unit": result.unit}
    if result.channel != "luminance":
        image["channel"] = result.channel
    return image


def found_in(result: Result | Skeleton) -> dict[str, Any]:
    """The run, the contours and the bridges; see `encode`."""
    content: dict[str, Any] = {}
    if isinstance(result, Result):
        content["run"] = {
            "steps": result.steps,
            "converged": result.converged,
            "stop_reason": result.stop_reason,
            "particles": len(result.particles),
        }
    content["contours"] = _contours(result)
    if isinstance(result, Result):
        content["bridges"] = [
            {"length": round(bridge.length, 4), "strength": round(bridge.strength, 6), "points": rounded(bridge.points)}
            for bridge in result.bridges
        ]
    return content


def _contours(result: Result | Skeleton) -> list[dict[str, Any]]:
    entries: list[dict[str, Any]] = []
    rows = measure(result.contours, result.spacing)
    for index, (contour, row) in enumerate(zip(result.contours, rows, strict=True)):
        entry: dict[str, Any] = {
            "number": row.number,
            "label": row.label,
            "name": row.name,
            "color": row.color,
            "closed": row.closed,
            "junctions": list(contour.junctions),
            "inside": row.inside,
            "length": round(row.length, 4),
            "gross_area": round(row.area, 4),
            "net_area": round(row.net_area, 4),
            "strength": round(row.strength, 6),
            "contrast": None if row.contrast is None else round(row.contrast, 6),
            "by_hand": round(row.by_hand, 4),
        }
        if contour.reached:
            entry["reached"] = contour.reached
        if result.unit:
            entry |= {"length_in_units": row.length_in_units, "gross_area_in_units": row.area_in_units}
            entry["net_area_in_units"] = row.net_area_in_units
        if contour.group:
            entry |= {"object": contour.group, "hole": contour.hole, "bridged": round(contour.bridged, 4)}
        if isinstance(result, Skeleton):
            entry["radii"] = rounded(result.radii[index])
        entries.append(entry | {"points": rounded(contour.points)})
    return entries
