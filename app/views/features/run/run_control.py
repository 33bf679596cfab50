"""Running, pausing, stepping; and how the run stands."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QTimer

from app.model.state.resolve import resolve
from app.model.state.situation import can_step, has_image, is_running, is_started
from app.model.text.language import tr
from app.session.worker.commands.run import RunCall
from app.session.worker.run import Run
from app.views.panels.run.run_panel import RunPanel
from app.views.widgets.action_spec import ActionSpec
from app.views.widgets.speed import SpeedControl
from app.views.window.feature import Feature, FeatureContext, Panel

_FIGURES_EVERY = 250
"""Time between two looks at the frame counter [ms]."""


_PLOTS = "run/plots"
"""Preference that keeps which plots are shown."""


class RunControlFeature(Feature):
    """What drives a run and tells of it."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.speed = SpeedControl(context.session)
        self.panel = RunPanel()
        self._watched = False
        chosen = context.preferences.get(_PLOTS, list(self.panel.plot.shown))
        self.panel.plot.show_plots(chosen)
        self.panel.plot.chosen.connect(self._choose_plots)
        self._choose_plots()
        self._figures = QTimer(self.panel)
        self._figures.setInterval(_FIGURES_EVERY)
        self._figures.timeout.connect(self._show_figures)
        context.session.status_changed.connect(self._show)

    def action_specs(self) -> Sequence[ActionSpec]:
        """Run, step, reset, speed."""
        return (*self._run(), *self._speeds())

    def _run(self) -> Sequence[ActionSpec]:
        session = self.context.session
        return (
            ActionSpec(
                name="run",
                menu="Run",
                text=tr("Run"),
                do=self.context.session.toggle,
                shortcuts=("Space",),
                tip=tr("Let the particles move, or hold them."),
                icon="run",
                when=has_image,
                worded=lambda situation: resolve(situation).run_text,
                pictured=lambda situation: "pause" if is_running(situation) else "run",
            ),
            ActionSpec(
                name="step",
                menu="Run",
                text=tr("&Step"),
                short=tr("Step"),
                do=session.step,
                shortcuts=(".",),
                tip=tr("Take a single step."),
                icon="step",
                when=can_step,
            ),
            ActionSpec(
                name="reset",
                menu="Run",
                text=tr("&Reset"),
                short=tr("Reset"),
                do=session.reset,
                shortcuts=("R",),
                tip=tr("Forget the particles and go back to the drawing."),
                icon="reset",
                when=is_started,
            ),
        )

    def _speeds(self) -> Sequence[ActionSpec]:
        return (
            ActionSpec(
                name="faster",
                menu="Run",
                text=tr("&Faster"),
                do=self.speed.faster,
                shortcuts=("]",),
                tip=tr("Allow more steps a second."),
                gap=True,
            ),
            ActionSpec(
                name="slower",
                menu="Run",
                text=tr("S&lower"),
                do=self.speed.slower,
                shortcuts=("[",),
                tip=tr("Allow fewer steps a second."),
            ),
        )

    def panels(self) -> Sequence[Panel]:
        """How the run stands."""
        return (Panel(name="run", title=tr("Run"), widget=self.panel, shortcut="F6"),)

    def close(self) -> bool:
        """Look no more."""
        self._figures.stop()
        return True

    def _choose_plots(self) -> None:
        shown = self.panel.plot.shown
        self.context.preferences.put(_PLOTS, list(shown))
        watched = "potential" in shown
        if watched != self._watched:
            self._watched = watched
            self.context.session.post(RunCall(None, Run.watch_energy, watched))

    def _show(self) -> None:
        running = is_running(self.context.session.situation)
        if running != self._figures.isActive():
            (self._figures.start if running else self._figures.stop)()
        if not running:
            self._show_figures()

    def _show_figures(self) -> None:
        session = self.context.session
        resolved, snapshot = session.resolved, session.scene.snapshot
        frames = f"{session.frames_per_second:.0f}" if resolved.running else "–"
        self.panel.status.show_resolved(resolved, frames)
        self.panel.plot.show_metrics(snapshot.metrics if snapshot else None)
