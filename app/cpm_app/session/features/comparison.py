"""Comparison of results: each with a reference, which is one of them or a ground truth."""

from __future__ import annotations

import itertools
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
from cpm_app.model.document.imported import add_objects, objects_from_contours, objects_from_surface
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
    Contour,
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
from cpm_core.formats import TruthFile
from cpm_core.formats.contours import mask
from cpm_core.numerics.types import JsonDict, record
from cpm_core.objects.segmented import SegmentedObject
from cpm_core.results import boundaries_result

CURRENT_KEY = 0
"""Key of the present result, which is always compared."""

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
        Its number, which stays the same.
    title : str
        Its name.
    found : Result or None
        Contours or a surface; None while there are none.
    scene : Scene
        Scene of the result, without the image.
    state : str
        Progress of the result, or its error; empty once it is there.
    branch : int or None
        Branch of the timeline that it is taken from.
    truth : Truth, VolumeTruth or None
        The ground truth, if the row is one.
    """

    key: int
    title: str
    found: Result | None = None
    scene: Scene = field(default_factory=Scene)
    state: str = ""
    branch: int | None = None
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

    @property
    def is_usable(self) -> bool:
        """Whether the document can take over something from the row."""
        return self.key != CURRENT_KEY and self.found is not None


class ComparedResults(QObject):
    """Holds results, and compares all of them with the reference on a separate thread.

    The canvas shows the selected result beyond the divider. In a volume the tolerance is in smallest sides of a voxel.
    """

    changed = Signal()
    """The rows, their figures or the reference have changed."""
    selection_changed = Signal()
    """Another row is selected, or its scene has changed."""

    def __init__(self, session: Session, navigation: TimelineNavigation) -> None:
        super().__init__(session)
        self.reference = self.selected = CURRENT_KEY
        self.rows = {CURRENT_KEY: ComparisonRow(CURRENT_KEY, tr("Shown now"))}
        self.agreements: dict[int, TruthComparison] = {}
        """Agreement with the reference by row."""
        self.tolerance, self.holes = DEFAULT_TOLERANCE, True
        self._truth_path: Path | None = None
        self._keys = itertools.count(1)
        self._session, self._navigation = session, navigation
        self._seen, self._made = IdentityCache(), IdentityCache()
        self._latest = LatestOnlyWorker(session, "cpm-comparison", tr("comparing results"))
        self._quiet = QTimer(self, singleShot=True, interval=_COMPARISON_DELAY)
        self._quiet.timeout.connect(self._request_branch_frame)
        self._quiet.timeout.connect(self._update_current_row)
        session.store.scene_changed.connect(self._on_scene_changed)
        session.image_changed.connect(self.clear)

    @property
    def in_volume(self) -> bool:
        """Whether a volume is open, whose surface is compared."""
        return self._session.image is not None and self._session.image.ndim == 3

    @property
    def subject(self) -> int:
        """The row whose differences from the reference are marked: the selected one, or else the present result."""
        return self.selected if self.selected != self.reference else CURRENT_KEY

    # Rows

    def keep_current(self) -> None:
        """Keep the present result, so that later ones can be compared with it."""
        scene = self._session.scene
        step = scene.snapshot.state.step if scene.snapshot is not None else 0
        title = tr("Kept, step {step}", step=step) if step else tr("Kept")
        shown = Scene(document=scene.document, snapshot=scene.snapshot, reconstruction=scene.reconstruction)
        self._add_row(ComparisonRow(next(self._keys), title, self._current_result, shown))

    def add_branch(self, identity: int) -> None:
        """Add another run or branch of the timeline, at its end, or at the shown step if the run is not at an end."""
        branch = self._navigation.find_branch(identity)
        if branch is not None:
            row = ComparisonRow(next(self._keys), branch.name, state=tr("waiting"), branch=identity)
            self._add_row(row)
            self._request_branch_frame(row.key)

    def remove_row(self, key: int) -> None:
        """Remove a row; the present result stays."""
        if key == CURRENT_KEY or key not in self.rows:
            return
        if self.rows.pop(key).truth is not None:
            self._truth_path = None
        if key == self.selected:
            self.selected = CURRENT_KEY
            self.selection_changed.emit()
        self.set_reference(self.reference if key != self.reference else CURRENT_KEY)

    def clear(self) -> None:
        """Remove all rows, because another image has been opened."""
        self._latest.drop_waiting()
        self.rows, self._truth_path, self._made = (
            {CURRENT_KEY: ComparisonRow(CURRENT_KEY, tr("Shown now"))},
            None,
            IdentityCache(),
        )
        self.reference = self.selected = CURRENT_KEY
        self.selection_changed.emit()
        self.set_reference(CURRENT_KEY)

    # Selection and reference

    def select_row(self, key: int) -> None:
        """Show a row beyond the divider; the present result removes the divider."""
        if key != self.selected and key in self.rows:
            self.selected = key
            self._request_branch_frame()
            self.selection_changed.emit()
            self._compare_rows()

    def set_reference(self, key: int) -> None:
        """Compare all other rows with this one."""
        self.reference, self.agreements = key, {}
        self._show_differences(self.rows[key].truth)
        self._compare_rows()
        self.changed.emit()

    def use_row(self, key: int) -> None:
        """Apply a row to the session: go to its branch, or add its contours as objects."""
        row, image = self.rows[key], self._session.image
        found = row.found
        if row.branch is not None:
            self._navigation.go_to(row.branch, self._navigation.last_step(row.branch))
        elif found is not None and image is not None:
            self._session.tasks.start_task(
                tr("Adding objects from {name}…", name=row.title),
                lambda task: _objects_from_row(row, found, image),
                tr("adding objects from {name}", name=row.title),
                partial(CommandFailed, category=_COMPARISON_CATEGORY),
                on_result=lambda made: self._session.edit(
                    tr("add objects from {name}", name=row.title), lambda document: add_objects(document, made)
                ),
            )

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

        def add_truth(row: ComparisonRow) -> None:
            if generation == self._session.store.image_generation:
                known = (each.key for each in self.rows.values() if each.truth is not None)
                key, self._truth_path = next(known, CURRENT_KEY) or next(self._keys), file
                self._add_row(replace(row, key=key))
                self.set_reference(key)
                if row.truth is not None and row.truth.notes:
                    sentences = " ".join(map(translate_core_text, row.truth.notes))
                    self._session.messages.show(f"{file.name}: {sentences}", category=_COMPARISON_CATEGORY)

        self._session.tasks.start_task(
            tr("Reading {name}…", name=file.name),
            lambda task: _read_truth(file, image, holes),
            tr("reading {name}", name=file.name),
            partial(CommandFailed, category=_COMPARISON_CATEGORY),
            on_result=add_truth,
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
        beside = folder / file.path
        self.load_truth_file(beside if beside.exists() or not file.absolute else file.absolute)

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

    def close(self) -> None:
        """End the thread."""
        self._latest.close()

    # Internal

    def _add_row(self, row: ComparisonRow) -> None:
        """Add a row, or replace the one with its key; later rows with the same title get a number."""
        self.rows[CURRENT_KEY] = replace(self.rows[CURRENT_KEY], found=self._current_result)
        titles = {other.title for other in self.rows.values() if other.key != row.key}
        names = (f"{row.title} ({number})" if number > 1 else row.title for number in itertools.count(1))
        self.rows[row.key] = replace(row, title=next(name for name in names if name not in titles))
        self._compare_rows()
        self.changed.emit()

    def _change_row(self, key: int, parts: JsonDict) -> None:
        if key in self.rows:
            self.rows[key] = replace(self.rows[key], **parts)
            if key == self.selected:
                self.selection_changed.emit()
            self._compare_rows()
            self.changed.emit()

    def _request_branch_frame(self, key: int | None = None) -> None:
        """Request the frame of a branch of the timeline, by default the selected one, at the current step."""
        row, (here, step) = self.rows[self.selected if key is None else key], self._navigation.current_step
        if row.branch is None or self._navigation.find_branch(row.branch) is None:
            return
        last = self._navigation.last_step(row.branch)
        wanted = last if step >= self._navigation.last_step(here) else min(step, last)
        shown = row.scene.snapshot
        if shown is None or shown.state.step != wanted:
            take = partial(self._on_frame_taken, row.key, self._session.scene.document)
            task, generation = BackgroundTask(row.title), self._session.store.generation
            self._session.post_command(take_frame(task, generation, row.branch, wanted, True, take))

    def _on_frame_taken(self, key: int, document: Document, frame: FrameTaken) -> None:
        if frame.snapshot is None:
            self._change_row(key, {"state": frame.message or tr("This run no longer exists.")})
            return
        shown = Scene(document=Document(mode=document.mode), snapshot=frame.snapshot, reconstruction=frame.contours)
        self._change_row(key, {"found": shown.result, "scene": shown, "state": ""})

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
        if len(self.rows) == 1:
            return
        painted = self.in_volume and bool(self._session.document.objects.items)
        if not painted:
            self._update_current_row()
        if painted or self.rows[self.selected].branch is not None:
            self._quiet.start()

    def _update_current_row(self) -> None:
        """Compare the present result again if it has changed."""
        found = self._current_result
        if found is not self.rows[CURRENT_KEY].found:
            self.rows[CURRENT_KEY] = replace(self.rows[CURRENT_KEY], found=found)
            self._compare_rows()
            self.changed.emit()

    def _compare_rows(self) -> None:
        """Compare the rows with the reference; during a run only the one whose differences are marked."""
        reference, subject, image = self.rows[self.reference], self.rows[self.subject], self._session.image
        everything = self._session.status.phase != "running"
        rows = [
            (row.key, row.found) for row in self.rows.values()
            if row.found is not None and row is not reference and (everything or row is subject)
        ]  # fmt: skip
        if image is None or reference.found is None or not (rows or reference.key):
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
    return ComparisonRow(CURRENT_KEY, file.name, found, scene, truth=truth)


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


def _objects_from_row(row: ComparisonRow, found: Result, image: Image) -> tuple[SegmentedObject, ...]:
    """Make objects of what a row has found."""
    if found.surface is not None:
        made = objects_from_surface(found.surface, image) if found.surface.closed else ()
    elif isinstance(row.truth, Truth):  # from labels, as touching objects each have a boundary of their own
        made = objects_from_contours(
            [
                Contour(points, True, group=number, hole=hole)
                for number, curves in mask.find_label_outlines(row.truth.objects)
                for points, hole in curves
            ]
        )
    else:
        made = objects_from_contours([contour for contour in found.contours if contour.closed])
    if not made:
        raise ValueError(tr("There is no closed contour, so there is no object to add."))
    return made
