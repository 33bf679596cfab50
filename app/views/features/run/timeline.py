"""The timeline: going back to any step of a run, and branches."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QLabel

from app.model.preferences.table import TIMELINE_MEMORY
from app.model.state.situation import has_particles, is_running
from app.model.text.language import tr
from app.model.text.numbers import written
from app.session.features.timeline import TimelineNavigation
from app.session.worker.commands import RunCall
from app.session.worker.recorded_run import MEGABYTE
from app.session.worker.run import Run
from app.views.panels.timeline.timeline_panel import TimelinePanel
from app.views.theme.theme import Theme
from app.views.widgets.action_spec import ActionSpec
from app.views.widgets.preference_row import PreferenceRow
from app.views.window.feature import Feature, FeatureContext, Panel

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
        self._keys = _Keys(self.navigation, context.window)
        context.canvas_area.canvas.installEventFilter(self._keys)
        context.session.document_changed.connect(lambda _: self.panel.show_parameters())
        context.preferences.follow(TIMELINE_MEMORY, self._use_budget)

    def action_specs(self) -> Sequence[ActionSpec]:
        """Moves along the timeline, and actions on branches."""
        navigation = self.navigation
        moves = [
            ActionSpec(name=f"timeline_{name}", menu=_MENU, text=text, do=partial(go, navigation),
                       shortcuts=(keys,) if keys else (), tip=tip, icon=icon,
                       when=lambda _: navigation.recorded)
            for name, text, go, keys, tip, icon in _MOVES
        ]  # fmt: skip
        return (
            *moves,
            ActionSpec(name="timeline_parameters", menu=_MENU, text=tr("Use the pa&rameters of this step"),
                       do=navigation.use_its_parameters,
                       tip=tr("Set the parameters with which the shown step was computed."), gap=True,
                       when=lambda situation: has_particles(situation) and navigation.other_parameters is not None),
            ActionSpec(name="timeline_delete", menu=_MENU, text=tr("&Delete the branch"),
                       do=lambda: navigation.drop(navigation.place[0]),
                       tip=tr("Delete the shown branch; steps shared with other branches are kept."), icon="bin",
                       when=lambda _: bool(navigation.place[0]) and len(navigation.outline.branches) > 1),
        )  # fmt: skip

    def panels(self) -> Sequence[Panel]:
        """The timeline, below the canvas."""
        return (
            Panel(name="timeline", title=tr("Timeline"), widget=self.panel, area="bottom", tab="below", shortcut="F9"),
        )

    def preferences(self) -> Sequence[PreferenceRow]:
        """The memory that the timeline uses."""
        return (PreferenceRow(page="run", label=tr("In use now"), make=self._memory_label),)

    def use_theme(self, theme: Theme) -> None:
        """Color the buttons."""
        self.panel.use_theme(theme)

    def use_keys(self) -> None:
        """Name the keys as they are now."""
        self.panel.show_keys()

    def _memory_label(self) -> QLabel:
        label = QLabel()
        navigation = self.navigation

        def show() -> None:
            outline = navigation.outline
            words = tr("{used} MB for {count} steps")
            label.setText(words.format(used=written(f"{outline.used / MEGABYTE:.1f}"), count=outline.kept))

        show()
        navigation.changed.connect(show)
        label.destroyed.connect(lambda: navigation.changed.disconnect(show))
        return label

    def _use_budget(self) -> None:
        megabytes = int(self.context.preferences.value(TIMELINE_MEMORY))
        self.context.session.post(RunCall(None, Run.set_timeline_budget, megabytes * MEGABYTE))


class _Keys(QObject):
    """Home and End on the canvas; in sliders, lists and fields they keep their usual meaning."""

    def __init__(self, navigation: TimelineNavigation, parent: QObject) -> None:
        super().__init__(parent)
        self._navigation = navigation

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Go to the first or last step."""
        if event.type() == QEvent.Type.KeyPress and isinstance(event, QKeyEvent):
            if event.key() == Qt.Key.Key_Home:
                self._navigation.to_first()
                return True
            if event.key() == Qt.Key.Key_End:
                self._navigation.to_last()
                return True
        return False
