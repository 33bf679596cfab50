"""The panel of the timeline: buttons, the step, the branches and their form."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QSignalBlocker, QSize, Qt, QTimer
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import (
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QMenu,
    QScrollArea,
    QSpinBox,
    QToolButton,
    QWidget,
    QWidgetAction,
)

from app.model.text.keys import with_keys
from app.model.text.language import tr, written
from app.session.features.timeline import TimelineNavigation
from app.session.worker.recorded_run import MEGABYTE
from app.views.panels.timeline.branch_form import BranchForm, timeline_button
from app.views.panels.timeline.timeline_places import FOOT, HEAD, ROW
from app.views.panels.timeline.timeline_view import TimelineView
from app.views.theme.icons import icon
from app.views.theme.theme import Theme

_SLOWLY = 100
"""Time between two updates during the run [ms]."""

_WIDE = 600
"""Width from which the form of the branch stands beside the track; it is behind a button in narrower panels [px]."""

_ROWS = 3
"""Number of branches that are always seen; the track scrolls to further ones."""

_TIPS = {
    "first": tr("Go to the first step of the run ({key:timeline_first})."),
    "back": tr("Go one step back ({key:timeline_back})."),
    "play": tr("Play or pause the recorded steps ({key:timeline_play})."),
    "forward": tr("Go one recorded step forward ({key:timeline_forward})."),
    "last": tr("Go to the last step of the branch ({key:timeline_last})."),
}
_NARROW, _TRACK = 316, 120
"""Least width of the panel and of its track [px]."""


class TimelinePanel(QWidget):
    """Shows the timeline of a run and goes to any of its steps; updated less often while `running` is true."""

    def __init__(self, navigation: TimelineNavigation, running: Callable[[], bool]) -> None:
        super().__init__()
        self._navigation = navigation
        self._running = running
        self._theme: Theme | None = None
        self.view = TimelineView(navigation)
        self.setFocusProxy(self.view)
        self.view.step_requested.connect(navigation.go)
        moves: dict[str, Callable[[], object]] = {
            "first": navigation.to_first,
            "back": lambda: navigation.by(-1),
            "play": navigation.toggle_play,
            "forward": lambda: navigation.by(1),
            "last": navigation.to_last,
        }
        self.buttons = {name: timeline_button(name, with_keys(_TIPS[name]), do) for name, do in moves.items()}
        self.step = QSpinBox()
        self.step.setKeyboardTracking(False)
        self.step.setAccessibleName(tr("Step"))
        self.step.setToolTip(tr("Shown step; type a number to go there."))
        self.step.valueChanged.connect(lambda step: navigation.go(navigation.place[0], step))
        self._of = QLabel()
        self.parameters = QToolButton()
        self.parameters.setObjectName("timeline_parameters")
        self.parameters.setText(tr("Use these parameters"))
        self.parameters.setAccessibleName(self.parameters.text())
        self.parameters.setToolTip(tr("This step was computed with different parameters. Set them again to repeat it."))
        self.parameters.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.parameters.clicked.connect(lambda _=False: navigation.use_its_parameters())
        self._of.setObjectName("dim")
        self.branch = BranchForm(navigation)
        self.view.addActions(self.branch.in_menu)
        self._behind = BranchForm(navigation)
        self.more = QToolButton()
        for action in self.branch.in_menu:
            action.triggered.connect(self._open_more)
        self._lay_out()
        self._later = QTimer(self, singleShot=True, interval=_SLOWLY)
        self._later.timeout.connect(self._show)
        navigation.changed.connect(self._follow)
        self._show()

    def use_theme(self, theme: Theme) -> None:
        """Color the icons."""
        self._theme = theme
        bins = [("bin", form.delete) for form in (self.branch, self._behind)]
        for name, button in (*self.buttons.items(), *bins, ("branch", self.more), ("restore", self.parameters)):
            button.setIcon(icon(self._icon_name(name), theme.text, faded=theme.line))

    def _lay_out(self) -> None:
        transport = QHBoxLayout()
        transport.setSpacing(2)
        for button in self.buttons.values():
            transport.addWidget(button)
        transport.addWidget(self._make_more())
        transport.addStretch(1)
        step = QHBoxLayout()
        step.setSpacing(6)
        label = QLabel(tr("Step"))
        label.setBuddy(self.step)
        for widget in (label, self.step, self._of, self.parameters):
            step.addWidget(widget)
        step.addStretch(1)
        scroll = self._scroll = QScrollArea()
        scroll.setWidget(self.view)
        scroll.setWidgetResizable(True)
        scroll.setFrameShape(QFrame.Shape.NoFrame)
        scroll.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        scroll.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        scroll.setMinimumWidth(_TRACK)
        scroll.verticalScrollBar().valueChanged.connect(self.view.update)  # the axis does not scroll
        grid = QGridLayout(self)
        grid.setContentsMargins(8, 2, 8, 2)
        grid.setHorizontalSpacing(10)
        grid.setVerticalSpacing(1)
        grid.addLayout(transport, 0, 0)
        grid.addLayout(step, 1, 0)
        grid.addWidget(scroll, 0, 1, 3, 1)
        grid.addWidget(self.branch, 0, 2, 3, 1)
        grid.setColumnStretch(1, 1)
        grid.setRowStretch(2, 1)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Put the form of the branch behind a button where there is no room for it."""
        super().resizeEvent(event)
        wide = self.width() >= _WIDE
        self.branch.setVisible(wide)
        self.more.setVisible(not wide)
        style = Qt.ToolButtonStyle
        self.parameters.setToolButtonStyle(style.ToolButtonTextOnly if wide else style.ToolButtonIconOnly)

    def show_keys(self) -> None:
        """Name the keys as they are now."""
        for name, button in self.buttons.items():
            button.setToolTip(with_keys(_TIPS[name]))

    def minimumSizeHint(self) -> QSize:
        """Room for the buttons and a short track."""
        hint = super().minimumSizeHint()
        return QSize(min(hint.width(), _NARROW), hint.height())

    def _open_more(self) -> None:
        """Open the form of the branch where there is no room for it beside the timeline."""
        if not self.more.isHidden():
            self.more.showMenu()

    def _make_more(self) -> QToolButton:
        """The button that opens the form of the branch."""
        menu = QMenu(self.more)
        shown = QWidgetAction(menu)
        shown.setDefaultWidget(self._behind)
        self._behind.setContentsMargins(8, 8, 8, 8)
        menu.addAction(shown)
        self.more.setObjectName("timeline_branch")
        self.more.setAutoRaise(True)
        self.more.setMenu(menu)
        self.more.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self.more.setToolTip(tr("Name, delete and compare the branch."))
        self.more.setAccessibleName(tr("Branch"))
        self.more.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.more.hide()
        return self.more

    def _icon_name(self, name: str) -> str:
        return "pause" if name == "play" and self._navigation.playing else name

    def _follow(self) -> None:
        if not self._running():
            self._later.stop()
            self._show()
        elif not self._later.isActive():
            self._later.start()

    def _show(self) -> None:
        navigation = self._navigation
        branch, step = navigation.place
        known, last = navigation.branch(branch), navigation.last(branch)
        there = known is not None
        with QSignalBlocker(self.step):
            self.step.setRange(navigation.first, max(last, step))
            self.step.setValue(step)
        self._of.setText(tr("of {last}").format(last=last) if there else "")
        enabled = {
            "first": step > navigation.first,
            "back": step > navigation.first,
            "forward": step < last,
            "last": step < last,
        }
        for name, button in self.buttons.items():
            button.setEnabled(enabled.get(name, True) if there else navigation.recorded and name in ("back", "last"))
        self.step.setEnabled(there)
        for form in (self.branch, self._behind):
            form.show_branch(known)
        self._show_memory()
        self.show_parameters()
        if self._theme is not None:
            play = self.buttons["play"]
            if play.property("icon_name") != self._icon_name("play"):
                play.setProperty("icon_name", self._icon_name("play"))
                play.setIcon(icon(self._icon_name("play"), self._theme.text, faded=self._theme.line))
        self.view.refresh()
        rows = min(max(len(navigation.outline.branches), 1), _ROWS)
        self._scroll.setMinimumHeight(HEAD + rows * ROW + FOOT)
        if there:
            self._scroll.ensureVisible(0, round(self.view.point(branch, step).y()), 0, ROW)

    def show_parameters(self) -> None:
        """Offer the parameters of the step if they differ from the present ones."""
        differ = self._navigation.other_parameters is not None and not self._running()
        self.parameters.setVisible(differ)

    def _show_memory(self) -> None:
        outline = self._navigation.outline
        used = written(f"{outline.used / MEGABYTE:.{0 if outline.used > 10 * MEGABYTE else 1}f}")
        words = tr(
            "{used} of {budget} MB used: {count} steps are stored, the others are computed again when they are needed. "
            "The preferences set the memory."
        )
        tip = words.format(used=used, budget=outline.budget // MEGABYTE, count=outline.kept)
        self._of.setToolTip(tip if outline.budget else "")
