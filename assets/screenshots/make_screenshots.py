"""Makes the pictures of the window that the documentation shows, from the real window on the samples.

    python assets/screenshots/make_screenshots.py [NAME ...]

All of them, or those named. Needs a display with room for a window of 1280 by 760, be it a virtual one;
``QT_QPA_PLATFORM=offscreen`` does as well. Your preferences are neither read nor changed.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from cpm_app.model.document import edits
from cpm_app.model.document.samples import find_sample_named
from cpm_app.session.features.comparison import TRUTH_KEY
from cpm_app.views.application import make_application
from cpm_app.views.features.volumes import SpaceFeature
from cpm_app.views.main_window import open_window
from cpm_app.views.theme import theme
from cpm_app.views.window.window import MainWindow
from PIL import Image as Picture
from PySide6.QtCore import QDeadlineTimer, QEventLoop, QSettings, QStandardPaths
from PySide6.QtWidgets import QWidget

from cpm_core.objects.segmented import Click
from cpm_core.shapes import Barrier, Charge
from tests.app.reading import treat_as_saved

HERE = Path(__file__).parent
WIDTH, HEIGHT = 1280, 760
PATIENCE = 120_000
"""Longest wait for anything [ms]."""


def wait(condition: Callable[[], bool]) -> None:
    """Let the window live until a condition holds."""
    application, deadline = make_application(), QDeadlineTimer(PATIENCE)
    while not condition():
        if deadline.hasExpired():
            raise TimeoutError("the window did not get there in two minutes")
        application.processEvents(QEventLoop.ProcessEventsFlag.WaitForMoreEvents, 20)


@dataclass(frozen=True)
class Stand:
    """A window that is made to look as it is to be shown.

    Attributes
    ----------
    window : MainWindow
        The window.
    """

    window: MainWindow

    def open(self, file: str) -> None:
        """Open a sample."""
        sample = find_sample_named(file)
        assert sample is not None
        session, before = self.window.session, self.window.session.store.image_generation
        self.window.open_image(str(sample.path))
        wait(lambda: session.store.image_generation != before)
        self.settle()

    def run(self) -> None:
        """Let the particles go until they rest."""
        session = self.window.session
        session.set_pace(None)
        session.run()
        wait(lambda: session.status.phase == "finished")
        self.settle()

    def step_to(self, step: int) -> None:
        """Take single steps up to this very one, however busy the machine is."""
        while self.window.session.status.step < step:
            self.do("step")
            self.settle()

    def do(self, *names: str) -> None:
        """Trigger actions."""
        for name in names:
            self.window.actions_by_name[name].trigger()

    def settle(self) -> None:
        """Wait until nothing is running."""
        session = self.window.session
        wait(lambda: session.idle and not session.status.busy)

    def take(self, name: str, widget: QWidget | None = None) -> None:
        """Take a picture of the window, or of a dialog."""
        self.window.canvas_area.messages.hide()
        end = QDeadlineTimer(2000)
        wait(end.hasExpired)
        (widget or self.window).grab().save(str(HERE / f"{name}.png"))


def rest(stand: Stand) -> None:
    """Show the whole U found, and proposed as the object."""
    selection = stand.window.workspace.object_selection
    stand.run()
    wait(lambda: selection.idle and bool(selection.proposals))
    stand.take("rest")


LARGE = ((167.0, 33.0), (264.0, 39.0), (284.0, 193.0), (76.0, 280.0))
"""Places in large nuclei."""


def objects(stand: Stand) -> None:
    """All nuclei found, accepted as objects of two classes, one of them selected."""
    workspace = stand.window.workspace
    selection, listed, commands = workspace.object_selection, workspace.object_list, workspace.object_commands
    stand.open("nuclei.png")
    stand.run()
    wait(lambda: selection.idle and bool(selection.proposals))
    stand.do("objects")
    commands.accept_pending()
    stand.settle()
    for category, name in ((1, "small"), (2, "large")):
        commands.name_class(category, name)
    listed.select_objects({listed.object_number_at(place) for place in LARGE})
    commands.classify_selected(2)
    listed.select_objects({listed.object_number_at(LARGE[0])})
    stand.window.docks.reveal_panel("objects")
    stand.settle()
    stand.do("fit")
    stand.take("objects")


def steering(stand: Stand) -> None:
    """Show a hand with a charge that attracts, one that repels, and a barrier, and the field that follows them."""
    session = stand.window.session
    stand.open("hand.png")
    stand.step_to(90)
    shapes = (Charge((120.0, 60.0), 3.0), Charge((330.0, 120.0), -3.0), Barrier(((210.0, 235.0), (235.0, 300.0))))
    for shape in shapes:
        session.edit("place", lambda document, shape=shape: edits.add_shape(document, shape))
    session.select_shape(len(session.document.shapes) - 3)
    stand.do("layer_field")
    stand.step_to(120)
    stand.take("steering")


def branches(stand: Stand) -> None:
    """Two ways on from step 40, compared."""
    session, navigation = stand.window.session, stand.window.workspace.navigation
    stand.run()
    navigation.go_to(navigation.timeline_state.branch, 40)
    stand.settle()
    session.edit("damping", lambda document: edits.set_parameter(document, "beta", 2.5))
    stand.step_to(90)
    compared = stand.window.workspace.comparison
    compared.select_row(navigation.timeline_state.branches[0].identity)
    wait(lambda: len(compared.agreements) == 1)
    stand.window.docks.reveal_panel("compare")
    stand.settle()
    stand.take("branches")


def trust(stand: Stand) -> None:
    """Nuclei compared with a truth, on both sides of the divider."""
    window, compared = stand.window, stand.window.workspace.comparison
    theme.apply_theme(theme.DARK_THEME, window)
    stand.open("nuclei.png")
    stand.run()
    sample = find_sample_named("nuclei.png")
    assert sample is not None
    values = np.asarray(Picture.open(sample.path), dtype=float)
    with tempfile.TemporaryDirectory() as folder:
        mask = Path(folder) / "nuclei_mask.png"
        Picture.fromarray((values > np.percentile(values, 88)).astype(np.uint8) * 255).save(mask)
        compared.load_truth_file(mask)
        stand.settle()
        wait(lambda: TRUTH_KEY in compared.rows)
    compared.select_row(TRUTH_KEY)
    window.docks.reveal_panel("compare")
    stand.settle()
    wait(lambda: bool(compared.agreements))
    stand.take("trust")


STRUCTURES = {
    "lesion": (29.0, 45.0, 31.0),
    "left ventricle": (29.0, 28.0, 55.0),
    "right ventricle": (29.0, 28.0, 40.0),
}
"""Places in what is clicked in the head."""


def head(stand: Stand) -> None:
    """Three structures of a head, accepted, named and measured."""
    workspace = stand.window.workspace
    selection, listed, commands = workspace.object_selection, workspace.object_list, workspace.object_commands
    stand.open("head.tif")
    stand.window.session.edit("clear", edits.clear_shapes)
    stand.do("objects")
    for category, (name, place) in enumerate(STRUCTURES.items(), start=1):
        selection.add_click(Click((place,)))
        wait(lambda: selection.idle and bool(selection.proposals))
        stand.settle()
        commands.accept_pending()
        stand.settle()
        listed.select_objects({listed.object_number_at(place)})
        commands.rename_row(("object", category), name)
        commands.classify_selected(category)
        stand.settle()
    wait(lambda: stand.window.get_feature(SpaceFeature).panel.view.is_idle)
    stand.take("head")


PICTURES: Mapping[str, Callable[[Stand], None]] = {
    "rest": rest,
    "objects": objects,
    "steering": steering,
    "branches": branches,
    "trust": trust,
    "head": head,
}


def each_in_a_window(names: Iterable[str], size: tuple[int, int]) -> Iterator[tuple[str, Stand]]:
    """Yield each name with a new window of this size, as it is at the very first start."""
    make_application()
    QStandardPaths.setTestModeEnabled(True)
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            QSettings.setPath(QSettings.Format.IniFormat, QSettings.Scope.UserScope, str(Path(folder) / name))
            window = open_window()
            window.resize(*size)
            theme.apply_theme(theme.LIGHT_THEME, window)
            stand = Stand(window)
            stand.settle()
            yield name, stand
            treat_as_saved(window)
            window.close()
            window.deleteLater()


def main(names: list[str]) -> None:
    """Take the pictures, each of a window of its own."""
    for name, stand in each_in_a_window(names or PICTURES, (WIDTH, HEIGHT)):
        PICTURES[name](stand)


if __name__ == "__main__":
    main(sys.argv[1:])
