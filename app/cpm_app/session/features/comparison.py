"""Comparison of results: of what is shown now and the runs on the timeline, with each other or with a ground truth."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import field, replace
from functools import partial
from pathlib import Path

import numpy as np
from PySide6.QtCore import QObject, QTimer, Signal

from cpm_app.model.display.differences import (
    Difference,
    SurfaceDifference,
    find_boundary_differences,
    find_surface_differences,
)
from cpm_app.model.document.document import Document
from cpm_app.model.document.objects import build_objects_result
from cpm_app.model.text.language import tr, translate_core_text
from cpm_app.session.exchange.messages import CommandFailed, Reconstruction
from cpm_app.session.features.background import IdentityCache, LatestOnlyWorker
from cpm_app.session.features.timeline_navigation import TimelineNavigation
from cpm_app.session.scene import Scene
from cpm_app.session.session import Session
from cpm_app.session.tasks.tasks import BackgroundTask
from cpm_app.session.worker.requests import FrameTaken, take_frame
from cpm_core import (
    Comparison,
    Image,
    Result,
    SurfaceComparison,
    Truth,
    VolumeTruth,
    compare,
    compare_surface,
    load_truth,
    load_volume_truth,
)
from cpm_core.contours import DEFAULT_TOLERANCE, label_voxels, truth_from_contours
from cpm_core.formats import TruthFile, locate_file
from cpm_core.numerics.types import record
from cpm_core.results import boundaries_result

CURRENT_KEY = 0
"""Key of the present result; branches of the timeline have their numbers."""

TRUTH_KEY = -1
"""Key of the ground truth."""

_COMPARISON_CATEGORY = "comparing"
"""Category of messages about the comparison."""

_COMPARISON_DELAY = 200
"""Time without another step after which another run is shown at the same step [ms]."""

TruthComparison = Comparison | SurfaceComparison
_MarkedDifferences = tuple[tuple[Difference, ...], tuple[SurfaceDifference, ...]]


@record
class ComparisonRow:
    """A result that is compared.

    Attributes
    ----------
    key : int
        What it is: `CURRENT_KEY`, `TRUTH_KEY`, or the number of a branch.
    title : str
        Its name.
    found : Result or None
        Contours or a surface; None while there are none.
    scene : Scene
        Scene of the result, without the image.
    truth : Truth, VolumeTruth or None
        The ground truth, if the row is one.
    """

    key: int
    title: str
    found: Result | None = None
    scene: Scene = field(default_factory=Scene)
    truth: Truth | VolumeTruth | None = None

    @property
    def count(self) -> int | None:
        """Number of objects, or of contours; in a volume of objects, or of parts of the surface."""
        if self.found is None:
            return None
        if self.truth is not None:
            return int(self.truth.objects.max())
        if self.found.surface is not None:
            numbers = self.found.surface.numbers
            return self.found.surface.components if numbers is None else len(np.unique(numbers))
        return len({contour.group or -index for index, contour in enumerate(self.found.contours, start=1)})


class ComparedResults(QObject):
    """Compares all results with the reference on a separate thread: with the ground truth, or with what is shown now.

    The canvas shows the selected result beyond the divider. A branch of the timeline is taken when it is selected, at
    its end, or at the shown step if the run is not at an end. In a volume the tolerance is in smallest sides of a
    voxel.
    """

    changed = Signal()
    """The rows, their figures or the reference have changed."""
    selection_changed = Signal()
    """Another row is selected, or its scene has changed."""

    def __init__(self, session: Session, navigation: TimelineNavigation) -> None:
        super().__init__(session)
        self.selected = CURRENT_KEY
        self.agreements: dict[int, TruthComparison] = {}
        """Agreement with the reference by row."""
        self.tolerance, self.holes = DEFAULT_TOLERANCE, True
        self._found: dict[int, ComparisonRow] = {}
        """Branches that have been selected, by their numbers, and the ground truth."""
        self._truth_path: Path | None = None
        self._present: Result | None = None
        """The present result when rows were compared last."""
        self._titles: dict[int, str] = {}
        """Names of the branches of the timeline."""
        self._session, self._navigation = session, navigation
        self._seen, self._made = IdentityCache(), IdentityCache()
        self._latest = LatestOnlyWorker(session, "cpm-comparison", tr("comparing results"))
        self._quiet = QTimer(self, singleShot=True, interval=_COMPARISON_DELAY)
        self._quiet.timeout.connect(self._request_branch_frame)
        self._quiet.timeout.connect(self._update_current_row)
        session.store.scene_changed.connect(self._on_scene_changed)
        session.image_changed.connect(self.clear)
        navigation.changed.connect(self._on_timeline_changed)

    @property
    def rows(self) -> Mapping[int, ComparisonRow]:
        """The results: what is shown now, the branches of the timeline, and the ground truth."""
        shown = {CURRENT_KEY: ComparisonRow(CURRENT_KEY, tr("Shown now"), self._present)}
        for key, title in self._titles.items():
            shown[key] = replace(self._found.get(key, ComparisonRow(key, "")), title=title)
        if TRUTH_KEY in self._found:
            shown[TRUTH_KEY] = self._found[TRUTH_KEY]
        return shown

    @property
    def reference(self) -> int:
        """The row with which all others are compared: the ground truth, or else the present result."""
        return TRUTH_KEY if TRUTH_KEY in self._found else CURRENT_KEY

    @property
    def in_volume(self) -> bool:
        """Whether a volume is open, whose surface is compared."""
        return self._session.image is not None and self._session.image.ndim == 3

    @property
    def subject(self) -> int:
        """The row whose differences from the reference are marked: the selected one, or else the present result."""
        return self.selected if self.selected != self.reference else CURRENT_KEY

    def remove_truth(self) -> None:
        """Remove the ground truth."""
        if self._found.pop(TRUTH_KEY, None) is not None:
            self._truth_path = None
            self._begin_comparison()

    def clear(self) -> None:
        """Forget all results, because another image has been opened."""
        self._latest.drop_waiting()
        self._found, self._truth_path, self._made = {}, None, IdentityCache()
        self._begin_comparison()

    def select_row(self, key: int) -> None:
        """Show a row beyond the divider; the present result removes the divider."""
        if key != self.selected and key in self.rows:
            self.selected = key
            self._request_branch_frame()
            self.selection_changed.emit()
            self._compare_rows()

    def scene_beyond_divider(self) -> Scene:
        """Return the scene that is shown beyond the divider."""
        scene = self._session.scene
        return replace(
            self.rows[self.selected].scene, image=scene.image, display=scene.display, shaded=scene.shaded,
            overlays=scene.overlays, slices=scene.slices, truth=scene.truth, differences=scene.differences,
            surface_differences=scene.surface_differences,
        )  # fmt: skip

    # Ground truth

    def load_truth_file(self, path: str | Path) -> None:
        """Read a ground truth, which becomes the reference: a mask or contours for an image, labels for a volume."""
        image = self._session.image
        self._session.messages.clear(_COMPARISON_CATEGORY)
        if image is None:
            return
        file, generation, holes = Path(path), self._session.store.image_generation, self.holes

        def use_truth(row: ComparisonRow) -> None:
            if generation == self._session.store.image_generation:
                self._found[TRUTH_KEY], self._truth_path = row, file
                self._begin_comparison()
                if row.truth is not None and row.truth.notes:
                    sentences = " ".join(map(translate_core_text, row.truth.notes))
                    self._session.messages.show(f"{file.name}: {sentences}", category=_COMPARISON_CATEGORY)

        self._session.tasks.start_task(
            tr("Reading {name}…", name=file.name),
            lambda task: _read_truth(file, image, holes),
            tr("reading {name}", name=file.name),
            partial(CommandFailed, category=_COMPARISON_CATEGORY),
            on_result=use_truth,
        )

    @property
    def truth_file(self) -> TruthFile | None:
        """The ground truth as stored in a session."""
        if self._truth_path is None:
            return None
        return TruthFile(str(self._truth_path.absolute()), tolerance=self.tolerance, holes=self.holes)

    def restore_truth(self, file: TruthFile, folder: Path) -> None:
        """Load the ground truth of a session that lies in a folder."""
        self.tolerance, self.holes = file.tolerance, file.holes
        self.load_truth_file(locate_file(file, folder))

    def set_tolerance(self, tolerance: float) -> None:
        """Set the distance up to which boundaries count as the same [px]."""
        self.tolerance = tolerance
        self._compare_rows()

    def set_holes(self, holes: bool) -> None:
        """Set whether a contour inside another one is a hole."""
        self.holes = holes
        if self._truth_path is not None:
            self.load_truth_file(self._truth_path)
        self._compare_rows()

    # Internal

    def _begin_comparison(self) -> None:
        """Compare all rows with another reference."""
        self.agreements = {}
        if self.selected not in self.rows:
            self.selected = CURRENT_KEY
        self.selection_changed.emit()
        self._show_differences(self.rows[self.reference].truth)
        self._compare_rows()
        self.changed.emit()

    def _on_timeline_changed(self) -> None:
        """Show the branches that there are now."""
        titles = {branch.identity: branch.name for branch in self._navigation.branches}
        if titles != self._titles:
            self._titles = titles
            self._found = {key: row for key, row in self._found.items() if key in titles or key == TRUTH_KEY}
            self.select_row(self.selected if self.selected in self.rows else CURRENT_KEY)
            self._compare_rows()
            self.changed.emit()

    def _request_branch_frame(self) -> None:
        """Request the frame of the selected branch of the timeline, at its end or at the current step."""
        key, (here, step) = self.selected, self._navigation.current_step
        branch = self._navigation.find_branch(key)
        if branch is None:
            return
        last = self._navigation.last_step(key)
        wanted = last if step >= self._navigation.last_step(here) else min(step, last)
        shown = self.rows[key].scene.snapshot
        if shown is None or shown.state.step != wanted:
            take = partial(self._on_frame_taken, key, self._session.scene.document)
            task, generation = BackgroundTask(branch.name), self._session.store.generation
            self._session.post_command(take_frame(task, generation, key, wanted, True, take))

    def _on_frame_taken(self, key: int, document: Document, frame: FrameTaken) -> None:
        if frame.snapshot is not None and key in self.rows:
            shown = Scene(document=Document(mode=document.mode), snapshot=frame.snapshot, reconstruction=frame.contours)
            self._found[key] = ComparisonRow(key, "", shown.result, shown)
            if key == self.selected:
                self.selection_changed.emit()
            self._compare_rows()
            self.changed.emit()

    @property
    def _current_result(self) -> Result | None:
        """The present result: the objects, if there are any, or else the contours of the run."""
        scene = self._session.scene
        objects = self._seen.get_named(
            "objects", lambda: build_objects_result(scene.document), scene.document.objects.items
        )
        return objects or scene.result

    def _on_scene_changed(self) -> None:
        """Compare the present result again, and show the selected branch at the same step.

        This waits for objects of a volume, which change many times while they are painted; their surfaces take long.
        """
        if not self._found:
            return
        painted = self.in_volume and bool(self._session.document.objects.items)
        if not painted:
            self._update_current_row()
        if painted or self.selected > CURRENT_KEY:
            self._quiet.start()

    def _update_current_row(self) -> None:
        """Compare the present result again if it has changed."""
        if self._current_result is not self._present:
            self._compare_rows()
            self.changed.emit()

    def _compare_rows(self) -> None:
        """Compare the rows with the reference; during a run only the one whose differences are marked."""
        self._present = self._current_result if self._found else None
        known, image = self.rows, self._session.image
        reference, subject = known[self.reference], known[self.subject]
        everything = self._session.status.phase != "running"
        rows = [
            (row.key, row.found) for row in known.values()
            if row.found is not None and row is not reference and (everything or row is subject)
        ]  # fmt: skip
        if image is None or reference.found is None or not rows:
            self.agreements = {}
            self._show_differences(reference.truth)
            return
        tolerance, holes = self.tolerance, self.holes

        def compare_rows() -> tuple[Truth | VolumeTruth, dict[int, TruthComparison], _MarkedDifferences]:
            make, named = partial(_truth_from_row, reference, holes), self._made.get_named
            truth = reference.truth or named("reference", make, reference.found, holes)
            agreed = {
                key: named(
                    key, partial(_compare_with_truth, found, truth, tolerance, holes), found, truth, tolerance, holes
                )
                for key, found in rows
            }
            return truth, agreed, _find_differences(subject.found, truth, agreed.get(subject.key))

        def show_agreement(done: tuple[Truth | VolumeTruth, dict[int, TruthComparison], _MarkedDifferences]) -> None:
            truth, agreed, marked = done
            if reference.key == self.reference and image is self._session.image:
                self.agreements = agreed if everything else {**self.agreements, **agreed}
                self._show_differences(truth if reference.key else None, marked)
                self.changed.emit()

        # after an error: no figures rather than those of other contours
        self._latest.submit(compare_rows, show_agreement, lambda: self._show_differences(reference.truth))

    def _show_differences(self, truth: Truth | VolumeTruth | None, marked: _MarkedDifferences = ((), ())) -> None:
        scene, (different, apart) = self._session.scene, marked
        if (truth, different, apart) != (scene.truth, scene.differences, scene.surface_differences):
            self._session.store.set_scene(replace(scene, truth=truth, differences=different, surface_differences=apart))


def _read_truth(file: Path, image: Image, holes: bool) -> ComparisonRow:
    """Read the ground truth of an image, or of a volume with everything that its slices need."""
    truth: Truth | VolumeTruth
    if image.ndim == 2:
        truth = load_truth(file, image.shape, holes=holes, spacing=image.spacing, unit=image.unit, name=image.source)
        contours, surface = truth.contours, None
    else:
        truth = load_volume_truth(file, image)
        contours, surface = (), truth.surface
    found = boundaries_result(image.shape, file.name, image.spacing, image.unit, contours=contours, surface=surface)
    _ = truth.objects  # cached on this thread, not on the window's
    scene = Scene(reconstruction=Reconstruction(0, found))
    return ComparisonRow(TRUTH_KEY, file.name, found, scene, truth=truth)


def _truth_from_row(row: ComparisonRow, holes: bool) -> Truth | VolumeTruth:
    """Convert a result into a ground truth; raise ValueError for a surface that is not closed."""
    assert row.found is not None
    found, surface = row.found, row.found.surface
    if len(found.shape) == 2:
        return truth_from_contours(found.contours, found.shape, row.title, holes=holes)
    if surface is None or not surface.closed:
        raise ValueError(tr("The surface of {name} is not closed, so nothing can be compared with it.", name=row.title))
    labels = label_voxels(surface, found.shape).astype(np.int32)
    return VolumeTruth(labels, found.spacing, found.unit, row.title, boundary=surface)


def _compare_with_truth(found: Result, truth: Truth | VolumeTruth, tolerance: float, holes: bool) -> TruthComparison:
    if isinstance(truth, Truth):
        return compare(found.contours, truth, tolerance, holes=holes)
    known = _with_spacing_of(truth, found)
    return compare_surface(found.surface, known, tolerance * min(known.spacing))


def _with_spacing_of(truth: VolumeTruth, found: Result) -> VolumeTruth:
    """Return the ground truth with the voxel size of a result."""
    if (found.spacing, found.unit) == (truth.spacing, truth.unit):
        return truth
    return replace(truth, spacing=found.spacing, unit=found.unit)


def _find_differences(
    found: Result | None, truth: Truth | VolumeTruth, agreed: TruthComparison | None
) -> _MarkedDifferences:
    """Find where a result differs from the reference, the largest first; in a volume also as parts of surfaces."""
    if found is None or agreed is None:
        return (), ()
    if isinstance(truth, VolumeTruth) and isinstance(agreed, SurfaceComparison):
        apart = find_surface_differences(found.surface, _with_spacing_of(truth, found), agreed)
        parts = itertools.chain.from_iterable(each.components for each in apart)
        return tuple(sorted(parts, key=lambda part: -part.farthest)), apart
    assert isinstance(agreed, Comparison)
    return find_boundary_differences(found.contours, agreed), ()
