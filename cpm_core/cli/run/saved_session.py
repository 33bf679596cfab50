"""The session file of ``cpm run --save-session``: what was asked and what was found, to go on with in the window."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from cpm_core.cli.run.drawn import shapes_drawn
from cpm_core.formats.common.atomic import check_place
from cpm_core.formats.images.reading import Reading
from cpm_core.formats.sessions.recorded_run import Recorder, with_run
from cpm_core.formats.sessions.session_file import SUFFIX, ImageFile, SessionFile, save_session
from cpm_core.image.image import Image
from cpm_core.parameters import Parameters
from cpm_core.shapes import Everywhere
from cpm_core.shapes.document_shapes import starts_of


def check_save(arguments: argparse.Namespace, image: str) -> None:
    """Raise ValueError unless a session can be written where it is wanted."""
    if arguments.save_session is None:
        return
    if arguments.pages is not None:
        raise ValueError("--save-session is for one image, but --pages runs several: leave one of them out.")
    file = Path(arguments.save_session)
    if file.suffix.lower() != SUFFIX or file.resolve() == Path(image).resolve():
        raise ValueError(f"--save-session is {file} but must name a session file: end its name in {SUFFIX}.")
    check_place(file)


def save(
    arguments: argparse.Namespace,
    session: SessionFile,
    image: Image,
    path: Path,
    part: Mapping[str, Any],
    parameters: Parameters,
    recorder: Recorder,
) -> None:
    """Write the session of a run that has ended."""
    shapes = (*session.shapes, *shapes_drawn(arguments, image))
    if not starts_of(shapes):  # as for an object that was named
        shapes = (*shapes, Everywhere("grid"))
    spacing = part.get("spacing")
    reading = Reading(
        **{**part, "spacing": (spacing,) if isinstance(spacing, int | float) else spacing and tuple(spacing)}
    )
    own = arguments.image is None
    whole = replace(
        session,
        image=ImageFile(str(path.absolute()), image.sha256, image.shape, reading=reading),
        shapes=shapes,
        parameters=parameters,
        marks=session.marks if own else (),
        hand_edits=session.hand_edits if own else (),
        view=session.view if own else {},
        pages={},
        notes=(),
    )
    save_session(with_run(whole, recorder), Path(arguments.save_session))
