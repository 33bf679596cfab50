"""The panel of the timeline: buttons, the step, the branches as they are drawn, and what they are compared by."""

from __future__ import annotations

import math
from collections.abc import Callable

from PySide6.QtCore import QSignalBlocker, Qt, QTimer
from PySide6.QtWidgets import (
    QComboBox,
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QScrollArea,
    QSpinBox,
    QToolButton,
    QWidget,
)

from app.model.text.language import tr
from app.session.features.timeline_navigation import TimelineNavigation
from app.session.worker.recorded_run import MEGABYTE
from app.views.panels.timeline.timeline_view import ROW, TimelineView
from app.views.theme.icons import icon
from app.views.theme.theme import Theme

_SLOWLY = 100
"""Time between two looks while the run goes on [ms]."""

_COLUMN = 276


class TimelinePanel(QWidget):
    """Shows the timeline of a run and lets a person go through it.

    Parameters
    ----------
    navigation : TimelineNavigation
        What it shows.
    running : callable
        Whether steps are being taken, so that a slower pace will do.
    """

    def __init__(self, navigation: TimelineNavigation, running: Callable[[], bool]) -> None:
        super().__init__()
        self._navigation = navigation
        self._running = running
        self._theme: Theme | None = None
        self.view = TimelineView(navigation)
        self.view.asked.connect(navigation.go)
        self.buttons = {
            name: self._button(name, tip, do)
            for name, tip, do in (
                ("first", tr("Go to the beginning of the run (Home)."), navigation.to_first),
                ("back", tr("Go one step back (,)."), lambda: navigation.by(-1)),
                ("play", tr("Play the recorded steps, or hold."), navigation.toggle_play),
                ("forward", tr("Go one recorded step forward."), lambda: navigation.by(1)),
                ("last", tr("Go to the last step of the branch (End)."), navigation.to_last),
            )
        }
        self.step = QSpinBox()
        self.step.setKeyboardTracking(False)
        self.step.setAccessibleName(tr("Step"))
        self.step.setToolTip(tr("Step that is shown; type one to go there."))
        self.step.valueChanged.connect(lambda step: navigation.go(navigation.place[0], step))
        self._of = QLabel()
        self._memory = QLabel()
        self.parameters = QToolButton()
        self.parameters.setText(tr("Use its parameters"))
        self.parameters.setToolTip(
            tr("This step was taken with other parameters than are set now; set those, so that going on repeats it.")
        )
        self.parameters.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.parameters.clicked.connect(lambda _=False: navigation.use_its_parameters())
        self.name = QLineEdit()
        self.name.setAccessibleName(tr("Name of the branch"))
        self.name.setToolTip(tr("Name of the branch; type another one and press Enter."))
        self.name.setMaxLength(40)
        self.name.editingFinished.connect(self._rename)
        self.delete = self._button("bin", tr("Delete the branch."), lambda: navigation.drop(navigation.place[0]))
        self.compare = QComboBox()
        self.compare.setAccessibleName(tr("Compare with"))
        self.compare.setToolTip(tr("Another branch to show beside this one, at the same step."))
        self.compare.activated.connect(lambda index: navigation.comparison.compare(self.compare.itemData(index)))
        self._difference = QLabel()
        self._difference.setWordWrap(True)
        self._difference.setAlignment(Qt.AlignmentFlag.AlignTop | Qt.AlignmentFlag.AlignLeft)
        for label in (self._of, self._memory, self._difference):
            label.setObjectName("dim")
        self._lay_out()
        self._later = QTimer(self, singleShot=True, interval=_SLOWLY)
        self._later.timeout.connect(self._show)
        navigation.changed.connect(self._follow)
        navigation.comparison.found_changed.connect(self._show_difference)
        self._show()

    def use_theme(self, theme: Theme) -> None:
        """Tint the icons."""
        self._theme = theme
        for name, button in (*self.buttons.items(), ("bin", self.delete)):
            button.setIcon(icon(self._pictured(name), theme.text, faded=theme.line))

    @property
    def difference(self) -> str:
        """What is said about the branch compared with."""
        return self._difference.text()

    def _lay_out(self) -> None:
        transport = QHBoxLayout()
        transport.setSpacing(2)
        for button in self.buttons.values():
            transport.addWidget(button)
        transport.addStretch(1)
        step = QHBoxLayout()
        step.setSpacing(6)
        label = QLabel(tr("Step"))
        label.setBuddy(self.step)
        for widget in (label, self.step, self._of):
            step.addWidget(widget)
        step.addStretch(1)
        scroll = self._scroll = QScrollArea()
        scroll.setWidget(self.view)
        scroll.setWidgetResizable(True)
        scroll.setFrameShape(QFrame.Shape.NoFrame)
        scroll.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        scroll.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        scroll.verticalScrollBar().valueChanged.connect(self.view.update)  # the axis does not move along
        side = QWidget()
        side.setFixedWidth(_COLUMN)
        column = QGridLayout(side)
        column.setContentsMargins(0, 0, 0, 0)
        column.setVerticalSpacing(3)
        column.addWidget(QLabel(tr("Branch")), 0, 0)
        column.addWidget(self.name, 0, 1)
        column.addWidget(self.delete, 0, 2)
        column.addWidget(QLabel(tr("Compare with")), 1, 0)
        column.addWidget(self.compare, 1, 1, 1, 2)
        column.addWidget(self._difference, 2, 0, 1, 3)
        column.setColumnStretch(1, 1)
        column.setRowStretch(2, 1)
        grid = QGridLayout(self)
        grid.setContentsMargins(8, 4, 8, 4)
        grid.setHorizontalSpacing(10)
        grid.setVerticalSpacing(3)
        grid.addLayout(transport, 0, 0)
        grid.addLayout(step, 1, 0)
        grid.addWidget(self._memory, 2, 0)
        grid.addWidget(self.parameters, 2, 0, Qt.AlignmentFlag.AlignLeft)
        grid.addWidget(scroll, 0, 1, 3, 1)
        grid.addWidget(side, 0, 2, 3, 1)
        grid.setColumnStretch(1, 1)
        self.setMinimumHeight(92)

    def _button(self, name: str, tip: str, do: Callable[[], object]) -> QToolButton:
        button = QToolButton()
        button.setObjectName(f"timeline_{name}")
        button.setAutoRaise(True)
        button.setToolTip(tip)
        button.setAccessibleName(tip.partition("(")[0].strip().rstrip("."))
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        button.clicked.connect(lambda _=False: do())
        return button

    def _pictured(self, name: str) -> str:
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
        able = {
            "first": step > navigation.first,
            "back": step > navigation.first,
            "forward": step < last,
            "last": step < last,
        }
        for name, button in self.buttons.items():
            button.setEnabled(there and able.get(name, True))
        self.step.setEnabled(there)
        self.name.setEnabled(there)
        self.delete.setEnabled(len(navigation.outline.branches) > 1)
        if not self.name.hasFocus() or not self.name.isModified():
            self.name.setText(known.name if known is not None else "")
            self.name.setCursorPosition(0)
        self._show_others(branch)
        self._show_memory()
        self.show_parameters()
        if self._theme is not None:
            play = self.buttons["play"]
            if play.property("pictured") != self._pictured("play"):
                play.setProperty("pictured", self._pictured("play"))
                play.setIcon(icon(self._pictured("play"), self._theme.text, faded=self._theme.line))
        self.view.refresh()
        if there:
            self._scroll.ensureVisible(0, round(self.view.point(branch, step).y()), 0, ROW)

    def _show_others(self, branch: int) -> None:
        others = [
            (known.name, known.identity) for known in self._navigation.outline.branches if known.identity != branch
        ]
        wanted = [(tr("nothing"), None), *others]
        shown = [(self.compare.itemText(index), self.compare.itemData(index)) for index in range(self.compare.count())]
        if shown != wanted:
            self.compare.clear()
            for name, identity in wanted:
                self.compare.addItem(name, identity)
        self.compare.setEnabled(bool(others))
        numbers = [identity for _, identity in wanted]
        compared = self._navigation.comparison.branch
        self.compare.setCurrentIndex(numbers.index(compared) if compared in numbers else 0)

    def show_parameters(self) -> None:
        """Offer the parameters of the step where others are set, in the place of what memory there is."""
        other = self._navigation.other_parameters is not None and not self._running()
        self.parameters.setVisible(other)
        self._memory.setVisible(not other)

    def _show_memory(self) -> None:
        outline = self._navigation.outline
        words = tr("{used} of {budget} MB used")
        used = f"{outline.used / MEGABYTE:.{0 if outline.used > 10 * MEGABYTE else 1}f}"
        self._memory.setText(words.format(used=used, budget=outline.budget // MEGABYTE) if outline.budget else "")
        told = tr("{count} steps are kept whole, the others are worked out anew. The preferences say how much memory.")
        self._memory.setToolTip(told.format(count=outline.kept))

    def _show_difference(self) -> None:
        compared = self._navigation.comparison.found
        if compared is None or compared.state is None:
            self._difference.setText("")
            return
        ended = compared.state.step < self._navigation.place[1]
        there = tr("{there} particles at its end, {here} here") if ended else tr("{there} particles there, {here} here")
        words = there.format(there=compared.state.count, here=self._navigation.count)
        apart = compared.apart
        if apart is not None and math.isfinite(apart.hausdorff):
            told = tr("{particles}; contours {mean} px apart on average, {largest} px at most.")
            mean, largest = f"{apart.mean_boundary_distance:.2f}", f"{apart.hausdorff:.2f}"
            words = told.format(particles=words, mean=mean, largest=largest)
        self._difference.setText(words)
        self._difference.setToolTip(tr("Compared at step {step}.").format(step=compared.state.step))

    def _rename(self) -> None:
        known = self._navigation.branch(self._navigation.place[0])
        if known is not None and self.name.isModified() and self.name.text().strip() not in ("", known.name):
            self._navigation.rename(known.identity, self.name.text())
        self.name.setModified(False)
