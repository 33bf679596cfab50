"""Sessions: what is damaged is refused in one sentence, and what is read can be run, and written as it was read."""

from __future__ import annotations

import contextlib
import io
import json
from pathlib import Path
from random import Random

from cpm_app.model.document.document import Document, ImageReference
from cpm_app.session.features.kept_pages import StackSource, StoredPages
from cpm_app.session.timeline import runs_json

from cpm_core.cli import main
from cpm_core.formats.sessions.session_file import SessionFile, decode_session, encode_session, load_session
from cpm_core.shapes.document_shapes import count_axes
from cpm_core.warm_up import warm_up

from .inputs.mutations import mutated, mutated_json
from .inputs.session_samples import IMAGE, PAGES, SAMPLES, SESSION, SHAPES, STACK, write_images
from .limits import check_sentence, in_time

_AT_ONCE = 20
_RUN = 0.1
"""Share of the sessions that are run, as ``cpm run --session``, which takes much longer than reading."""

prepare = warm_up


def damaged(sound: bytes, random: Random) -> bytes:
    """The bytes of a session with changes of its values, or of the bytes themselves."""
    if random.random() < 0.2:
        return mutated(sound, random)
    if random.random() < 0.02:
        return sound.replace(b"2.0", random.choice((b"[", b'{"a":')) * random.choice((500, 5000, 10**6)), 1)
    changed = mutated_json(json.loads(sound), random)
    return json.dumps(changed, ensure_ascii=random.random() < 0.5).encode(errors="surrogatepass")


def read(path: Path, of: str) -> SessionFile | None:
    """Read a session of one of the images; None when it is refused.

    Fails when that is not in one sentence, when writing it changes it, or when it mixes shapes of images and volumes.
    """
    with in_time():
        try:
            session = load_session(path)
        except ValueError as error:
            check_sentence(error)
            return None
        for note in session.notes:
            check_sentence(ValueError(note))
        again = decode_session(encode_session(session, path.parent), path.name)
        twice = decode_session(encode_session(again, path.parent), path.name)
        assert again.shapes == session.shapes, "shapes change when the session is written"
        assert again.parameters == session.parameters, "parameters change when the session is written"
        assert again == twice, "a session that is written twice is another one"
        kinds = {count_axes(shape) for shape in session.shapes} - {None}
        sides = len(session.image.shape) if session.image is not None else 0
        assert kinds <= ({sides} if sides else {2}) or (not sides and kinds <= {3}), (
            f"{kinds} axes on an image of {sides}"
        )
        image = ImageReference(of, str(path.parent / of), SHAPES[of], 180.0)
        _, fault = runs_json.runs_from_json(session.runs, image)
        pages = StoredPages.from_json(
            session.pages, Document(image), StackSource(image.path, PAGES if of == STACK else 0)
        )
        for sentence in filter(None, (fault, pages.error)):
            check_sentence(ValueError(sentence))
    return session


def run(path: Path) -> None:
    """Run a session for a few steps on the command line; fails unless it is done, or refused in one sentence."""
    said, printed = io.StringIO(), io.StringIO()
    target = path.with_suffix(".json")
    with in_time(60.0), contextlib.redirect_stderr(said), contextlib.redirect_stdout(printed):
        status = main(["run", "--session", str(path), "--max-steps", "3", "--export", str(target)])
    lines = said.getvalue().splitlines()
    assert status in (0, 2), f"status {status}: {lines}"
    assert all(line.startswith("cpm: ") and len(line) < 1200 for line in lines), f"said {lines}"
    assert status == 0 or lines, "refused without a word"
    assert target.exists() == (status == 0), (
        f"status {status}, and the file is{'' if target.exists() else ' not'} there"
    )
    target.unlink(missing_ok=True)


def trial(random: Random, folder: Path) -> int:
    """Damage the session several times and read it; run some of what can be read."""
    write_images(folder)
    of = random.choice((IMAGE, *SAMPLES))
    path, sound = folder / SESSION, json.dumps(SAMPLES[of](folder)).encode()
    for number in range(_AT_ONCE):
        path.write_bytes(damaged(sound, random))
        try:
            session = read(path, of)
            if session is not None and random.random() < _RUN:
                run(path)
        except BaseException as error:
            error.args = (f"session {number} of the trial: {error}",)
            raise
    return _AT_ONCE
