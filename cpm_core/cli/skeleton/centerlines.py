"""``cpm skeleton VOLUME``: finds the center lines of what lies in a volume."""

from __future__ import annotations

import argparse
import time

from cpm_core.cli.arguments import check_exports, parameters_of
from cpm_core.cli.inputs.part import part_of_volume
from cpm_core.cli.outcome import Files, tell
from cpm_core.cli.terminal import announce_compilation, counted, say
from cpm_core.formats import FOR_CENTERLINES, load_volume, suffix_of
from cpm_core.formats.provenance import ENTRY, facts_on
from cpm_core.medial_axis.skeletonize import skeleton
from cpm_core.medial_axis.space.centerlines import Centerlines
from cpm_core.parameters import PRESETS


def find_centerlines(arguments: argparse.Namespace) -> int:
    """Find the center lines in a volume; every check that needs no volume comes first."""
    part = part_of_volume(arguments)
    parameters = parameters_of(arguments, PRESETS["volume"])
    check_exports(arguments.export, arguments)
    for path in arguments.export:
        if suffix_of(path) not in FOR_CENTERLINES:
            raise ValueError(f"{path} holds no center lines in a volume: end its name in {', '.join(FOR_CENTERLINES)}.")
    volume = load_volume(arguments.image, **part)
    for note in volume.notes:
        say(f"cpm: {volume.source}: {note}")
    mask = None if arguments.within is None else load_volume(arguments.within).values > 0.0
    announce_compilation()
    started = time.perf_counter()
    found = skeleton(volume, parameters, of=arguments.of, within=mask, outside=arguments.outside)
    seconds = time.perf_counter() - started
    assert isinstance(found, Centerlines)
    files = Files()
    files.export(found, arguments.export, space=arguments.space or "LPS")
    files.check()
    _report(found, seconds, files, as_json=arguments.json)
    return files.status()


def _report(found: Centerlines, seconds: float, files: Files, *, as_json: bool) -> None:
    closed = sum(branch.closed for branch in found.branches)
    facts = {
        "contours": len(found.branches),
        "closed": closed,
        "length": round(float(found.lengths.sum()), 3),
        "largest_radius": round(max((float(radii.max()) for radii in found.radii), default=0.0), 3),
        "unit": found.unit,
        "seconds": round(seconds, 3),
        "not_written": files.refused,
        ENTRY: facts_on(found.source, found.provenance),
    }
    unit = found.unit or "voxels"
    count = counted(len(found.branches), "center line")
    lines = [f"{found.source}: {count} ({closed} closed) in {seconds:.2f} s"]
    for number, (length, radii) in enumerate(zip(found.lengths[:10], found.radii, strict=False), start=1):
        lines.append(f"  {number}. length {length:.1f} {unit}, radius {radii.min():.1f} to {radii.max():.1f} {unit}")
    if len(found.branches) > 10:
        lines.append(f"  ... and {len(found.branches) - 10} shorter ones")
    tell("skeleton", facts, lines, files.written, as_json=as_json)
