"""Menu Run: run and pause, timeline, tasks, parameters, and the comparison of runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from PySide6.QtCore import Qt, QTimer
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QMenu, QWidget

from app.model.export import formats
from app.model.parameters.controls import CHANNEL
from app.model.preferences.table import TIMELINE_MEMORY, UNIT, WORDING
from app.model.state.resolve import resolve
from app.model.state.situation import can_step, has_image, has_particles, is_running, is_started
from app.model.text.language import tr, written
from app.model.text.wording import wording_called
from app.session.features.timeline import TimelineNavigation
from app.session.storage.presets import PresetStore
from app.session.timeline.timeline import MEGABYTE
from app.session.worker.commands import RunCall
from app.session.worker.run import Run
from app.views.canvas.items.item import image_rectangle
from app.views.comparison.dialog import CompareDialog
from app.views.panels.parameters import ParametersPanel
from app.views.panels.presets import Presets
from app.views.panels.run import RunPanel
from app.views.panels.timeline import TimelinePanel
from app.views.widgets.actions import ActionSpec, Submenu
from app.views.widgets.fields import SpeedControl
from app.views.window.bars import TaskBar
from app.views.window.dialogs import Files
from app.views.window.feature import Feature, FeatureContext, OneDialog, Panel
from app.views.window.keyboard import Keys
from cpm_core.formats import PICTURE, TABLE

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
            ActionSpec("run", "Run", tr("Run"), tr("Start or pause the run."), session.toggle, "Space", icon="run",
                       when=has_image, worded=lambda situation: resolve(situation).run_text,
                       pictured=lambda situation: "pause" if is_running(situation) else "run"),
            ActionSpec("step", "Run", tr("&Step"), tr("Take a single step."), session.step, ".", short=tr("Step"),
                       icon="step", when=can_step),
            ActionSpec("reset", "Run", tr("&Reset"), tr("Go back to the start; the run stays on the timeline."),
                       session.reset, "R", short=tr("Reset"), icon="reset", when=is_started),
            ActionSpec("faster", "Run", tr("&Faster"), tr("Allow more steps per second."), self.speed.faster, "]",
                       gap=True),
            ActionSpec("slower", "Run", tr("S&lower"), tr("Allow fewer steps per second."), self.speed.slower, "["),
        )  # fmt: skip

    def panels(self) -> Sequence[Panel]:
        """The panel of the run."""
        return (Panel(name="run", title=tr("Run"), widget=self.panel, height=140, shortcut="F5"),)

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


_MENU = "Run>" + tr("&Timeline")

_MOVES: tuple[tuple[str, str, Callable[[TimelineNavigation], None], str, str, str], ...] = (
    ("back", tr("One step &back"), lambda to: to.by(-1), ",",
     tr("Go to the previous step; the steps after it are kept."), "back"),
    ("forward", tr("One step &forward"), lambda to: to.by(1), "", tr("Go to the next recorded step."), "forward"),
    ("back_ten", tr("Ten steps b&ack"), lambda to: to.by(-10), "Shift+,", tr("Go ten steps back."), ""),
    ("forward_ten", tr("Ten steps f&orward"), lambda to: to.by(10), "Shift+.", tr("Go ten steps forward."), ""),
    ("first", tr("Fi&rst step"), TimelineNavigation.to_first, "Ctrl+Home",
     tr("Go to the first step of the run; Home on the canvas does the same."), "first"),
    ("last", tr("&Last step"), TimelineNavigation.to_last, "Ctrl+End",
     tr("Go to the last step of the branch; End on the canvas does the same."), "last"),
    ("play", tr("&Play the recorded steps"), TimelineNavigation.toggle_play, "Shift+Space",
     tr("Play or pause the recorded steps."), "play"),
)  # fmt: skip
"""Name, text, effect, key, tip and icon of each move along the recorded steps."""


class TimelineFeature(Feature):
    """Navigation through the recorded run and its branches."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.navigation = context.workspace.navigation
        self.panel = TimelinePanel(self.navigation, lambda: is_running(context.session.situation))
        Keys(context.canvas_area.canvas, self._go_to_end)
        self._shown = False, False
        self.navigation.changed.connect(self._follow)
        context.session.document_changed.connect(lambda _: self.panel.show_parameters())
        context.preferences.follow(TIMELINE_MEMORY, self._use_budget)

    def action_specs(self) -> Sequence[ActionSpec]:
        """Moves along the timeline, and actions on branches."""
        navigation = self.navigation
        moves = [
            ActionSpec(f"timeline_{name}", _MENU, text, tip, partial(go, navigation), keys, icon=icon,
                       when=lambda _: bool(navigation.branches),
                       pictured=(lambda _: "pause" if navigation.playing else "play") if name == "play" else None)
            for name, text, go, keys, tip, icon in _MOVES
        ]  # fmt: skip
        return (
            *moves,
            ActionSpec("timeline_parameters", _MENU, tr("Use the pa&rameters of this step"),
                       tr("Set the parameters with which the shown step was computed."), navigation.use_its_parameters,
                       gap=True,
                       when=lambda situation: has_particles(situation) and navigation.other_parameters is not None),
            ActionSpec("timeline_delete", _MENU, tr("&Delete the branch"),
                       tr("Delete the shown branch; steps shared with other branches are kept."),
                       lambda: navigation.drop(navigation.place[0]), icon="bin",
                       when=lambda _: bool(navigation.place[0]) and len(navigation.outline.branches) > 1),
        )  # fmt: skip

    def panels(self) -> Sequence[Panel]:
        """The timeline, below the canvas."""
        return (
            Panel(
                name="timeline",
                title=tr("Timeline"),
                widget=self.panel,
                area="bottom",
                tab="below",
                height=40,
                shortcut="F9",
            ),
        )

    def _follow(self) -> None:
        """Enable and picture the moves."""
        shown = self.navigation.playing, bool(self.navigation.branches)
        if shown != self._shown:
            self._shown = shown
            self.context.refresh()

    def _go_to_end(self, event: QKeyEvent) -> bool:
        """Go to the first or last step by Home and End on the canvas; in sliders and fields they keep their meaning."""
        if event.key() not in (Qt.Key.Key_Home, Qt.Key.Key_End):
            return False
        (self.navigation.to_first if event.key() == Qt.Key.Key_Home else self.navigation.to_last)()
        return True

    def _use_budget(self) -> None:
        megabytes = int(self.context.preferences.value(TIMELINE_MEMORY))
        self.context.session.post(RunCall(None, Run.set_timeline_budget, megabytes * MEGABYTE))


