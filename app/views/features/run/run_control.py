"""Running, pausing, stepping, and the panel of the run."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QTimer

from app.model.preferences.table import UNIT
from app.model.state.resolve import resolve
from app.model.state.situation import can_step, has_image, is_running, is_started
from app.model.text.language import tr
from app.model.text.numbers import written
from app.session.worker.commands import RunCall
from app.session.worker.run import Run
from app.views.panels.run.run_panel import RunPanel
from app.views.widgets.action_spec import ActionSpec
from app.views.widgets.speed import SpeedControl
from app.views.window.feature import Feature, FeatureContext, Panel

_UPDATE_EVERY = 250
"""Time between two updates of the panel during the run [ms]."""

_PLOTS, _UNFOLDED = "run/plots", "run/unfolded"
"""Preferences: which plots are shown, and which sections are unfolded."""


class RunControlFeature(Feature):
    """Control and state of the run."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.speed = SpeedControl(context.session)
        self.panel = RunPanel()
        self._watched = False
        chosen = context.preferences.get(_PLOTS, list(self.panel.plot.shown))
        self.panel.plot.show_plots(chosen)
        self.panel.unfold(context.preferences.get(_UNFOLDED, []))
        for changed in (self.panel.plot.chosen, self.panel.folded):
            changed.connect(self._choose_plots)
        self._choose_plots()
        self._timer = QTimer(self.panel)
        self._timer.setInterval(_UPDATE_EVERY)
        self._timer.timeout.connect(self._show_values)
        context.session.status_changed.connect(self._show)
        context.preferences.follow(UNIT, self._show)

    def action_specs(self) -> Sequence[ActionSpec]:
        """Run, step, reset, speed."""
        session = self.context.session
        return (
            ActionSpec(name="run", menu="Run", text=tr("Run"), do=session.toggle, shortcuts=("Space",),
                       tip=tr("Start or pause the run."), icon="run", when=has_image,
                       worded=lambda situation: resolve(situation).run_text,
                       pictured=lambda situation: "pause" if is_running(situation) else "run"),
            ActionSpec(name="step", menu="Run", text=tr("&Step"), short=tr("Step"), do=session.step, shortcuts=(".",),
                       tip=tr("Take a single step."), icon="step", when=can_step),
            ActionSpec(name="reset", menu="Run", text=tr("&Reset"), short=tr("Reset"), do=session.reset,
                       shortcuts=("R",), icon="reset",
                       tip=tr("Go back to the start; the run stays on the timeline."), when=is_started),
            ActionSpec(name="faster", menu="Run", text=tr("&Faster"), do=self.speed.faster, shortcuts=("]",),
                       tip=tr("Allow more steps per second."), gap=True),
            ActionSpec(name="slower", menu="Run", text=tr("S&lower"), do=self.speed.slower, shortcuts=("[",),
                       tip=tr("Allow fewer steps per second.")),
        )  # fmt: skip

    def panels(self) -> Sequence[Panel]:
        """The panel of the run."""
        return (Panel(name="run", title=tr("Run"), widget=self.panel, fitted=True, shortcut="F5"),)

    def close(self) -> bool:
        """Stop the updates."""
        self._timer.stop()
        return True

    def _choose_plots(self) -> None:
        shown, unfolded = self.panel.plot.shown, self.panel.unfolded
        self.context.preferences.put(_PLOTS, list(shown))
        self.context.preferences.put(_UNFOLDED, unfolded)
        watched = "potential" in shown and "plots" in unfolded
        if watched != self._watched:
            self._watched = watched
            self.context.session.post(RunCall(None, Run.watch_energy, watched))

    def _show(self) -> None:
        running = is_running(self.context.session.situation)
        if running != self._timer.isActive():
            (self._timer.start if running else self._timer.stop)()
        if not running:
            self._show_values()

    def _show_values(self) -> None:
        session = self.context.session
        resolved, snapshot = session.resolved, session.scene.snapshot
        frames = written(f"{session.frames_per_second:.0f}") if resolved.running else "–"
        self.panel.status.show_resolved(resolved, frames)
        self.panel.show_particles(resolved.particles)
        self.panel.show_metrics(snapshot.metrics if snapshot else None)
