"""Menu Run: run and pause, timeline, tasks and parameters."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import Qt, QTimer
from PySide6.QtGui import QKeyEvent

from cpm_app.model.preferences.table import TIMELINE_MEMORY, UNIT_PREFERENCE
from cpm_app.model.state.resolve import resolve_texts
from cpm_app.model.state.situation import (
    Situation,
    can_step,
    has_image,
    has_particles,
    is_running,
    is_started,
    moves_particles,
)
from cpm_app.model.text.language import tr
from cpm_app.session.storage.presets import PresetStore
from cpm_app.session.timeline.timeline import BYTES_PER_MEGABYTE
from cpm_app.session.worker.commands import call_run
from cpm_app.session.worker.run import Run
from cpm_app.views.panels.parameters import ParametersPanel
from cpm_app.views.panels.presets import PresetBox
from cpm_app.views.panels.run import RunPanel
from cpm_app.views.panels.timeline import TimelinePanel
from cpm_app.views.widgets.actions import ActionSpec
from cpm_app.views.window.bars import TaskBar
from cpm_app.views.window.dialogs import ask_for_text
from cpm_app.views.window.docks import Panel
from cpm_app.views.window.keyboard import KeyFilter
from cpm_app.views.window.window import Feature

_NUMBERS_INTERVAL = 250
"""Time between two updates of the panel during a run [ms]."""

_UNFOLDED_SECTIONS_KEY = "run/unfolded"
"""Preference: names of the unfolded sections."""


class RunControlFeature(Feature):
    """Controls and state of the run."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        window = self.window
        session, speed = window.session, window.speed
        self.presets = presets = PresetBox(window, PresetStore(parent=window))
        parameters = ParametersPanel(session, presets)
        self.panel = RunPanel(parameters)
        self.panels = (Panel("run", "Run", self.panel, "F5"),)
        self.panel.unfold_sections(window.preferences.read_key(_UNFOLDED_SECTIONS_KEY, []))
        self.panel.section_toggled.connect(self._keep_unfolded)
        self._keep_unfolded()
        self._timer = QTimer(self.panel, interval=_NUMBERS_INTERVAL)
        self._timer.timeout.connect(self._show_values)
        session.store.status_changed.connect(self._on_status_changed)
        window.preferences.call_on_change(UNIT_PREFERENCE, self._on_status_changed)
        self.actions = (
            ActionSpec("run", "Run", "Run", "Start or pause the run.", session.toggle_run, "Space", icon="run",
                       when=has_image, text_for=lambda situation: resolve_texts(situation).run_text,
                       icon_for=lambda situation: "pause" if is_running(situation) else "run"),
            ActionSpec("step", "Run", "&Step", "Take a single step.", session.step, ".", short=tr("Step"), icon="step",
                       when=can_step),
            ActionSpec("reset", "Run", "&Reset", "Go back to the start; the run stays on the timeline.",
                       session.reset, "R", short=tr("Reset"), icon="reset", when=is_started),
            ActionSpec("faster", "Run", "&Faster", "Allow more steps per second.", speed.speed_up, "Ctrl+]", gap=True),
            ActionSpec("slower", "Run", "S&lower", "Allow fewer steps per second.", speed.slow_down, "Ctrl+["),
            ActionSpec("save_preset", ">" + tr("Run"), "&Save as…", "Save the current parameters under a name.",
                       presets.save_preset, icon="save"),
            ActionSpec("delete_preset", ">" + tr("Run"), "&Delete…", "Delete the preset in use, if it is your own.",
                       presets.delete_preset, icon="bin",
                       when=lambda _: presets.current is not None and presets.current.is_own),
        )  # fmt: skip

    def close(self) -> bool:
        """Stop the updates."""
        self._timer.stop()
        return True

    def _keep_unfolded(self) -> None:
        self.window.preferences.store_key(_UNFOLDED_SECTIONS_KEY, self.panel.unfolded_sections)

    def _on_status_changed(self) -> None:
        running = is_running(self.session.situation)
        if running != self._timer.isActive():
            (self._timer.start if running else self._timer.stop)()
        if not running:
            self._show_values()

    def _show_values(self) -> None:
        session = self.session
        resolved, snapshot = session.resolved, session.scene.snapshot
        self.panel.status.show_resolved(resolved)
        self.panel.plots.setVisible(moves_particles(session.situation))
        self.panel.show_metrics(snapshot.metrics if snapshot else None)


