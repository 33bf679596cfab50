"""The pages of a stack as a part of its session file: what each holds, and what was found on it."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

from app.model.document.document import Document
from app.model.document.saving import restored
from app.model.text.language import tr
from app.session.features.pages.kept_page import KeptPage
from app.session.features.pages.linking import Found
from app.session.features.pages.stack_source import StackSource
from cpm_core.formats.contours.pages.stack_json import page_from_plain, page_to_plain
from cpm_core.formats.sessions.session_file import decode, encode
from cpm_core.pages.page import StackResult
from cpm_core.shapes import Start
from cpm_core.shapes.document_shapes import check_axes

_MOST = 24 * 2**20
"""Largest size of the recorded runs of other pages in a session file [characters]; contours and drawings all stay."""

T = TypeVar("T")


@dataclass(frozen=True, eq=False, slots=True)
class StoredPages:
    """What a session file holds of the pages of a stack.

    Attributes
    ----------
    kept : mapping of int to KeptPage
        The pages that are not open, by number.
    found : mapping of int to Result or str
        What was found on each page, or why it could not be used.
    following : bool
        Whether each page starts from the contours of the one before.
    drawn : tuple of mapping
        What was drawn before all pages were run.
    given : tuple of Start
        Starts of the page that is open, if it was given them by the one before.
    trouble : str
        What had to be left out, in a sentence.
    """

    kept: Mapping[int, KeptPage] = field(default_factory=dict)
    found: Mapping[int, Found] = field(default_factory=dict)
    following: bool = True
    drawn: tuple[Mapping[str, Any], ...] = ()
    given: tuple[Start, ...] = ()
    trouble: str = ""

    def to_plain(self, here: int, result: StackResult | None) -> dict[str, Any]:
        """The pages but that which is open `here` as plain JSON; runs are left out beyond a size that can be read."""
        others = {number: page for number, page in sorted(self.kept.items()) if number != here}
        if not others and result is None:
            return {}
        left, sessions = _MOST, []
        for number, page in others.items():
            file = replace(page.file, image=None, view={}, runs={}, pages={}, extra={})
            session = json.loads(encode(file, Path()))
            size = len(json.dumps(page.file.runs))
            if page.file.runs and size <= left:
                left -= size
                session["runs"] = dict(page.file.runs)
            sessions.append({"page": number, "given": not page.own_start, "session": session})
        return {
            "following": self.following,
            "drawn": list(self.drawn),
            "given": bool(self.given),
            "sessions": sessions,
            "found": [] if result is None else [page_to_plain(page) for page in result.pages],
        }

    @classmethod
    def of(cls, plain: Mapping[str, Any], here: Document, source: StackSource) -> StoredPages:
        """The pages of a session file, of which that with the document `here` is open; what is damaged is left out."""

        def session(entry: Mapping[str, Any]) -> tuple[int, KeptPage]:
            number = _checked(entry["page"], source)
            file = decode(json.dumps(entry["session"]).encode(), tr("page {number}").format(number=number))
            image = here.image and replace(here.image, reading=source.reading_of(number))
            if image is None:
                raise ValueError("there is no image")
            check_axes(file.shapes, image.shape)
            document = restored(file, image, file.parameters)
            given = document.starts if entry.get("given") is True else ()
            return number, KeptPage(file, document, known=document, given=given)

        def found(entry: Mapping[str, Any]) -> tuple[int, Found]:
            page = page_from_plain(entry)
            return _checked(page.number, source), page.result or page.trouble

        kept, first = _read(plain, "sessions", session)
        pages, second = _read(plain, "found", found)
        drawn = tuple(shape for shape in _listed(plain, "drawn") if isinstance(shape, dict))
        given = here.starts if plain.get("given") is True else ()
        trouble = tr("Some pages of the stack are damaged in the session and were left out.")
        return cls(kept, pages, plain.get("following") is not False, drawn, given, trouble if first or second else "")


class PlainPages(Mapping[str, Any]):
    """Pages as plain JSON, made when it is asked for: on the thread that writes a file, and not in the window's."""

    def __init__(self, stored: StoredPages, here: int, result: StackResult | None) -> None:
        self._asked = stored, here, result

    @cached_property
    def _plain(self) -> dict[str, Any]:
        stored, here, result = self._asked
        return stored.to_plain(here, result)

    def __getitem__(self, name: str) -> Any:
        return self._plain[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._plain)

    def __len__(self) -> int:
        return len(self._plain)


def _read(
    plain: Mapping[str, Any], name: str, read: Callable[[Mapping[str, Any]], tuple[int, T]]
) -> tuple[dict[int, T], bool]:
    """The entries of a list by page, and whether any is damaged."""
    entries: dict[int, T] = {}
    damaged = False
    for entry in _listed(plain, name):
        try:
            number, value = read(entry)
            entries[number] = value
        except (KeyError, TypeError, ValueError, IndexError, AttributeError):
            damaged = True
    return entries, damaged


def _checked(given: object, source: StackSource) -> int:
    if type(given) is not int or not 1 <= given <= source.count:
        raise ValueError("there is no such page")
    return given


def _listed(plain: Mapping[str, Any], name: str) -> list[Any]:
    given = plain.get(name)
    return given if isinstance(given, list) else []
