"""Opening an image on a thread of its own, so that it can be given up at once and what is open stays usable."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from app.model import shades
from app.model.language import tr
from app.session.core import Core
from app.session.messages import NotOpened, Opened, Report
from app.session.tasks import Task, Tasks
from cpm_core.multiscale import most_scales
from cpm_core.parameters import Parameters


def prepare(core: Core, path: Path, parameters: Parameters, go_on: Callable[[], None]) -> Opened:
    """Read an image and build its engine, with as many scales as it has room for.

    Parameters
    ----------
    core : Core
        The core's functions.
    path : Path
        File of the image.
    parameters : Parameters
        What it is to be run with.
    go_on : callable
        Asked between the steps; raises when nobody wants the image any more.

    Raises
    ------
    ValueError
        When the image cannot be used.
    """
    image = core.load_image(path)
    go_on()
    notes = image.notes
    most = most_scales(image.shape)
    if parameters.scales > most:
        parameters = replace(parameters, scales=most)
        notes = (*notes, tr("The image is small: the scales are set to {most}.").format(most=most))
    engine = core.engine(image, parameters, None)
    go_on()
    return Opened(image, engine, shades.of_image(image.values), path, parameters, notes)


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
    def opening(self) -> bool:
        """Whether an image is being opened."""
        return self._task is not None and not self._task.over

    def open(self, path: Path, parameters: Parameters, otherwise: Path | None = None) -> Task:
        """Begin to open an image."""
        if self._task is not None:
            self._task.cancel()

        def work(task: Task) -> Report:
            return prepare(self._core, path, parameters, task.go_on)

        self._task = self._tasks.start(
            tr("Opening {name}…").format(name=path.name),
            work,
            f"opening {path.name}",
            lambda sentence: NotOpened(sentence, otherwise),
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
