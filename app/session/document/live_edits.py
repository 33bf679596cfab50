"""Steering: what is drawn, moved or taken back while a run exists acts in it at once.

Regions of interest, barriers and placed charges hold for every run: the worker is told whenever they change, and of
many changes in a row it obeys the last. Starts that are added bring their particles when the gesture ends that draws
them. A start that is moved or removed has let its particles go already; the run is then out of date, no more.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable
from dataclasses import replace

from app.model.document import edits
from app.model.document.document import Document
from app.model.text.language import tr
from app.session.document.editing import Editing
from app.session.updates import Progress
from app.session.worker.commands.run import Command, FindSeeds, RunCall
from app.session.worker.run import Run
from cpm_core.numerics.types import Position
from cpm_core.shapes import Points, Region, Shape, Start


class Live:
    """Compares documents, and tells the worker what has changed, above all for the run that exists.

    Parameters
    ----------
    session : Editing
        Whose document and run they are.
    progress : Progress
        How the run stands.
    post : callable
        Sends a command to the worker.
    """

    def __init__(self, session: Editing, progress: Progress, post: Callable[[Command], None]) -> None:
        self._session = session
        self._progress = progress
        self._post = post
        self._late: tuple[object, ...] = ()
        self._executed: Counter[Hashable] = Counter()
        self._settled: Counter[Hashable] = Counter()
        self._looked_at: tuple[Shape, ...] | None = None
        self._judged: tuple[tuple[Shape, ...] | None, Counter[Hashable], bool] = (None, self._executed, False)

    def begin(self, document: Document) -> None:
        """A run starts from a document."""
        self._late = document.late
        self._executed = self._settled = document.sources
        self._looked_at = document.shapes

    def outdated(self, document: Document) -> bool:
        """Whether a run that started from the document now would begin otherwise than the one that exists did.

        What has only been added joins the run.
        """
        advance, executed, lost = self._judged
        # A window asks many times a second, and many thousand points take a while to go through.
        if advance is not document.shapes or executed is not self._executed:
            lost = bool(self._executed - document.sources)
            self._judged = (document.shapes, self._executed, lost)
        return lost or document.late != self._late

    def follow(self, before: Document, after: Document, settled: bool) -> None:
        """The document has changed; unless it is `settled`, the gesture goes on that changes it."""
        session = self._session
        if before.parameters != after.parameters:
            self._post(RunCall(None, Run.set_parameters, after.parameters))
        if after.sowable and before.sowing != after.sowing:
            self._progress.busy("sowing", tr("Looking for places to start from…"))
            self._post(FindSeeds(session.image_generation, after))
        if before.charges != after.charges:
            self._post(RunCall(None, Run.place, session.image_generation, after.charges))
        if not self._progress.status.started:
            return
        if before.regions != after.regions:
            self._post(RunCall(session.generation, Run.limit, after.regions))
        if settled:
            self.settle()

    def settle(self) -> None:
        """A gesture has ended: the starts that it has added join the run."""
        document = self._session.document
        if document.shapes is self._looked_at:
            return  # parameters, most often, and many points take a while to go through
        self._looked_at = document.shapes
        drawn = document.sources
        lost, gained = self._settled - drawn, drawn - self._settled
        self._settled = drawn
        if not self._progress.status.started or lost.total() == gained.total():
            return  # nothing, or a start that was moved or reshaped
        new = (drawn - self._executed) & gained
        if new:
            self._executed = self._executed + new
            self._post(RunCall(self._session.generation, Run.join, _only(document, new)))

    def erase(self, path: tuple[Position, ...], radius: float) -> Document:
        """Take away the particles near a path, and tell what the document is without the shapes near it.

        The run obeys that as well as the document, so that it is not out of date afterwards.
        """
        session = self._session
        rest = edits.erase(session.document, path, radius)
        self._executed = self._executed - (session.document.sources - rest.sources)
        if self._progress.status.started:
            self._post(RunCall(session.generation, Run.erase, path, radius))
        return rest


def _only(document: Document, sources: Counter[Hashable]) -> Document:
    """The document with these sources alone, in its regions of interest."""
    points = tuple(source for source in sources.elements() if isinstance(source, tuple))
    starts = [source for source in sources.elements() if isinstance(source, Start)]
    regions = [shape for shape in document.shapes if isinstance(shape, Region)]
    return replace(document, shapes=(*starts, *([Points(points)] if points else []), *regions))
