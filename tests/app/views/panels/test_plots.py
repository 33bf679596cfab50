"""The plots show the recorded metrics of a run at every step."""

from __future__ import annotations

import numpy as np
import pytest
from cpm_app.model.display.plots import PLOTS, RunMetrics
from cpm_app.session.timeline.timeline_nodes import BranchMetrics
from cpm_app.views.panels.run import Chart

from cpm_core import Engine, Parameters
from tests.app.conftest import disc

pytestmark = pytest.mark.shared_window


def trace_of(length: int) -> RunMetrics:
    """Metrics of a number of steps over three scales."""
    step = np.arange(1.0, length + 1)
    return RunMetrics(step, 1.0 / step, 10 * step, step % 3, step % 2, 1.0 / step**2, 2.0 - step // (length / 3), step)


@pytest.fixture
def panel(qtbot):
    made = Chart(PLOTS, "")
    qtbot.addWidget(made)
    made.resize(330, 460)
    made.show()
    qtbot.waitExposed(made)
    return made


def test_the_metrics_are_those_of_the_recorded_states(compiled_loops):
    parameters = Parameters()
    engine, recorder = Engine(disc(), parameters), BranchMetrics()
    state = engine.start([(32.0, 20.0), (32.0, 44.0), (20.0, 32.0)])
    states = []
    for _ in range(20):
        state = engine.step(state, parameters)
        recorder.add_step(state.step, engine.measure_state(state, parameters))
        states.append(state)
    metrics = recorder.metrics_until()
    for name in ("step", "count", "born", "deleted", "scale"):
        assert getattr(metrics, name).tolist() == [getattr(state, name) for state in states]
    assert metrics.kinetic == pytest.approx([engine.energies(state, parameters).kinetic for state in states])


def test_that_the_plots_are_unfolded_is_remembered(ready):
    ready.panels["run"].plots.fold.click()
    assert ready.panels["run"].plot.isVisible()
    assert ready.preferences.read_key("run/unfolded", [""]) == ["plots"]


def test_each_curve_and_each_change_of_scale_is_drawn(panel):
    metrics, constant = trace_of(60), np.ones(60)
    panel.show_metrics(metrics)
    pictures = [panel.grab().toImage()]
    for changed in ("epsilon", "count", "born", "deleted", "kinetic", "scale"):
        panel.show_metrics(RunMetrics(*[constant if name == changed else column for name, column in columns(metrics)]))
        pictures.append(panel.grab().toImage())
    assert all(one != other for i, one in enumerate(pictures) for other in pictures[:i])


def columns(metrics: RunMetrics) -> list[tuple[str, np.ndarray]]:
    """Names and columns of metrics."""
    return [(name, getattr(metrics, name)) for name in RunMetrics.__dataclass_fields__]
