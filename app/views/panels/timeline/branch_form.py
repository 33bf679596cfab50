"""The form of the shown branch: its name, its deletion, and the branch that it is compared with."""

from __future__ import annotations

import math
from collections.abc import Callable

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QComboBox, QGridLayout, QLabel, QLineEdit, QToolButton, QWidget

from app.model.text.language import tr, written
from app.session.features.timeline import TimelineNavigation
from app.session.timeline.timeline import Branch

_WIDTH = 276


class BranchForm(QWidget):
    """Renames, deletes and compares the branch that is shown."""

    def __init__(self, navigation: TimelineNavigation) -> None:
        super().__init__()
        self._navigation = navigation
        self.name = QLineEdit()
        self.name.setAccessibleName(tr("Name of the branch"))
        self.name.setToolTip(tr("Name of the branch; type a new one and press Enter."))
        self.name.setMaxLength(40)
        self.name.editingFinished.connect(self._rename)
        self.delete = timeline_button("bin", tr("Delete the branch."), lambda: navigation.drop(navigation.place[0]))
        self.compare = QComboBox()
        self.compare.setAccessibleName(tr("Compare with"))
        self.compare.setToolTip(tr("Show another branch together with this one, at the same step."))
        self.compare.activated.connect(lambda index: navigation.comparison.compare(self.compare.itemData(index)))
        self._difference = QLabel()
        self._difference.setWordWrap(True)
        self._difference.setAlignment(Qt.AlignmentFlag.AlignTop | Qt.AlignmentFlag.AlignLeft)
        self._difference.setObjectName("dim")
        self.in_menu = [QAction(tr("Re&name the branch…"), self), QAction(tr("&Compare the branch with…"), self)]
        self.in_menu[0].triggered.connect(self._ask_name)
        self.in_menu[1].triggered.connect(lambda: self.compare.showPopup() if self.isVisible() else None)
        self.setFixedWidth(_WIDTH)
        column = QGridLayout(self)
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
        self._difference.hide()
        navigation.comparison.found_changed.connect(self._show_difference)

    @property
    def difference(self) -> str:
        """The sentence about the difference between the two branches."""
        return self._difference.text()

    def show_branch(self, branch: Branch | None) -> None:
        """Show a branch, or none."""
        self.name.setEnabled(branch is not None)
        self.delete.setEnabled(len(self._navigation.outline.branches) > 1)
        if not self.name.hasFocus() or not self.name.isModified():
            self.name.setText(branch.name if branch is not None else "")
            self.name.setCursorPosition(0)
        self._show_others(self._navigation.place[0])

    def _show_others(self, branch: int) -> None:
        others = [
            (known.name, known.identity) for known in self._navigation.outline.branches if known.identity != branch
        ]
        choices = [(tr("none"), None), *others]
        shown = [(self.compare.itemText(index), self.compare.itemData(index)) for index in range(self.compare.count())]
        if shown != choices:
            self.compare.clear()
            for name, identity in choices:
                self.compare.addItem(name, identity)
        self.compare.setEnabled(bool(branch and others))
        self.in_menu[1].setEnabled(bool(others))
        numbers = [identity for _, identity in choices]
        compared = self._navigation.comparison.branch
        self.compare.setCurrentIndex(numbers.index(compared) if compared in numbers else 0)

    def _show_difference(self) -> None:
        compared = self._navigation.comparison.found
        if compared is None or compared.state is None:
            self._difference.setText("")
            self._difference.hide()
            return
        ended = compared.state.step < self._navigation.place[1]
        counts = (
            tr("{there} particles at its last step, {here} here")
            if ended
            else tr("{there} particles there, {here} here")
        )
        sentence = counts.format(there=compared.state.count, here=self._navigation.count)
        apart = compared.apart
        if apart is not None and math.isfinite(apart.hausdorff):
            template = tr("{particles}; contours {mean} px apart on average, {largest} px at most.")
            mean, largest = written(f"{apart.mean_boundary_distance:.2f}"), written(f"{apart.hausdorff:.2f}")
            sentence = template.format(particles=sentence, mean=mean, largest=largest)
        self._difference.setText(sentence)
        # A label that wraps asks for the height of a single line at its least, and the panel is low.
        self._difference.setMinimumHeight(self._difference.heightForWidth(_WIDTH))
        self._difference.show()
        self._difference.setToolTip(tr("Compared at step {step}.").format(step=compared.state.step))

    def _ask_name(self) -> None:
        if self.isVisible():
            self.name.setFocus()
            self.name.selectAll()

    def _rename(self) -> None:
        known = self._navigation.branch(self._navigation.place[0])
        if known is not None and self.name.isModified() and self.name.text().strip() not in ("", known.name):
            self._navigation.rename(known.identity, self.name.text())
        self.name.setModified(False)


def timeline_button(name: str, tip: str, do: Callable[[], object]) -> QToolButton:
    """A button of the timeline with the icon `name`; the tip has its key in parentheses."""
    button = QToolButton()
    button.setObjectName(f"timeline_{name}")
    button.setAutoRaise(True)
    button.setToolTip(tip)
    button.setAccessibleName(tip.partition(" (")[0].rstrip("."))
    button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
    button.clicked.connect(lambda _=False: do())
    return button
