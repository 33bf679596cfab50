"""Menu Run: run and pause, timeline, tasks and parameters."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import Qt, QTimer
from PySide6.QtGui import QKeyEvent

from cpm_app.model.document.modes import needs_start
from cpm_app.model.preferences.table import TIMELINE_MEMORY, UNIT
from cpm_app.model.state.resolve import resolve
from cpm_app.model.state.situation import Situation, can_step, has_image, has_particles, is_running, is_started
from cpm_app.model.text.language import tr, written
from cpm_app.session.storage.presets import PresetStore
from cpm_app.session.timeline.timeline import MEGABYTE
from cpm_app.session.worker.commands import run_call
from cpm_app.session.worker.run import Run
from cpm_app.views.panels.parameters import ParametersPanel
from cpm_app.views.panels.presets import Presets
from cpm_app.views.panels.run import RunPanel
from cpm_app.views.panels.timeline import TimelinePanel
from cpm_app.views.widgets.actions import ActionSpec
from cpm_app.views.window.bars import TaskBar
from cpm_app.views.window.docks import Panel
from cpm_app.views.window.keyboard import Keys
from cpm_app.views.window.window import Feature

_UPDATE_EVERY = 250
"""Time between two updates of the panel during the run [ms]."""

_UNFOLDED = "run/unfolded"
"""Preference: which sections are unfolded."""


class RunControlFeature(Feature):
    """Control and state of the run."""

    def set_up(self) -> None:
        """Make its actions, and follow what they depend on."""
        window = self.window
        session, speed = window.session, window.speed
        self.presets = Presets(window, PresetStore(parent=window))
        parameters = ParametersPanel(session, self.presets)
        self.panel = RunPanel(parameters)
        self.panels = (Panel("run", "Run", self.panel, "F5"),)
        self.panel.unfold(window.preferences.get(_UNFOLDED, []))
        self.panel.folded.connect(self._keep_unfolded)
        self._keep_unfolded()
        self._timer = QTimer(self.panel, interval=_UPDATE_EVERY)
        self._timer.timeout.connect(self._show_values)
        session.status_changed.connect(self._show)
        window.preferences.follow(UNIT, self._show)
        self.actions = (
            ActionSpec("run", "Run", "Run", "Start or pause the run.", session.toggle, "Space", icon="run",
                       when=has_image, worded=lambda situation: resolve(situation).run_text,
                       pictured=lambda situation: "pause" if is_running(situation) else "run"),
            ActionSpec("step", "Run", "&Step", "Take a single step.", session.step, ".", short=tr("Step"), icon="step",
                       when=can_step),
            ActionSpec("reset", "Run", "&Reset", "Go back to the start; the run stays on the timeline.",
                       session.reset, "R", short=tr("Reset"), icon="reset", when=is_started),
            ActionSpec("faster", "Run", "&Faster", "Allow more steps per second.", speed.faster, "Ctrl+]", gap=True),
            ActionSpec("slower", "Run", "S&lower", "Allow fewer steps per second.", speed.slower, "Ctrl+["),
        )  # fmt: skip

    def close(self) -> bool:
        """Stop the updates."""
        self._timer.stop()
        return True

    def _keep_unfolded(self) -> None:
        self.window.preferences.put(_UNFOLDED, self.panel.unfolded)

    def _show(self) -> None:
        running = is_running(self.session.situation)
        if running != self._timer.isActive():
            (self._timer.start if running else self._timer.stop)()
        if not running:
            self._show_values()

    def _show_values(self) -> None:
        session = self.session
        resolved, snapshot = session.resolved, session.scene.snapshot
        frames = written(f"{session.frames_per_second:.0f}") if is_running(session.situation) else "–"
        self.panel.status.show_resolved(resolved, frames)
        self.panel.plots.setVisible(needs_start(session.document.mode))  # where there are particles that move
        self.panel.show_metrics(snapshot.metrics if snapshot else None)


_MENU = ">" + tr("Timeline")


class TimelineFeature(Feature):
    """Navigation through the recorded run and its branches."""

    def set_up(self) -> None:
        """Make its actions, and follow what they depend on."""
        window = self.window
        self.navigation = to = window.workspace.navigation
        self.panel = TimelinePanel(to, lambda: self.session.status)
        self.panels = (Panel("timeline", "Timeline", self.panel, "F9", below=True),)
        self.session.status_changed.connect(lambda: self.panel.setVisible(self.session.status.started))

        def go_to_end(event: QKeyEvent) -> bool:
            """Home and End on the canvas; in sliders and fields they keep their meaning."""
            ends = {Qt.Key.Key_Home: to.to_first, Qt.Key.Key_End: to.to_last}
            if event.key() in ends:
                ends[Qt.Key(event.key())]()
            return event.key() in ends

        Keys(self.canvas, go_to_end)
        self.session.document_changed.connect(lambda _: self.panel.show_parameters())
        window.shortcuts.changed.connect(lambda: self.panel.use_actions(window.actions_by_name))
        self._shown = False
        to.changed.connect(self._follow)
        window.preferences.follow(TIMELINE_MEMORY, self.use_memory)

        def recorded(_: Situation) -> bool:
            return bool(to.branches)

        self.actions = (
            ActionSpec("timeline_back", _MENU, "One step &back",
                       "Go to the previous step; the steps after it are kept.", partial(to.by, -1), ",", "back",
                       when=recorded),
            ActionSpec("timeline_forward", _MENU, "One step &forward", "Go to the next recorded step.",
                       partial(to.by, 1), icon="forward", when=recorded),
            ActionSpec("timeline_back_ten", _MENU, "Ten steps b&ack", "Go ten steps back.", partial(to.by, -10),
                       "Shift+,", when=recorded),
            ActionSpec("timeline_forward_ten", _MENU, "Ten steps f&orward", "Go ten steps forward.",
                       partial(to.by, 10), "Shift+.", when=recorded),
            ActionSpec("timeline_first", _MENU, "Fi&rst step",
                       "Go to the first step of the run; Home on the canvas does the same.", to.to_first, "Ctrl+Home",
                       "first", when=recorded),
            ActionSpec("timeline_last", _MENU, "&Last step",
                       "Go to the last step of the branch; End on the canvas does the same.", to.to_last, "Ctrl+End",
                       "last", when=recorded),
            ActionSpec("timeline_parameters", _MENU, "Use the pa&rameters of this step",
                       "Use the parameters with which the shown step was computed.", to.use_its_parameters, gap=True,
                       when=lambda situation: has_particles(situation) and to.other_parameters is not None),
            ActionSpec("timeline_delete", _MENU, "&Delete the branch",
                       "Delete the shown branch; steps shared with other branches are kept.",
                       lambda: to.drop(to.place[0]), icon="bin",
                       when=lambda _: bool(to.place[0]) and len(to.outline.branches) > 1),
        )  # fmt: skip

    def _follow(self) -> None:
        """Enable the moves."""
        shown = bool(self.navigation.branches)
        if shown != self._shown:
            self._shown = shown
            self.window.refresh()

    def use_memory(self) -> None:
        """Give the timeline the memory that the preferences allow."""
        megabytes = int(self.window.preferences.value(TIMELINE_MEMORY))
        self.session.post(run_call(None, Run.set_timeline_budget, megabytes * MEGABYTE))


class TasksFeature(Feature):
    """Tasks in the status bar."""

    def set_up(self) -> None:
        """Make its actions, and follow what they depend on."""
        tasks = self.session.tasks
        self.bar = TaskBar(tasks)
        self.window.statusBar().addPermanentWidget(self.bar)
        self.actions = (
            ActionSpec("cancel_task", "Run", "Cancel background &task", "Cancel the task shown in the status bar.",
                       self.bar.cancel, "Ctrl+.", gap=True,
                       when=lambda _: any(task.cancellable for task in tasks.current)),
        )  # fmt: skip
