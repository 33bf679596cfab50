"""A batch: a session applied to images, whose files and table are written as each of them is done."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, fields
from pathlib import Path

from cpm_core.cli.batch.jobs import Done, Job
from cpm_core.cli.batch.summary import Row, Summary, now
from cpm_core.formats.common.atomic import interrupts_put_off, write_together
from cpm_core.formats.common.printable import printable
from cpm_core.formats.sessions.session_file import SessionFile
from cpm_core.parameters import Parameters

_LONGEST = 200
"""Longest part of an image's name that is taken into those of its files [bytes]."""


@dataclass(frozen=True, slots=True)
class Order:
    """What a batch has to do.

    Attributes
    ----------
    images : sequence of str
        The images as they were named.
    session : SessionFile
        Start, regions, charges and review.
    session_sha256 : str
        Hash of the session file.
    output : Path
        The folder that is written to.
    suffixes : tuple of str
        Formats to write.
    parameters : Parameters
        Parameters of the runs.
    max_steps : int or None
        Largest number of steps of a run.
    again : bool
        Whether to do what is done already.
    """

    images: Sequence[str]
    session: SessionFile
    session_sha256: str
    output: Path
    suffixes: tuple[str, ...]
    parameters: Parameters
    max_steps: int | None = None
    again: bool = False

    @property
    def settings(self) -> str:
        """What is asked in addition to the session: other parameters, steps, formats."""
        parts = {field.name: getattr(self.parameters, field.name) for field in fields(Parameters)}
        changed = [
            f"{name}={value}" for name, value in parts.items() if value != getattr(self.session.parameters, name)
        ]
        steps = [] if self.max_steps is None else [f"max_steps={self.max_steps}"]
        return " ".join([*changed, *steps, f"export={','.join(self.suffixes)}"])


class Batch:
    """The images of an order, what has been done with them before, and what is left to do.

    Raises
    ------
    ValueError
        When the table in the folder cannot be read.
    """

    def __init__(self, order: Order) -> None:
        self.order = order
        self.summary = Summary(order.output, order.images)
        self._settings = order.settings
        known = {} if order.again else self.summary.done(order.session_sha256, self._settings)
        self.known: Mapping[int, Row] = known
        """Rows of the images that are done, by their number."""
        self._stems = _stems(order, known, self.summary.taken())
        paths = {number: str(Path(image).absolute()) for number, image in enumerate(order.images)}
        self.jobs = tuple(
            Job(number, path, order.session, order.parameters, order.max_steps, order.suffixes)
            for number, path in paths.items()
            if number not in known
        )
        """What is left to do."""

    def rows(self, results: Generator[Done]) -> Iterator[tuple[int, Row]]:
        """Write the files and the row of each image as it is done, and yield it; at the end the table is in order."""
        self.summary.write()
        try:
            with closing(results):
                for done in results:
                    with interrupts_put_off():  # files without their row would be made again
                        row = self._written(done)
                        self.summary.add(done.number, row)
                    yield done.number, row
        finally:
            self.summary.write()

    def _written(self, done: Done) -> Row:
        """Write all files of an image, or none, and tell it as a row of the table."""
        order, stem = self.order, self._stems[done.number]
        files = [(order.output / f"{stem}{suffix}", content) for suffix, content in done.files.items()]
        error, facts = done.error, done.facts
        try:
            self.summary.release(path.name for path, _ in files)
            write_together(files)
        except ValueError as trouble:
            error, facts, files = str(trouble), {}, []
        names = tuple(path.name for path, _ in files)
        hashes = {"image_sha256": done.sha256, "session_sha256": order.session_sha256}
        image = order.images[done.number]
        return Row(image, facts, names, error, done.notes, **hashes, settings=self._settings, finished=now())


def _stems(order: Order, known: Mapping[int, Row], taken: set[str]) -> dict[int, str]:
    """Unique file names without a suffix, after the names of the images that are not done yet; none is an image."""
    stems: dict[int, str] = {}
    images = {Path(image).resolve() for image in order.images}

    def is_free(stem: str) -> bool:
        names = [f"{stem}{suffix}" for suffix in order.suffixes]
        return not any(name.lower() in taken or (order.output / name).resolve() in images for name in names)

    for number, image in enumerate(order.images):
        if number in known:
            continue
        stem = first = f"{_short(Path(image).stem)}_contours"
        count = 1
        while not is_free(stem):
            count += 1
            stem = f"{first}_{count}"
        taken |= {f"{stem}{suffix}".lower() for suffix in order.suffixes}
        stems[number] = stem
    return stems


def _short(stem: str) -> str:
    """The beginning of a name that leaves room for what is added to it; file systems allow 255 bytes."""
    return printable(stem).encode()[:_LONGEST].decode(errors="ignore")
