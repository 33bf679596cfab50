"""Pages of a stack that are not open: their file, state, runs and tracks, and their part of a session."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypeVar

from cpm_app.model.display.page_rows import PageRow, collect_page_rows
from cpm_app.model.document.document import Document, ImageReference
from cpm_app.model.document.objects import build_objects_result
from cpm_app.model.document.saving import from_session_file, to_session_file
from cpm_app.model.text.language import tr
from cpm_app.model.volume.parts import FileParts
from cpm_app.session.exchange.messages import explain_failure
from cpm_app.session.features.background import IdentityCache
from cpm_app.session.tasks.tasks import BackgroundTask, Cancelled
from cpm_app.session.undo_history import UndoHistory
from cpm_core import Engine, Evolution, Image, Page, Result, load_pages
from cpm_core.formats import (
    Pages,
    Reading,
    decode_session,
    encode_session,
    expect_mapping,
    page_from_json,
    page_to_json,
)
from cpm_core.formats.sessions.recorded_run import RunRecorder, add_recorded_run
from cpm_core.numerics.types import JsonDict, JsonObject, record
from cpm_core.objects.segmented import SegmentedObjects
from cpm_core.pages import PageFollower, StackResult, limit_scales, strip_image
from cpm_core.shapes import Measure, SeedCache, Start, check_axes

Entry = TypeVar("Entry")


PageKind = Literal["page", "channel", "time"]
"""What the pages of a file are."""


@record
class StackSource:
    """A file whose pages are separate images, or whose points in time or channels are separate volumes.

    Attributes
    ----------
    path : str
        The file.
    count : int
        Number of its pages; 0 where there is one.
    kind : {"page", "channel", "time"}
        What they are: channels where an image has neither planes nor times, or a volume no times.
    has_volumes : bool
        Whether they are volumes, which are opened one by one, without a result of all.
    reading : Reading
        How its pages are read.
    default_page : int
        The page that is read by default.
    """

    path: str = ""
    count: int = 0
    kind: PageKind = "page"
    has_volumes: bool = False
    reading: Reading = field(default_factory=Reading)
    default_page: int = 1

    @classmethod
    def from_file(cls, path: str, parts: FileParts | None, reading: Reading, in_volume: bool) -> StackSource:
        """Describe the stack in a file, of which an image or a volume is open."""
        if parts is None:
            return cls(path)
        by_channel = parts.times == 1 and parts.channels > 1 and not parts.has_colors
        kind: PageKind = "time" if in_volume else "page"
        if by_channel and (in_volume or parts.pages == 1):
            kind = "channel"
        count = {"page": parts.pages, "channel": parts.channels, "time": parts.times}[kind]
        return cls(path, count if count > 1 else 0, kind, in_volume, reading, parts.default_page)

    def page_number(self, reading: Reading) -> int:
        """Return the number of the page that a reading selects."""
        number: int | None = getattr(reading, self.kind)
        return number or self._default

    def reading_for(self, number: int) -> Reading:
        """Return the reading of a page; the default page of images needs no number."""
        selected: dict[str, Any] = {self.kind: None if number == self._default and not self.has_volumes else number}
        return replace(self.reading, **selected)

    @property
    def _default(self) -> int:
        """Number of the page that is read by default."""
        return self.default_page if self.kind == "page" else 1

    @cached_property
    def pages(self) -> Pages:
        """The pages, each read from the file on access; not for use on the window's thread."""
        given = self.reading.arguments
        for name in ("page", self.kind):
            given.pop(name, None)
        return load_pages(self.path, **given)


@record
class KeptPage:
    """The state of a page while another one is open.

    Attributes
    ----------
    document : Document
        Its document.
    runs : mapping
        Its runs, as plain JSON.
    history : UndoHistory
        Its undo history.
    saved_document : Document or None
        Its document in the session file; None if the file has a different one.
    given_starts : tuple of Start
        Starts taken from the results of the previous page, not drawn by the user.
    runs_unsaved : bool
        Whether there are runs that are in no file.
    """

    document: Document
    runs: JsonObject = field(default_factory=dict)
    history: UndoHistory = field(default_factory=UndoHistory)
    saved_document: Document | None = None
    given_starts: tuple[Start, ...] = ()
    runs_unsaved: bool = False

    @property
    def has_own_start(self) -> bool:
        """Whether the user has drawn where its run starts."""
        return bool(self.document.starts) and self.document.starts != self.given_starts

    @property
    def unsaved(self) -> bool:
        """Whether closing would lose changes of it."""
        return self.runs_unsaved or self.document != self.saved_document


