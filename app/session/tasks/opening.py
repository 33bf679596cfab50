"""Opening an image or a session on a thread of its own: it is given up at once, and what is open stays usable."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from app.model.display.display_image import display_of_image
from app.model.text.language import tr
from app.session.core_functions import Core
from app.session.exchange.messages import NotOpened, Opened, Report, Saved
from app.session.tasks.tasks import Task, Tasks
from cpm_core.formats.sessions.session_file import SUFFIX, find_image, fingerprint, load_session
from cpm_core.image.pyramid import most_scales
from cpm_core.parameters import Parameters


@dataclass(frozen=True, slots=True)
class Wanted:
    """What is to be opened.

    Attributes
    ----------
    path : Path
        File of an image, or of a session that names one.
    parameters : Parameters
        What an image is to be run with; a session has its own.
    otherwise : Path or None
        File to open when that one turns out to be unusable.
    saved : Saved or None
        What a session holds where that is known already; then `path` tells only where it lies.
    notes : tuple of str
        What is to be told once it is open.
    """

    path: Path
    parameters: Parameters
    otherwise: Path | None = None
    saved: Saved | None = None
    notes: tuple[str, ...] = ()


def is_session(path: Path) -> bool:
    """Whether a file is a session rather than an image, by its name."""
    return path.suffix.lower() == SUFFIX


def prepare(core: Core, wanted: Wanted, go_on: Callable[[], None]) -> Opened:
    """Read an image and prepare the charged particles for it, with as many scales as it has room for.

    Parameters
    ----------
    core : Core
        The core's functions.
    wanted : Wanted
        The image, or the session that names it.
    go_on : callable
        Asked between the steps; raises when nobody wants the image any more.

    Raises
    ------
    ValueError
        When the image cannot be used, or the session cannot.
    """
    path, parameters, saved, notes = wanted.path, wanted.parameters, wanted.saved, wanted.notes
    if saved is None and is_session(path):
        saved = Saved(path, load_session(path))
    if saved is not None:
        parameters, notes = saved.file.parameters, (*notes, *saved.file.notes)
        if saved.file.image is None:
            raise ValueError(tr("{name} names no image.").format(name=path.name))
        path, warnings = find_image(saved.file.image, path.absolute().parent)
        notes = (*notes, *warnings)
    image = core.load_image(path)
    go_on()
    sha256 = fingerprint(path)
    go_on()
    most = most_scales(image.shape)
    if parameters.scales > most:
        parameters = replace(parameters, scales=most)
        notes = (*notes, tr("The image is small: the scales are set to {most}.").format(most=most))
    method = core.methods["cpm"](image, parameters, None)
    go_on()
    told, shown = (*image.notes, *notes), display_of_image(image.values)
    return Opened(image, method, shown, path, parameters, told, sha256, saved)


class Opener:
    """Opens one image at a time; a later one takes the place of an earlier that is not ready yet.

    Parameters
    ----------
    core : Core
        The core's functions.
    tasks : Tasks
        Where it is done.
    """

    def __init__(self, core: Core, tasks: Tasks) -> None:
        self._core = core
        self._tasks = tasks
        self._task: Task | None = None
        self._afterwards: list[Callable[[], None]] = []
        tasks.changed.connect(self._go_on)

    @property
    def opening(self) -> str:
        """What is being opened, as it is told to people; empty when nothing is."""
        return self._task.name if self._task is not None and not self._task.over else ""

    def open(self, wanted: Wanted) -> Task:
        """Begin to open an image or a session."""
        if self._task is not None:
            self._task.cancel()
        name = wanted.path.name

        def work(task: Task) -> Report:
            return prepare(self._core, wanted, task.go_on)

        self._task = self._tasks.start(
            tr("Opening {name}…").format(name=name),
            work,
            f"opening {name}",
            lambda sentence: NotOpened(sentence, wanted.otherwise),
        )
        return self._task

    def afterwards(self, do: Callable[[], None]) -> None:
        """Do something as soon as no image is being opened."""
        self._afterwards.append(do)
        self._go_on()

    def _go_on(self) -> None:
        if not self.opening:
            waiting, self._afterwards = self._afterwards, []
            for do in waiting:
                do()