class TasksFeature(Feature):
    """Tasks in the status bar."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.bar = TaskBar(context.session.tasks)
        context.window.statusBar().addPermanentWidget(self.bar)

    def action_specs(self) -> Sequence[ActionSpec]:
        """Cancel."""
        tasks = self.context.session.tasks
        return (
            ActionSpec("cancel_task", "Run", tr("Cancel background &task"),
                       tr("Cancel the task shown in the status bar."), self.bar.cancel, "Ctrl+.", gap=True,
                       when=lambda situation: any(task.cancellable for task in tasks.current)),
        )  # fmt: skip


class ParametersFeature(Feature):
    """Parameters and presets."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        store = PresetStore(parent=context.window)
        self.presets = Presets(context, store)
        self.panel = ParametersPanel(context.session, self.presets)
        context.preferences.follow(
            WORDING, lambda: self.panel.use_wording(wording_called(context.preferences.value(WORDING)))
        )

    def action_specs(self) -> Sequence[ActionSpec | Submenu]:
        """Presets and channels."""
        presets = Submenu(name="presets", menu="Run", text=tr("&Preset"), fill=self.presets.fill, gap=True)
        channels = Submenu(name="channels", menu="Run", text=tr("C&hannel"), fill=self.fill_channels)
        return (presets, channels)

    def panels(self) -> Sequence[Panel]:
        """The sliders."""
        return (Panel(name="parameters", title=tr("Parameters"), widget=self.panel, tab="settings", shortcut="F7"),)

    def fill_channels(self, menu: QMenu) -> None:
        """Fill a menu with the channels; a gray image has none."""
        session = self.context.session
        colored = session.image is not None and session.image.colors is not None
        for value, title, about in self.panel.choices[CHANNEL].control.choices:
            action = menu.addAction(title)
            action.setCheckable(True)
            action.setChecked(value == session.document.parameters.channel)
            action.setEnabled(colored)
            action.setStatusTip(about)
            action.triggered.connect(lambda _=False, value=value: self.panel.change(CHANNEL, value))


_LEAST_SEEN = 0.02
"""Fraction of the image that must be visible for the tiles to show only the visible part."""


class ComparisonFeature(Feature):
    """Runs with other parameters, and classical methods, next to one another."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.dialog = OneDialog(self._made)

    def action_specs(self) -> Sequence[ActionSpec]:
        """Open it with the choice of parameters, or with that of methods."""
        return (
            ActionSpec("mosaic", "Run", tr("&Mosaic of two parameters…"),
                       tr("Compare runs with several values of two parameters and choose the best."),
                       partial(self._open_at, 0), "Ctrl+M", gap=True, when=has_image),
            ActionSpec("compare_methods", "Run", tr("Compare m&ethods…"),
                       tr("Run snakes, level sets and others beside the particles, from the same start."),
                       partial(self._open_at, 1), "Ctrl+Shift+M", when=has_image),
        )  # fmt: skip

    def _made(self) -> CompareDialog | None:
        """The dialog; tiles show the visible part of the image as it is shown."""
        context, display = self.context, self.context.session.scene.display
        if display is None:
            return None
        whole = image_rectangle(display.shape)
        seen = context.canvas_area.canvas.view.viewRect().intersected(whole)
        crop = seen if seen.width() * seen.height() > _LEAST_SEEN * whole.width() * whole.height() else whole
        comparison = context.workspace.comparison
        return CompareDialog(context.window, context.session, comparison, display, crop, self._ask)

    def _open_at(self, choice: int) -> None:
        opened = self.dialog.open()
        if opened is not None:
            opened.choices.setCurrentIndex(choice)

    def close(self) -> bool:
        """Close the dialog."""
        return self.dialog.close()

    def _ask(self, parent: QWidget) -> Path | None:
        together = (Files(tr("Table of all methods"), (TABLE,)), Files(tr("Picture of all methods"), (PICTURE,)))
        apart = {suffix: name for suffix, name in formats().items() if suffix not in (TABLE, PICTURE)}
        each = tr("Contours of each method: {format}")
        kinds = (*together, *(Files(each.format(format=name), (suffix,)) for suffix, name in apart.items()))
        image = self.context.session.scene.image
        name = f"{Path(image.source).stem if image else ''}.methods.csv"
        return self.context.files.ask_where_to_save("export", tr("Export the comparison"), name, kinds, parent=parent)