def give_starts(document: Document, starts: tuple[Start, ...]) -> tuple[Document, tuple[Start, ...]]:
    """Give a document starts in place of its own, if there are any; return it, and the starts that it has."""
    others = (shape for shape in document.shapes if not isinstance(shape, Start))
    given = starts or document.starts
    return replace(document, shapes=(*given, *others)), given


def without_results(document: Document) -> Document:
    """Keep the settings of a document for another page: shapes, parameters, mode, classes; no results, no measures."""
    known = document.objects
    known = SegmentedObjects(classes=known.classes, category=known.category, may_overlap=known.may_overlap)
    shapes = tuple(shape for shape in document.shapes if not isinstance(shape, Measure))
    return Document(document.image, shapes, document.parameters, mode=document.mode, objects=known)


StackTable = tuple[StackResult | None, tuple[PageRow, ...]]
"""The results of all pages, and the rows of their table."""

EMPTY_TABLE: StackTable = (None, ())
"""The table while there are no results."""


class LinkedPages(NamedTuple):
    """What was found on all pages of a stack, with tracks.

    `found` are the contours of runs, as files hold them; `table` has the objects of a page in their place.
    """

    source: StackSource
    found: Mapping[int, Page]
    table: StackTable


def link_pages(
    source: StackSource,
    found: Mapping[int, Page],
    drawn: tuple[JsonObject, ...],
    documents: Mapping[int, Document],
    measured: IdentityCache,
) -> LinkedPages:
    """Link what was found on all pages to tracks, page by page; objects are measured again only if they change."""

    def measure_objects(number: int, document: Document) -> Result | None:
        result = build_objects_result(document)
        image, channel = source.pages[number - 1], document.parameters.channel
        return result and strip_image(replace(result, image=image, channel=channel))

    objects = dict[int, Result]()
    for number, document in documents.items():
        size = document.image and (document.image.spacing, document.image.unit)
        measure = partial(measure_objects, number, document)
        if (result := measured.get_named(number, measure, document.objects, size)) is not None:
            objects[number] = result
    runs = {number: page.result and strip_image(page.result) for number, page in found.items()}
    found = {number: replace(page, result=runs[number]) for number, page in found.items()}
    follower, pages = PageFollower(), list[Page]()
    for number in sorted({*found, *objects}):
        result = objects.get(number) or runs[number]
        pages.append(found[number] if result is None else follower.add_page(number, result))
    if not pages:
        return LinkedPages(source, found, EMPTY_TABLE)
    name, axis, alone = Path(source.path).name, source.pages.axis, source.pages.has_single_axis
    whole = StackResult(name, source.count, tuple(pages), axis, alone, drawn, source.pages.interval)
    return LinkedPages(source, found, (whole, collect_page_rows(whole)))


_MAX_PAGE_RUNS_CHARACTERS = 24 * 2**20
"""Largest size of the recorded runs of other pages in a session file [characters]; all else is always written."""


def pages_to_json(
    others: Mapping[int, KeptPage],
    following: bool,
    drawn: tuple[JsonObject, ...],
    given: bool,
    found: Mapping[int, Page],
) -> JsonDict:
    """Encode the pages of a stack for a session file, to be read by `StoredPages`; runs are left out beyond a size.

    `others` are the pages that are not open, `given` is whether the open page was given its starts.
    """
    if not (others or found):
        return {}
    left, sessions = _MAX_PAGE_RUNS_CHARACTERS, []
    for number, page in sorted(others.items()):
        session = json.loads(encode_session(replace(to_session_file(page.document, {}), image=None), Path()))
        size = len(json.dumps(page.runs))
        if page.runs and size <= left:
            left -= size
            session["runs"] = dict(page.runs)
        sessions.append({"page": number, "given": not page.has_own_start, "session": session})
    return {
        "following": following,
        "drawn": list(drawn),
        "given": given,
        "sessions": sessions,
        "found": [page_to_json(page) for page in found.values()],
    }


