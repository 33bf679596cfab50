"""The run updater: edits of the document change the existing run at once.

Regions of interest, barriers and placed charges apply to every run: each change is sent to the worker, which executes
only the last of many changes in a row. The particles of new starts join the run when the gesture that draws them ends.
When a start is moved or removed after the run has begun, the run is only marked as out of date.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable, Mapping
from dataclasses import replace

import numpy as np

from cpm_app.model.document import edits
from cpm_app.model.document.document import Document
from cpm_app.model.document.modes import needs_start
from cpm_app.model.text.language import tr
from cpm_app.session.scene_store import SceneStore
from cpm_app.session.timeline.branches import starts_from_sources
from cpm_app.session.timeline.timeline_nodes import EraseAction
from cpm_app.session.worker.commands import WorkerCommand, call_run, find_seeds
from cpm_app.session.worker.run import Run
from cpm_core.numerics import Place
from cpm_core.shapes import Interest, Measure, Shape

_MOTION_ALLOWANCE = 2.0
"""Distance by which particles may have moved since they were shown [px]."""

_NO_SOURCES: Counter[Hashable] = Counter()
"""Sources of the particles while no run is shown."""


class RunUpdater:
    """Sends the differences between two documents to the worker."""

    def __init__(self, store: SceneStore, post: Callable[[WorkerCommand], None]) -> None:
        self._store = store
        self._post = post
        self._run = 0
        self._documents_by_run: dict[int, Document] = {}
        """The document that each run has begun from, with the mode that it serves now, by its generation."""
        self.sources_by_run: dict[int, Counter[Hashable]] = {}
        """The sources of the particles of each run, by its generation."""
        self._last_start_counts: Counter[Hashable] = Counter()
        self._last_shapes: tuple[Shape, ...] | None = None
        self._outdated: tuple[tuple[Shape, ...] | None, Counter[Hashable] | None, bool] = (None, None, False)

    def begin_run(self, run: int, document: Document) -> None:
        """Record that the run of this generation starts from a document."""
        self._run = run
        self._documents_by_run[run], self.sources_by_run[run] = document, document.start_counts
        self._last_start_counts, self._last_shapes = document.start_counts, document.shapes

    def set_current_run(self, run: int) -> None:
        """Make the run of the timeline that began as this generation the current one."""
        if run in self.sources_by_run:
            self._run = run

    def restore_runs(self, begun: Mapping[int, tuple[Document, Counter[Hashable]]]) -> None:
        """Take over the runs of a session: their first documents and the sources of their particles."""
        document = self._store.scene.document
        self._last_start_counts, self._last_shapes = document.start_counts, document.shapes
        for run, (first, sources) in begun.items():
            self._documents_by_run[run] = replace(first, image=document.image)
            self.sources_by_run[run] = sources

    def clear(self) -> None:
        """Remove all runs, because another image has been opened."""
        self._documents_by_run.clear()
        self.sources_by_run.clear()
        self._run = 0

    @property
    def _current_sources(self) -> Counter[Hashable]:
        """The sources of the particles of the run that is shown."""
        return self.find_sources(self._run)

    def find_sources(self, run: int) -> Counter[Hashable]:
        """Return the sources of the particles of a run, by its generation."""
        return self.sources_by_run.get(run, _NO_SOURCES)

    def restore_sources(self, run: int, sources: Counter[Hashable]) -> None:
        """Make a run the current one, with the sources that its particles had at an earlier step."""
        self.sources_by_run[run] = sources
        self._run = run

    def _set_current_sources(self, sources: Counter[Hashable]) -> None:
        if self._run in self.sources_by_run:
            self.sources_by_run[self._run] = sources

    def is_outdated(self, document: Document) -> bool:
        """Return whether a run from the current document would begin differently from the existing one.

        Starts that have only been added join the run. A skeleton depends on the objects that it is made for.
        """
        begun, sources = self._documents_by_run.get(self._run), self._current_sources
        if begun is not None and not needs_start(begun.mode):
            return begun.skeleton_inputs != document.skeleton_inputs
        # The window asks many times a second, and many thousand points take a while to compare.
        if document.shapes is not self._outdated[0] or sources is not self._outdated[1]:
            self._outdated = document.shapes, sources, bool(sources - document.start_counts)
        return self._outdated[2] or begun is None or document.start_inputs != begun.start_inputs

    def continue_run(self, document: Document) -> None:
        """Let the run go on in the mode of the document, which has only now been chosen for it."""
        if not self._is_served(document):
            self._documents_by_run[self._run] = replace(self._documents_by_run[self._run], mode=document.mode)
            self._post(call_run(None, Run.set_parameters, document.parameters))

    def _is_served(self, document: Document) -> bool:
        """Return whether the mode of a document is that of the run; true without a run.

        The parameters of another mode are for the next run, and must not change what this one has found.
        """
        begun = self._documents_by_run.get(self._run) if self._store.status.started else None
        return begun is None or begun.mode == document.mode

    def update_run(self, before: Document, after: Document, complete: bool, resumes: bool) -> None:
        """Send the changes of the document to the worker.

        Unless `complete`, the gesture is still going on; unless it `resumes`, a run that has ended stays where it is.
        """
        if (before.parameters, before.mode) != (after.parameters, after.mode) and self._is_served(after):
            running = self._store.status.phase == "running"
            self._post(call_run(None, Run.set_parameters, after.parameters, resumes and running))
        if _find_start_inputs(before) != _find_start_inputs(after):
            self._post(call_run(None, Run.set_start, after))
        if after.image_starts and before.seeding_inputs != after.seeding_inputs:
            self._store.set_busy("seeding", tr("Looking for starting positions…"))
            self._post(find_seeds(self._store.image_generation, after))
        if before.charges != after.charges:
            self._post(call_run(None, Run.set_charges, self._store.image_generation, after.charges, resumes))
        if not self._store.status.started:
            return
        if before.regions != after.regions:  # an object that is frozen leaves a run at rest as it is
            drawn = before.shapes != after.shapes
            self._post(call_run(self._store.generation, Run.set_regions, after.regions, resumes and drawn))
        if complete:
            self.end_gesture()

    def end_gesture(self) -> None:
        """End a gesture: the starts that it has added join the run."""
        document = self._store.scene.document
        if document.shapes is self._last_shapes:
            return  # most often only parameters changed, and many points take a while to compare
        self._last_shapes = document.shapes
        drawn = document.start_counts
        lost, gained = self._last_start_counts - drawn, drawn - self._last_start_counts
        self._last_start_counts = drawn
        if not self._store.status.started or lost.total() == gained.total():
            return  # no change, or a start that was moved or reshaped
        new = (drawn - self._current_sources) & gained
        if new:
            self._set_current_sources(self._current_sources + new)
            regions = (shape for shape in document.shapes if isinstance(shape, Interest))
            only = replace(document, shapes=(*starts_from_sources(new), *regions))
            self._post(call_run(self._store.generation, Run.add_particles, only))

    def erase_particles(self, path: tuple[Place, ...], radius: float, gesture: str) -> tuple[Document, bool]:
        """Remove the particles near a path; return the document without its shapes there, and whether the run changes.

        Run and document stay consistent, so that the run is not out of date afterwards.
        """
        rest = edits.erase_shapes(self._store.scene.document, path, radius)
        lost = self._current_sources & (self._store.scene.document.start_counts - rest.start_counts)
        self._set_current_sources(self._current_sources - lost)
        if not self._store.status.started:
            return rest, False
        self._post(call_run(self._store.generation, Run.erase_particles, path, radius, gesture))
        # the window knows where particles were a moment ago; while they move, they may be some pixels farther on
        scene, erased = (
            self._store.scene,
            EraseAction(path, radius + _MOTION_ALLOWANCE * (self._store.status.phase == "running")),
        )
        if lost or scene.snapshot is None or scene.image is None:
            return rest, True
        return rest, bool(np.any(erased.is_near_path(scene.snapshot.position, scene.image.spacing)))


def _find_start_inputs(document: Document) -> tuple[object, ...]:
    """Return all that the area of a start depends on besides the parameters."""
    acting = tuple(shape for shape in document.shapes if not isinstance(shape, Measure))
    return document.image, document.mode, acting, document.objects.barriers
