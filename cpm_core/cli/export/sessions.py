"""What a session shows, as a result: the state that it keeps, or else the end of its run."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

from cpm_core.cli.arguments import notes_on, with_room
from cpm_core.cli.inputs.named_files import check_kept
from cpm_core.cli.inputs.source import image_of, in_volume, reading_of
from cpm_core.cli.terminal import announce_compilation, progress_line, say
from cpm_core.contours.kept import with_kept
from cpm_core.contours.result import Result
from cpm_core.contours.review import apply
from cpm_core.formats import load_image, load_volume
from cpm_core.formats.provenance import with_shapes
from cpm_core.formats.sessions.recorded_run import shown_state
from cpm_core.formats.sessions.session_file import SessionFile, load_session
from cpm_core.image.image import Image
from cpm_core.segmentation.engine import Engine
from cpm_core.segmentation.segment import segment, with_hand_edits
from cpm_core.shapes.document_shapes import charges_of, regions_of, seeds_on, starts_of


def of_session(source: Path, arguments: argparse.Namespace) -> tuple[Result, str]:
    """What the window shows of a session: the state that it keeps, or else the end of its run."""
    session, named = load_session(source), arguments.image
    if named is None and session.image is None:
        raise ValueError(f"{source.name} names no image: add --image IMAGE.")
    path, notes = image_of(named, session, source)
    check_kept(arguments.to, arguments, path, flag="--to")
    for told in (*session.notes, *notes):
        say(f"cpm: {told}")
    part = reading_of(named, session, path)
    image = load_volume(path, **part) if in_volume(session) else load_image(path, **part)
    parameters, small = with_room(session.parameters, image)
    for note in (*notes_on(image, parameters), *small):
        say(f"cpm: {image.source}: {note}")
    result = _found(replace(session, parameters=parameters), image, source)
    edited = with_hand_edits(with_shapes(result, session.shapes), image, parameters, session.hand_edits)
    whole = with_kept(edited, session.marks)
    return apply(whole, session.marks), str(path)


def _found(session: SessionFile, image: Image, source: Path) -> Result:
    announce_compilation()
    shown = shown_state(session, image)
    if shown is not None:
        state, parameters = shown
        return replace(Engine(image, parameters, state.regions).result(state, parameters), source=image.source)
    if not starts_of(session.shapes):
        raise ValueError(f"{source.name} has no start and no contours: draw a start in the window, and save it again.")
    seen = session.parameters.smoothing, session.parameters.channel
    seeds = seeds_on(image, session.shapes, *seen)
    regions, charges = regions_of(session.shapes, session.objects.barriers), charges_of(session.shapes)
    with progress_line() as progress:
        return segment(image, seeds, session.parameters, progress=progress, regions=regions, charges=charges)
