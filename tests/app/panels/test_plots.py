"""The plots show the recorded metrics of a run at every step."""

from __future__ import annotations

import re

import numpy as np
import pytest
from PySide6.QtCore import Qt

from app.model.display.lengths import short_text
from app.model.display.plots import PLOTS, RunMetrics, figure
from app.session.timeline.moments import RunRecord
from app.views.panels.run import PlotPanel
from cpm_core import Engine, Parameters
from tests.app.conftest import disc

pytestmark = pytest.mark.shared_window


def trace_of(length: int) -> RunMetrics:
    """Metrics of a number of steps over three scales."""
    step = np.arange(1.0, length + 1)
    return RunMetrics(
        step, 1.0 / step, 10 * step, step % 3, step % 2, 1.0 / step**2, -step, 2.0 - step // (length / 3), step
    )


@pytest.fixture
def panel(qtbot):
    made = PlotPanel()
    qtbot.addWidget(made)
    made.resize(330, 460)
    made.show()
    qtbot.waitExposed(made)
    return made


def test_the_metrics_are_those_of_the_recorded_states(compiled_loops):
    parameters = Parameters()
    engine, recorder = Engine(disc(), parameters), RunRecord()
    state = engine.start([(32.0, 20.0), (32.0, 44.0), (20.0, 32.0)])
    states = []
    for _ in range(20):
        state = engine.step(state, parameters)
        recorder.record(state.step, engine.measures(state, parameters, thorough=state.step % 4 == 0))
        states.append(state)
    metrics = recorder.metrics()
    for name in ("step", "count", "born", "deleted", "scale"):
        assert getattr(metrics, name).tolist() == [getattr(state, name) for state in states]
    expected = [engine.energies(state, parameters) for state in states]
    assert metrics.kinetic == pytest.approx([energies.kinetic for energies in expected])
    assert np.isnan(metrics.potential[:3]).all()
    assert metrics.potential[3:] == pytest.approx(
        [expected[i - i % 4 + 3 - 4 * (i % 4 != 3)].potential for i in range(3, 20)]
    )


def test_pointer_and_keys_read_the_values_of_a_step(panel, qtbot):
    chart, metrics = panel.chart, trace_of(61)
    panel.show_plots([plot.name for plot in PLOTS])
    panel.chart.show_metrics(metrics)
    qtbot.waitUntil(lambda: 0 < chart.point(30).x() < chart.width())
    qtbot.mouseMove(chart.viewport(), chart.point(30).toPoint())
    qtbot.waitUntil(lambda: chart.reading != "")
    assert chart.reading == (
        f"step 31, ε {figure(1 / 31)}, kinetic energy {figure(1 / 31**2)}, potential energy -31, "
        "particles 310, inserted 1, deleted 1"
    )
    chart.setFocus()
    for key, step in ((Qt.Key.Key_Right, 32), (Qt.Key.Key_End, 61), (Qt.Key.Key_Left, 60), (Qt.Key.Key_Home, 1)):
        qtbot.keyClick(chart, key)
        assert chart.reading.startswith(f"step {step},")
    qtbot.keyClick(chart, Qt.Key.Key_Escape)
    assert chart.reading == ""


def test_going_back_in_a_run_clears_a_reading_beyond_its_end(panel):
    panel.chart.show_metrics(trace_of(60))
    panel.chart.read(50)
    panel.chart.show_metrics(trace_of(10))
    assert panel.chart.reading == ""
    panel.chart.show_metrics(None)
    panel.grab()


def test_plots_are_chosen_by_keys_and_remembered(ready, hand, qtbot):
    window, plot = ready, ready.panels["run"].plot
    assert plot.shown == ("epsilon", "count")
    window.panels["run"].plots.fold.click()
    button = plot.buttons["potential"]
    button.setFocus()
    hand.key(Qt.Key.Key_Return)
    assert plot.shown == ("epsilon", "potential", "count")
    assert window.preferences.get("run/plots", [""]) == ["epsilon", "potential", "count"]
    for step in range(1, 9):
        window.session.step()
        hand.wait(lambda step=step: window.session.status.step == step and window.session.idle)
    plot.chart.read(7)
    assert re.search(r"potential energy -?\d", plot.chart.reading)
    hand.key(Qt.Key.Key_Return)
    assert plot.shown == ("epsilon", "count")
    assert "potential energy" not in plot.chart.reading


def test_each_curve_and_each_change_of_scale_is_drawn(panel):
    pictures = []
    for names in ([], *([plot.name] for plot in PLOTS)):
        panel.show_plots(names)
        panel.chart.show_metrics(trace_of(60))
        pictures.append(panel.chart.grab().toImage())
    assert all(one != other for i, one in enumerate(pictures) for other in pictures[:i])
    panel.show_plots(["count"])
    metrics = trace_of(60)
    with_scales = panel.chart.grab().toImage()
    panel.chart.show_metrics(
        RunMetrics(*[column if name != "scale" else 0 * column for name, column in columns(metrics)])
    )
    assert panel.chart.grab().toImage() != with_scales


def columns(metrics: RunMetrics) -> list[tuple[str, np.ndarray]]:
    """Names and columns of metrics."""
    return [(name, getattr(metrics, name)) for name in RunMetrics.__dataclass_fields__]


def test_no_number_is_written_with_an_e():
    assert [figure(value) for value in (3.14e-7, 2.0, 7e8)] == ["3.1·10⁻⁷", "2", "7.0·10⁸"]
    assert [short_text(value) for value in (12345.0, 0.857143, 1e-4, 0.0)] == ["12300", "0.857", "0.0001", "0"]
