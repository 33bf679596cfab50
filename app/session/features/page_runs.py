"""Runs on the pages of a stack, one after the other, as the window would run them: in the background."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from app.model.document.document import Document, ImageReference
from app.model.text.language import tr
from app.session.exchange.core_functions import Core
from app.session.exchange.messages import sentence
from app.session.features.kept_pages import KeptPage, StackSource, bare, started_by, starts_along
from app.session.tasks.tasks import Cancelled, Task
from app.session.timeline.run_actions import RunAction, Stepped
from app.session.timeline.stored.plain_runs import FIGURES, RunsWriter
from app.session.timeline.stored_runs import StoredBranch, StoredRun, StoredRuns
from cpm_core.contours.contour import Contour
from cpm_core.contours.result import Result
from cpm_core.contours.review import apply, middle, with_kept
from cpm_core.image.image import Image
from cpm_core.pages.follow import Follower, fitting, trouble_of
from cpm_core.pages.page import Page
from cpm_core.segmentation.method import Method, MethodState
from cpm_core.shapes import Start
from cpm_core.shapes.image_starts import SeedCache

_NAME = tr("Run {number}").format(number=1)


@dataclass(frozen=True, eq=False, slots=True)
class PageOrder:
    """Which pages are run, and from where.

    Attributes
    ----------
    source : StackSource
        The stack.
    numbers : sequence of int
        The pages, from 1.
    base : Document
        The document whose parameters, limits, charges and start pages without their own take over.
    following : bool
        Whether each page starts from the contours of the one before.
    kept : mapping of int to KeptPage
        The pages that have a document already; those whose start a person has drawn keep it.
    before : tuple of Page
        What has been found on the pages before the first one.
    """

    source: StackSource
    numbers: Sequence[int]
    base: Document
    following: bool
    kept: Mapping[int, KeptPage]
    before: tuple[Page, ...] = ()

    def document(self, number: int, follower: Follower) -> tuple[Document, tuple[Start, ...]]:
        """The document that a page is run with, and the starts that it was given by the page before."""
        kept = self.kept.get(number)
        document = bare(self.base) if kept is None else replace(kept.document, parameters=self.base.parameters)
        if kept is not None and kept.own_start:
            return document, ()
        lines = follower.starts if self.following else ()
        given = starts_along(lines) or self.base.starts
        return started_by(document, given), given


@dataclass(frozen=True, eq=False, slots=True)
class PageDone:
    """A page that has been run: its document with the starts that it was given, its run and what was found."""

    page: Page
    document: Document
    given: tuple[Start, ...] = ()
    runs: Mapping[str, Any] | None = None


def run_pages(order: PageOrder, core: Core, task: Task) -> Iterator[PageDone]:
    """Run the pages of an order, each as soon as the one before is done; `Cancelled` when the task has been."""
    follower = Follower(order.before)
    for done, number in enumerate(order.numbers):
        task.advance(done / len(order.numbers))
        document, given = order.document(number, follower)
        try:
            image = order.source.pages[number - 1]
            reference = ImageReference.of(Path(order.source.path), image, order.source.reading_of(number))
            document = replace(document, image=reference, parameters=fitting(document.parameters, image))
            result, runs = _run(document, image, core, task)
        except Cancelled:
            raise
        except Exception as error:  # one page must not end the others
            known = isinstance(error, ValueError | MemoryError)
            trouble = trouble_of(error) if known else sentence(error, tr("running page {number}").format(number=number))
            yield PageDone(Page(number, None, trouble=trouble), document, given)
            continue
        page = follower.take(number, result)
        yield PageDone(page, document, given, runs(page.contours))


def _run(document: Document, image: Image, core: Core, task: Task) -> tuple[Result, _Runs]:
    """The result of the run of a document, without rejected contours, and the run for the timeline."""
    method = core.methods["cpm"](image, document.parameters, document.regions)
    seeds = SeedCache(image).seeds_for(
        document.image_starts, document.parameters.smoothing, document.regions, document.parameters.channel
    )
    state: MethodState = method.start(document.seeds(seeds))
    scales = [(0, state.scale)]
    while not state.stop_reason:
        task.check_cancelled()
        state = method.step(state, document.parameters, document.charges)
        if state.scale != scales[-1][1]:
            scales.append((state.step, state.scale))
    found = method.result(state, document.parameters)
    assert isinstance(found, Result)
    chosen = apply(with_kept(found, document.marks), document.marks)
    return chosen, _Runs(document, method, state, tuple(scales))


@dataclass(frozen=True, eq=False, slots=True)
class _Runs:
    """A run for the timeline of its page."""

    document: Document
    method: Method[Any]
    state: MethodState
    scales: tuple[tuple[int, int], ...]

    def __call__(self, contours: Sequence[Contour]) -> Mapping[str, Any]:
        """The run as a session keeps it, with its last state and the numbers of its contours."""
        document, last = self.document, self.state.step
        action: RunAction = Stepped(document.parameters, document.charges, self.method.regions)
        steps = ((), *(((action,),) * last))
        branch = StoredBranch(1, _NAME, False, None, 0, steps, self.scales, np.empty((FIGURES, 0)))
        run = StoredRun(document, document.sources, (branch,))
        numbers = {contour.number: middle(contour) for contour in contours}
        return RunsWriter().to_plain(StoredRuns((run,), (1, last), {(1, last): self.state}, numbers))