_TIMELINE_GROUP = ">" + tr("Timeline")
"""Group in the list of keys."""


class TimelineFeature(Feature):
    """Navigation through the recorded run and its branches."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        window = self.window
        self.navigation = to = window.workspace.navigation
        self.panel = TimelinePanel(to, lambda: self.session.status)
        self.panels = (Panel("timeline", "Timeline", self.panel, "F9", below_canvas=True),)
        self.session.store.status_changed.connect(lambda: self.panel.setVisible(self.session.status.started))

        def go_to_end(event: QKeyEvent) -> bool:
            """Go to an end of the run by Home or End on the canvas; sliders and fields keep these keys."""
            ends = {Qt.Key.Key_Home: to.go_to_first, Qt.Key.Key_End: to.go_to_last}
            if event.key() in ends:
                ends[Qt.Key(event.key())]()
            return event.key() in ends

        KeyFilter(self.canvas, go_to_end)
        self._shown = False
        to.changed.connect(self._on_timeline_changed)
        window.preferences.call_on_change(TIMELINE_MEMORY, self.apply_memory_limit)

        def has_recorded_run(_: Situation) -> bool:
            return bool(to.branches)

        self.actions = (
            ActionSpec("timeline_back", _TIMELINE_GROUP, "One step &back",
                       "Go to the previous step; the steps after it are kept.", partial(to.go_by, -1), ",", "back",
                       when=has_recorded_run),
            ActionSpec("timeline_forward", _TIMELINE_GROUP, "One step &forward", "Go to the next recorded step.",
                       partial(to.go_by, 1), icon="forward", when=has_recorded_run),
            ActionSpec("timeline_first", _TIMELINE_GROUP, "Fi&rst step",
                       "Go to the first step of the run; Home on the canvas does the same.", to.go_to_first,
                       "Ctrl+Home", "first", when=has_recorded_run),
            ActionSpec("timeline_last", _TIMELINE_GROUP, "&Last step",
                       "Go to the last step of the branch; End on the canvas does the same.", to.go_to_last, "Ctrl+End",
                       "last", when=has_recorded_run),
            ActionSpec("timeline_parameters", _TIMELINE_GROUP, "Use the pa&rameters of this step",
                       "Use the parameters with which the shown step was computed.", to.use_step_parameters,
                       icon="restore", gap=True,
                       when=lambda situation: has_particles(situation) and not is_running(situation)
                       and to.differing_parameters is not None),
            ActionSpec("timeline_rename", _TIMELINE_GROUP, "Re&name the branch…", "Give the shown branch another name.",
                       self._rename_branch, icon="branch", when=lambda _: bool(to.current_step[0])),
            ActionSpec("timeline_delete", _TIMELINE_GROUP, "&Delete the branch",
                       "Delete the shown branch; steps shared with other branches are kept.",
                       lambda: to.remove_branch(to.current_step[0]), icon="bin",
                       when=lambda _: bool(to.current_step[0]) and len(to.timeline_state.branches) > 1),
        )  # fmt: skip

    def _on_timeline_changed(self) -> None:
        """Update the actions when the first run is recorded or the last one is gone."""
        shown = bool(self.navigation.branches)
        if shown != self._shown:
            self._shown = shown
            self.window.refresh_actions()

    def _rename_branch(self) -> None:
        known = self.navigation.find_branch(self.navigation.current_step[0])
        if known is not None:
            title, button = tr("Name of the branch"), tr("Use this name")
            name = ask_for_text(self.window, title, tr("Name:"), button, known.name)
            if name and name.strip() not in ("", known.name):
                self.navigation.rename_branch(known.identity, name)

    def apply_memory_limit(self) -> None:
        """Give the timeline the memory that the preferences allow."""
        megabytes = int(self.window.preferences.read_preference(TIMELINE_MEMORY))
        self.session.post_command(call_run(None, Run.set_timeline_budget, megabytes * BYTES_PER_MEGABYTE))


class TasksFeature(Feature):
    """Background tasks in the status bar."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        tasks = self.session.tasks
        self.bar = TaskBar(tasks)
        self.window.statusBar().insertPermanentWidget(0, self.bar)
        self.actions = (
            ActionSpec("cancel_task", "Run", "Cancel background &task", "Cancel the task shown in the status bar.",
                       self.bar.cancel, "Ctrl+.", gap=True,
                       when=lambda _: any(task.cancellable for task in tasks.current)),
        )  # fmt: skip
