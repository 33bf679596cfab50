"""The side of the comparison: what the method with the focus is, its parameters, and what the lines mean."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QHBoxLayout, QLabel, QScrollArea, QVBoxLayout, QWidget

from app.model.text.language import from_core, tr
from app.views.canvas.layers.legend_entry import LegendEntry
from app.views.canvas.strip.legend import Sample
from app.views.mosaic.methods.settings_form import SettingsForm
from app.views.theme import theme
from cpm_core.objects.methods import CONTOUR_METHODS, Compared

WIDTH = 260

_LINES = (
    LegendEntry(1, tr("start"), tr("The start that all methods have."), theme.MOVING, "dashed", 1.4),
    LegendEntry(1, tr("particles"), tr("Particles that move."), theme.MOVING, "dot", 5.0),
    LegendEntry(1, tr("closed"), tr("Contours that bound a region."), theme.CLOSED),
    LegendEntry(1, tr("open"), tr("Contours with two ends, which have no area for Dice."), theme.OPEN),
)
_TRUE = LegendEntry(1, tr("true"), tr("Boundaries of the ground truth."), theme.TRUTH, "line", 1.6)


class Side(QWidget):
    """Name, idea and source of a method, and a form for its parameters."""

    def __init__(self) -> None:
        super().__init__()
        self.form = SettingsForm()
        self.heading, self.about = QLabel(), QLabel()
        self.heading.setStyleSheet("font-weight: bold")
        self.about.setWordWrap(True)
        self.about.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        area = QScrollArea()
        area.setWidgetResizable(True)
        area.setWidget(self.form)
        area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setFixedWidth(WIDTH)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        for widget in (self.heading, self.about):
            column.addWidget(widget)
        column.addWidget(area, 1)

    def show_method(self, name: str, compared: Compared) -> None:
        """Show the method of a name; nothing for none."""
        method = CONTOUR_METHODS.get(name)
        self.heading.setText(from_core(method.title) if method else "")
        self.about.setText(f"{from_core(method.about)}\n{method.reference}" if method else "")
        ours = tr("These are the parameters of the window: change them there and run again.")
        own = compared.settings_of(name) if method is not None and not method.of_particles else None
        self.form.show_settings(own, ours if name else "")


class Legend(QWidget):
    """Samples of the lines, each with a word."""

    def __init__(self) -> None:
        super().__init__()
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        self.truth = _sample(_TRUE)
        for chip in (*map(_sample, _LINES), self.truth):
            row.addWidget(chip)
        self.show_truth(False)

    def show_truth(self, known: bool) -> None:
        """Show the sample of the truth where one is known."""
        self.truth.setVisible(known)


def _sample(entry: LegendEntry) -> QWidget:
    chip, sample, words = QWidget(), Sample(), QLabel(entry.text)
    sample.entry = entry
    words.setObjectName("dim")
    chip.setToolTip(entry.tip)
    row = QHBoxLayout(chip)
    row.setContentsMargins(0, 0, 0, 0)
    for widget in (sample, words):
        row.addWidget(widget)
    return chip
