"""A parameter has one name, in the table of the core, wherever it is shown or written about."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from PySide6.QtWidgets import QLabel

from app.model.document import edits
from app.model.document.changes import in_words
from app.model.document.document import Document
from app.model.parameters.controls import controls
from app.views.comparison.choices import AxisRow
from app.views.help.guide import _LABELS
from app.views.panels.parameters import tip
from cpm_core.parameters import PARAMETERS

ROOT = Path(__file__).parents[3]
FORMER = (
    "Calm the particles", "Push into bays", "Pull to edges", "Keep filling gaps", "Gaps that are filled", "Bridge gaps",
    "Length of a stride", "Space between particles", "Blur beforehand", "Weigh dark and bright", "Coarse scales first",
    "Ignore faint edges", "Ignore a border", "Drop weak contours", "Weak only beside strong", "Drop texture",
    "Drop short contours", "Leave out what is wider", "Cut short branches", "Reach beyond the object",
    "As strong as around the start", "Coulomb weight", "Lorentz weight", "Annealing factor", "Smallest distance",
    "Widest gap", "Widest border", "Least strength", "Least contrast", "Least length",
)  # fmt: skip
"""Names that parameters have had in some place."""


def test_all_places_use_the_name_in_the_table(window, qtbot) -> None:
    panel, table = window.panels["parameters"], window.panels["contours"]
    row = AxisRow("Rows", controls(), "beta")
    shown = [row.choice.itemText(index) for index in range(row.choice.count())]
    for control, in_mosaic in zip(controls(), shown, strict=True):
        name = control.title
        assert name == (PARAMETERS[control.name].title if control.name in PARAMETERS else "Repulsion to attraction")
        slider = panel.rows[control.name]
        assert slider.findChild(QLabel).text().startswith(f"{name} ")
        assert slider.slider.accessibleName() == slider.number.accessibleName() == name
        assert in_mosaic.startswith(f"{name} ")
        assert name in tip(control)
        assert f"“{name}”" in _LABELS[control.name]
        if control.name in table.thresholds:
            assert table.thresholds[control.name].title == name
    row.deleteLater()


@pytest.mark.parametrize("control", [c for c in controls() if c.name != "w1"], ids=lambda control: control.name)
def test_the_history_uses_the_name_in_the_table(control) -> None:
    value = control.slider_high if control.default != control.slider_high else control.slider_low
    after = edits.set_parameter(Document(), control.name, round(value) if control.whole else value)
    assert in_words("any", Document(), after).text.startswith(f"{control.title} ")


def test_no_text_uses_a_former_name() -> None:
    texts = [ROOT / "README.md", *(ROOT / "app").rglob("*.py"), *(ROOT / "cpm_core" / "parameters").rglob("*.py")]
    for path in texts:
        text = re.sub(r'""".*?"""', "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
        found = [name for name in FORMER if re.search(rf"\b{name}\b", text)]
        assert not found, (path, found)