@record
class StoredPages:
    """The pages of a stack as stored in a session file.

    Attributes
    ----------
    kept : dict of int to KeptPage
        The pages that are not open, by number.
    found : dict of int to Page
        Results of each page.
    following : bool
        Whether each page starts from the contours of the previous one, and is offered its objects.
    drawn : tuple of mapping
        Shapes drawn before all pages were run.
    given_starts : tuple of Start
        Starts of the open page, if they were given by the previous one.
    error : str
        Message on what had to be left out, or "".
    """

    kept: dict[int, KeptPage]
    found: dict[int, Page]
    following: bool
    drawn: tuple[JsonObject, ...]
    given_starts: tuple[Start, ...]
    error: str

    @classmethod
    def from_json(cls, plain: JsonObject, here: Document, source: StackSource) -> StoredPages:
        """Read the pages of a session file; damaged ones are left out. The open page has the document `here`."""

        def read_session(entry: JsonObject) -> tuple[int, KeptPage]:
            number = _check_page_number(entry["page"], source)
            file = decode_session(json.dumps(entry["session"]).encode(), tr("page {number}", number=number))
            image = here.image and replace(here.image, reading=source.reading_for(number))
            if image is None:
                raise ValueError("there is no image")
            check_axes(file.shapes, image.shape)
            document = from_session_file(file, image, file.parameters)
            given = document.starts if entry.get("given") is True else ()
            return number, KeptPage(document, file.runs, saved_document=document, given_starts=given)

        def read_page(entry: JsonObject) -> tuple[int, Page]:
            page = page_from_json(entry)
            return _check_page_number(page.number, source), page

        faults: list[Exception] = []
        kept, pages = (
            dict(_read_valid_entries(plain, "sessions", read_session, faults)),
            dict(_read_valid_entries(plain, "found", read_page, faults)),
        )
        drawn = tuple(_read_valid_entries(plain, "drawn", dict, []))
        given = here.starts if plain.get("given") is True else ()
        trouble = tr("Some pages of the stack are damaged in the session and were skipped.")
        return cls(kept, pages, plain.get("following") is not False, drawn, given, trouble if faults else "")


def _read_valid_entries(
    plain: JsonObject, name: str, read: Callable[[JsonObject], Entry], errors: list[Exception]
) -> list[Entry]:
    """Read the valid entries of a list; the errors of the others are added to `errors`."""
    found, entries = [], plain.get(name, [])
    for entry in entries if isinstance(entries, list) else [entries]:
        try:
            found.append(read(expect_mapping(entry, name)))
        except (ValueError, TypeError, KeyError, OverflowError, IndexError, AttributeError) as error:
            errors.append(error)
    return found


class LazyJsonPages(Mapping[str, Any]):
    """Pages as plain JSON, encoded on access: on the thread that writes a file, not on the window's."""

    def __init__(self, make: Callable[[], JsonDict]) -> None:
        self._make = make

    @cached_property
    def _plain(self) -> JsonDict:
        return self._make()

    def __getitem__(self, name: str) -> Any:
        return self._plain[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._plain)

    def __len__(self) -> int:
        return len(self._plain)


def _check_page_number(given: object, source: StackSource) -> int:
    if type(given) is not int or not 1 <= given <= source.count:
        raise ValueError("there is no such page")
    return given


def run_recorded(image: Image, document: Document, task: BackgroundTask) -> tuple[Result, JsonObject]:
    """Run a document on its image in the background; return the result, and the run for a session.

    Raise `Cancelled` if the task has been cancelled.
    """
    engine, recorder = Engine(image, document.parameters, document.regions), RunRecorder()

    seeds = document.collect_seeds(document.find_image_seeds(SeedCache(image)))
    run = Evolution(engine, engine.start(seeds), document.parameters, charges=document.charges)
    for moment in run:
        task.check_cancelled()
        recorder(moment.state)
    session = add_recorded_run(to_session_file(document, {}), recorder, tr("Run {number}", number=1))
    return run.result, session.runs


def run_pages(
    source: StackSource,
    numbers: Sequence[int],
    document_of: Callable[[int, tuple[Start, ...]], tuple[Document, tuple[Start, ...]]],
    before: Sequence[Page],
    proposed: PageFollower,
    task: BackgroundTask,
) -> Iterator[tuple[Page, Page, KeptPage]]:
    """Run pages, and yield contours and objects of each; raise `Cancelled` if the task has been cancelled.

    `document_of` takes the number of a page and the starts along the contours of the previous page; it returns the
    document to run the page with, and the starts that were given. `before` are the pages before the first one.
    `proposed` follows the accepted objects of a page, else those that its run proposes.
    """
    follower = PageFollower(before)
    for place, number in enumerate(numbers):
        task.advance(place / len(numbers))
        known = follower.next_starts
        document, given = document_of(number, known)
        try:
            image = source.pages[number - 1]
            reference = ImageReference.from_image(Path(source.path), image, source.reading_for(number))
            document = replace(document, image=reference, parameters=limit_scales(document.parameters, image.shape))
            result, runs = run_recorded(image, document, task)
        except Cancelled:
            raise
        except Exception as error:  # one page must not end the others
            trouble = explain_failure(error, tr("running page {number}", number=number))
            failed = Page(number, None, error=trouble)
            yield failed, failed, KeptPage(document, given_starts=given)
            continue
        done = KeptPage(document, runs, given_starts=given, runs_unsaved=True)
        own = build_objects_result(document)
        continues = bool(known) and given == known
        objects = proposed.add_objects(number, result, continues) if own is None else proposed.add_page(number, own)
        yield follower.add_page(number, result), objects, done
