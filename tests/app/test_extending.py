"""Where something new goes, as ARCHITECTURE.md says it: each is added here once, by what the page names and no more."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import ClassVar

import numpy as np
import pytest
from cpm_app.model.document import edits
from cpm_app.model.text.wording import PARAMETER_FORMULAS
from cpm_app.session.features.workspace import Workspace
from cpm_app.session.tasks import opening
from cpm_app.session.worker import prepared_methods
from cpm_app.views import layers as canvas_layers
from cpm_app.views.canvas import canvas_area
from cpm_app.views.features import edit
from cpm_app.views.items.curves import Curves
from cpm_app.views.layers.layer import Layer
from cpm_app.views.main_window import make_window
from cpm_app.views.tools import TOOLS, TOOLS_BY_GROUP
from cpm_app.views.tools.gesture_tools import DraggedTool
from cpm_app.views.window import bars
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import Qt
from skimage.measure import find_contours

from cpm_core.cli import main
from cpm_core.contours.contour import Contour
from cpm_core.formats import writers
from cpm_core.model.image_fields import ImageFields
from cpm_core.model.state import Particles
from cpm_core.parameters import PARAMETERS, Parameters
from cpm_core.results.result import Result
from cpm_core.segmentation.method import RUN_METHODS
from cpm_core.shapes import Circle

from .conftest import Hand
from .views.window.windows import close_window, close_workspace

SQUARE = np.array([[10.0, 10.0], [10.0, 20.0], [20.0, 20.0], [20.0, 10.0]])


def result_of(*contours: Contour) -> Result:
    return Result(np.zeros((0, 2)), contours, None, 1, True, "done", (32, 32), (1.0, 1.0), None, "test")


# A format: a function that makes the bytes, and a line in the table of writers.


def encode_wkt(result: Result) -> bytes:
    corners = [", ".join(f"{col:g} {row:g}" for row, col in contour.path) for contour in result.contours]
    return "\n".join(f"POLYGON (({points}))" for points in corners).encode()


def test_a_format_is_a_function_and_a_line_in_the_table_of_writers(monkeypatch, tmp_path) -> None:
    text = "well-known text"
    monkeypatch.setattr(writers, "FILE_FORMATS", (*writers.FILE_FORMATS, writers.Format(".wkt", encode_wkt, text)))
    # what follows from the table when the program is started
    monkeypatch.setattr(writers, "_FORMAT_SUFFIXES", tuple(one.suffix for one in writers.FILE_FORMATS))
    writers.export(result_of(Contour(SQUARE, True, 1.0)), tmp_path / "square.wkt")
    assert (tmp_path / "square.wkt").read_text() == "POLYGON ((10 10, 20 10, 20 20, 10 20, 10 10))"


# A layer: a class that draws a scene, and a place in the list of layers.


class CenterLayer(Layer):
    """Marks the center of the image."""

    name = "center"
    title = "Center"
    tip = "The center of the image."
    shortcut = "Ctrl+Alt+9"

    def create_items(self) -> None:
        self.cross = Curves("#ff0000", 9.0)
        self.add_items(self.cross)
        self.center = None

    def show_scene(self, before) -> None:
        if self.scene.image is not before.image and self.scene.image is not None:
            self.center = tuple((n - 1) / 2 for n in self.scene.image.shape)
            row, col = self.center
            self.cross.show_paths(
                [np.array([[row - 3, col], [row + 3, col]]), np.array([[row, col - 3], [row, col + 3]])]
            )


def another_window(qtbot, request, workspace: Workspace, image_file) -> MainWindow:
    """A window made after something new has been added."""
    window = make_window(workspace)
    request.addfinalizer(lambda: close_workspace(workspace))
    request.addfinalizer(lambda: close_window(window))
    window.resize(1000, 700)
    window.show()
    qtbot.waitExposed(window)
    window.session.set_pace(None)
    window.session.open_file(image_file)
    qtbot.waitUntil(lambda: window.session.image is not None, timeout=20_000)
    return window


@pytest.fixture
def hand_on(qtbot):
    """Function that gives a hand on a window."""
    return lambda window: Hand(qtbot, window)


@pytest.fixture
def opened(qtbot, request, compiled_loops, image_file):
    """Function that opens a window."""
    return lambda: another_window(qtbot, request, Workspace(), image_file)


def test_a_layer_is_a_class_and_a_place_in_the_list_of_layers(monkeypatch, opened) -> None:
    monkeypatch.setattr(canvas_layers, "LAYER_CLASSES", (*canvas_layers.LAYER_CLASSES, CenterLayer))
    window = opened()
    layer = window.canvas_area.canvas.layers["center"]
    assert layer.center == (31.5, 31.5)
    action = window.actions_by_name["layer_center"]
    assert (action.text(), action.isChecked()) == ("Center", True)
    action.trigger()
    assert not layer.shown


# A tool: what it does with the pointer, and an entry in the table of tools.


class DiameterTool(DraggedTool):
    """Draws the circle around a dragged diameter."""

    name = "bin"  # also the name of its icon
    menu_text = "&Diameter tool"
    shortcut = "N"
    tip = "Drag along a diameter."
    activity = "draw a circle by its diameter"

    def build_shape(self, begin, at) -> Circle:
        row, col = ((a + b) / 2 for a, b in zip(begin, at, strict=True))
        return Circle((row, col), math.dist(begin, at) / 2)


def test_a_tool_is_a_class_and_an_entry_in_the_table_of_tools(monkeypatch, opened, hand_on) -> None:
    monkeypatch.setattr(canvas_area, "TOOLS", (*TOOLS, DiameterTool))
    for module in (edit, bars):
        grouped = {**TOOLS_BY_GROUP, "Circle": (*TOOLS_BY_GROUP["Circle"], DiameterTool)}
        monkeypatch.setattr(module, "TOOLS_BY_GROUP", grouped)
    window = opened()
    hand = hand_on(window)
    hand.key(Qt.Key.Key_N)
    assert window.actions_by_name["bin"].isChecked()
    hand.drag((20.0, 32.0), (30.0, 32.0), (44.0, 32.0))
    (circle,) = window.session.document.shapes
    assert circle.center == pytest.approx((32.0, 32.0), abs=0.2)
    assert circle.radius == pytest.approx(12.0, abs=0.2)
    window.session.undo()
    assert window.session.document.shapes == ()


# A method: a class with the attributes of `Method`, and a place in `RUN_METHODS`.


@dataclass(frozen=True)
class HalfwayState:
    """A moment of a run that has one step."""

    step: int = 0
    steering: tuple[object, ...] = ()
    contours: tuple[Contour, ...] = ()
    stop_reason: str = ""
    scale: ClassVar[int] = 0
    count: ClassVar[int] = 0

    @property
    def converged(self) -> bool:
        return bool(self.contours)

    @property
    def position(self) -> np.ndarray:
        return np.zeros((0, 2))

    @property
    def particles(self) -> Particles:
        return Particles.at_rest(self.position)

    def list_arrays(self) -> list[np.ndarray]:
        return [contour.points for contour in self.contours]

    def resume(self) -> "HalfwayState":
        return replace(self, stop_reason="")


class Halfway(ImageFields):
    """Level lines halfway between the darkest and the brightest pixel."""

    name = "cpm"  # in its place: the mode Shape runs the method of this name
    title = "Halfway"
    parameters = ()
    seeded = False

    @staticmethod
    def steering(parameters: Parameters) -> tuple[object, ...]:
        return ()

    def can_start(self, parameters: Parameters) -> bool:
        return True

    def start(self, seeds) -> HalfwayState:
        return HalfwayState()

    def step(self, state: HalfwayState, parameters: Parameters, charges=()) -> HalfwayState:
        values = self.image.values
        lines = find_contours(values, (values.min() + values.max()) / 2)
        found = tuple(Contour(line[:-1], bool(np.all(line[0] == line[-1])), 1.0) for line in lines)
        return replace(state, step=1, contours=found, stop_reason="all level lines are found")

    def result(self, state: HalfwayState, parameters: Parameters) -> Result:
        return replace(result_of(*state.contours), shape=self.image.shape, stop_reason=state.stop_reason)

    def measure_state(self, state, parameters: Parameters) -> Mapping[str, float]:
        return {"lines": len(state.contours)}


def test_a_method_is_a_class_that_the_window_runs_without_knowing_it(monkeypatch, opened, hand_on) -> None:
    for module in (opening, prepared_methods):
        monkeypatch.setattr(module, "RUN_METHODS", {**RUN_METHODS, "cpm": Halfway})
    window = opened()
    window.session.edit("draw", lambda document: edits.add_shape(document, Circle((32.0, 32.0), 10.0)))
    hand = hand_on(window)
    hand.key(Qt.Key.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: window.session.idle)
    (contour,) = window.session.scene.contours
    assert contour.closed
    np.testing.assert_allclose(np.hypot(*(contour.points - 32.0).T), 18.0, atol=0.8)


# A parameter: a field and a row of the core, and words for the window; everything else follows.


@pytest.mark.parametrize("name", PARAMETERS)
def test_a_parameter_is_known_in_every_place_that_names_parameters(name, capsys) -> None:
    assert name in {field.name for field in fields(Parameters)}
    assert name in PARAMETER_FORMULAS or name == "w1"  # of which the window sets the ratio to w2
    with pytest.raises(SystemExit):
        main(["run", "--help", "all"])
    assert f"--{name.replace('_', '-')}" in capsys.readouterr().out
