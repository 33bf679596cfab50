"""The session: an image with its document and its run, opened and exported."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from PySide6.QtCore import QObject

from app.model.document import edits
from app.model.document.document import Document, ImageReference, Mode
from app.model.document.modes import fresh_parameters, starting
from app.model.document.samples import sample_at
from app.model.document.saving import restored
from app.model.export.order import ExportOrder
from app.model.state.situation import RunStatus
from app.model.text.language import from_core, tr
from app.model.volume.slices import Slices
from app.session.core_functions import Core
from app.session.exchange.messages import ImageReady, NotOpened, Opened
from app.session.run_control import RunControl
from app.session.scene import Scene
from app.session.signals import EXPORTING, OPENING
from app.session.tasks.opening import Opener, Wanted
from app.session.worker.commands.run import Copy, Export, RunCall, WarmUp
from app.session.worker.commands.stored_runs import RestoreRuns, RunsRestored
from app.session.worker.run import Run
from cpm_core.formats.fingerprint import differ
from cpm_core.formats.images import resolution
from cpm_core.formats.images.reading import DEFAULT, Reading
from cpm_core.parameters import Parameters
from cpm_core.shapes import Sphere

_PREPARING = tr("Preparing (longer the very first time)…")


class Session(RunControl):
    """Document, history and run, and the files that they are read from and written to."""

    def __init__(self, core: Core | None = None, parent: QObject | None = None) -> None:
        core = core or Core()
        super().__init__(core, parent)
        self._opener = Opener(core, self.tasks)
        self._asked_scales = self._used_scales = self.document.parameters.scales
        self.keeps_parameters = False
        """Whether the next image begins with the parameters of the one before it."""
        self.former_parameters: Parameters | None = None
        """Parameters of the image that was open before this one."""
        self.may_replace: Callable[[Opened], bool] = lambda opened: True
        """Whether an image may replace what is open at once; where not, `use` opens it later."""
        self.listen(ImageReady, lambda ready: self.use(ready.opened) if self.may_replace(ready.opened) else None)
        self.listen(Opened, self._accept)
        self.listen(RunsRestored, self._take_runs)
        self.listen(NotOpened, self._keep_or_open_otherwise)

    @property
    def status(self) -> RunStatus:
        """State of the run."""
        status = super().status
        return replace(status, busy=self._opener.opening) if status.phase == "empty" and self.opening else status

    @property
    def opening(self) -> str:
        """What is being opened, in words; empty when nothing is. The image that is open stays in use meanwhile."""
        return self._opener.opening

    @property
    def wanted_parameters(self) -> Parameters:
        """The parameters as another image would take them over: with all scales, if this one has no room for them.

        Those of a volume suit no image.
        """
        parameters = self.document.parameters
        if self.scene.slices is not None:
            return self.former_parameters or fresh_parameters("shape")
        clamped = parameters.scales == self._used_scales
        return replace(parameters, scales=self._asked_scales) if clamped else parameters

    def open(
        self,
        path: str | Path,
        otherwise: Path | None = None,
        resumes: bool = False,
        as_volume: bool | None = None,
        reading: Reading = DEFAULT,
    ) -> None:
        """Open an image or a session file, and `otherwise` when that file cannot be used.

        What is open stays until the new image is known to be usable. An image that `resumes` is opened with the session
        beside it. A stack is opened `as_volume`, or one plane of it; None leaves that to its kind. `reading` says which
        part of the file is wanted.
        """
        path = Path(path)
        sample = sample_at(path)
        kept = self.wanted_parameters if self.keeps_parameters else fresh_parameters(self.document.mode)
        parameters = sample.parameters if sample else kept
        self.begin(Wanted(path, parameters, otherwise, resumes=resumes, as_volume=as_volume, reading=reading))

    def begin(self, wanted: Wanted) -> None:
        """Open an image or a session; see `open`."""
        self.attempt(OPENING)
        self._opener.open(wanted)

    def use(self, opened: Opened) -> None:
        """Replace what is open."""
        self._worker_thread.report(opened)
        self._wake()

    def use_former_parameters(self) -> None:
        """Use the parameters of the image that was open before."""
        former = self.former_parameters
        if former is not None:
            self.edit(tr("parameters of the last image"), lambda document: edits.set_parameters(document, former))

    def export(self, path: str | Path, order: ExportOrder | None = None) -> None:
        """Write the contours that are shown, by default all but the rejected ones; the suffix gives the format."""
        path = Path(path)
        self.attempt(EXPORTING)
        task = self.tasks.begin(tr("Writing {name}…").format(name=path.name))
        scene, document = self.scene, self.document
        self.post(Export(task, scene.reconstruction, document.marks, path, order or ExportOrder(), document))

    def copy_contours(self, suffix: str) -> None:
        """Prepare the contours that are shown for the clipboard, as a file with this suffix would hold them."""
        self.attempt(EXPORTING)
        task = self.tasks.begin(tr("Copying contours…"))
        self.post(Copy(task, self.scene.reconstruction, self.document.marks, suffix))

    def warm_up(self) -> None:
        """Compile or load the kernels ahead of the first step."""
        self._progress.busy("preparing", _PREPARING)
        self._opener.afterwards(lambda: self.post(WarmUp()))

    def _accept(self, opened: Opened) -> None:
        """Use an image that has been opened."""
        if self.document.image is not None:
            self.former_parameters = self.wanted_parameters
        self._asked_scales, self._used_scales = opened.scales, opened.parameters.scales
        self._generation = self._image_generation = self._next_generation()
        self.post(RunCall(None, Run.use, self._generation, opened.method, opened.parameters))
        # With its own document from the first moment: the shapes of the former one may have another number of axes.
        before, document = self.document, _document(opened, self.document.mode)
        self.show(Scene(opened.image, opened.display, document=document, slices=Slices.of(opened.image.shape)))
        self.image_changed.emit()
        self._progress.forget()
        self.live.forget()
        self.begin_document(document, before)
        self._show_start()
        self.post(RunCall(None, Run.edit_by_hand, self.document.hand_edits))
        self.post(RunCall(None, Run.set_parameters, opened.parameters))
        if opened.image.ndim == 3:
            self._progress.busy("preparing", _PREPARING)
            self.post(WarmUp(volumes=True))
        self._restore_runs(opened)
        if opened.notes:
            self.say(" ".join(map(from_core, opened.notes)))

    def _follow(self, before: Document, after: Document, complete: bool) -> None:
        """Give the image the size of a pixel that has been set by hand, before all that follows from an edit."""
        image, wanted = self.scene.image, after.image
        if image is not None and wanted is not None and (image.spacing, image.unit) != (wanted.spacing, wanted.unit):
            factor = resolution.factor(image.unit, wanted.unit) if image.unit and wanted.unit else 1.0
            sized = image.sized(wanted.spacing, wanted.unit, factor)
            self._scene = replace(self.scene, image=sized)
            self.post(RunCall(None, Run.rescale, sized, after))
        super()._follow(before, after, complete)

    def _show_start(self) -> None:
        """Show the slices through what is drawn first in a volume."""
        slices = self.scene.slices
        first = next((shape for shape in self.document.shapes if isinstance(shape, Sphere)), None)
        if slices is not None and first is not None:
            self.show(replace(self.scene, slices=slices.through(first.center)))

    def _restore_runs(self, opened: Opened) -> None:
        """Bring back the runs of a session if its image is still the same."""
        image = self.document.image
        if opened.saved is None or not opened.saved.file.runs or image is None:
            return
        known = opened.saved.file.image
        if known is not None and known.sha256 and differ(known.sha256, opened.sha256):
            return  # the notes tell that the image has changed
        self._progress.busy("restoring", tr("Bringing back the runs…"))
        self.post(RunCall(None, Run.place, self._image_generation, self.document.charges))
        self.post(RunCall(None, Run.limit, self.document.regions))
        self.post(RestoreRuns(self._image_generation, opened.saved.file.runs, image))

    def _take_runs(self, restored: RunsRestored) -> None:
        if restored.generation == self._image_generation:
            self.live.restore(restored.begun)

    def _keep_or_open_otherwise(self, refused: NotOpened) -> None:
        """Keep what is open, unless there is another file to open."""
        if refused.otherwise is not None:
            self.open(refused.otherwise)
        self.say(refused.sentence, True, OPENING)


def _document(opened: Opened, mode: Mode) -> Document:
    """The document that an image or a session begins with; the mode stays unless it is a sample or a session."""
    image, path, sample = opened.image, opened.path, sample_at(opened.path)
    if image.ndim == 3 and opened.saved is None and sample is None:
        mode = "shape"  # starts everywhere take long in a volume, and skeletons there are none
    reference = ImageReference.of(path, image, opened.reading)
    if opened.saved is not None:
        return restored(opened.saved.file, reference, opened.parameters)
    if sample is not None:
        return Document(reference, sample.shapes, opened.parameters, mode=sample.mode)
    return Document(reference, starting(mode, ()), opened.parameters, mode=mode)
