"""The explanation of the parameter under the pointer or with the focus."""

from __future__ import annotations

from typing import Literal

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QLabel, QSizePolicy, QVBoxLayout, QWidget

from app.model.parameters.controls import Control
from app.model.text.wording import FIRST_WORDING, Wording

Form = Literal["full", "brief", "hidden"]
"""How much of an explanation is shown."""

_FROM: tuple[tuple[int, Form], ...] = ((800, "full"), (600, "brief"))
"""Height of the window from which the explanation has a form [px]; it is hidden in lower ones."""


def form_in(height: int) -> Form:
    """The form of the explanation in a window of this height.

    It does not depend on what is folded beside it, so that it stays the same while one works.
    """
    return next((form for least, form in _FROM if height >= least), "hidden")


class Explanation(QWidget):
    """Symbol, name and range of a parameter, and below them its meaning and effect.

    In a low window only its name and effect are shown, or nothing; the rest is in the tooltip of its row.
    """

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("explanation")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self._control: Control | None = None
        self._wording: Wording = FIRST_WORDING
        self._form: Form = "full"
        self.head, self.body = QLabel(), QLabel()
        for label in (self.head, self.body):
            label.setTextFormat(Qt.TextFormat.RichText)
            label.setWordWrap(True)
            label.setAlignment(Qt.AlignmentFlag.AlignTop | Qt.AlignmentFlag.AlignLeft)
            label.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Expanding)
        self.body.setObjectName("dim")
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 8, 0, 2)
        layout.setSpacing(4)
        layout.addWidget(self.head)
        layout.addWidget(self.body, 1)
        self.setFixedHeight(self.height_of(self._form))

    @property
    def control(self) -> Control | None:
        """The control that is explained."""
        return self._control

    def explain(self, control: Control) -> None:
        """Explain a control."""
        if control is not self._control:
            self._control = control
            self._write()

    def use_wording(self, wording: Wording) -> None:
        """Put the name first, or the symbol."""
        self._wording = wording
        self._write()

    def set_form(self, form: Form) -> None:
        """Show everything, only name and effect, or nothing."""
        if form != self._form:
            self._form = form
            self._fix_height()
            self._write()

    def height_of(self, form: Form) -> int:
        """Height of a form: that of the longest explanation, so that the layout stays the same for all of them."""
        line = self.fontMetrics().lineSpacing()
        return {"full": 13 * line + 14, "brief": 7 * line + 10, "hidden": 0}[form]

    def _fix_height(self) -> None:
        self.setVisible(self._form != "hidden")
        self.body.setVisible(self._form == "full")
        self.setFixedHeight(self.height_of(self._form))

    def _write(self) -> None:
        control = self._control
        if control is None:
            return
        name = f"<b>{control.label(self._wording)}</b>"
        if self._form == "brief":
            self.head.setText(f"{name}<br><small>{control.more}</small>")
            return
        self.head.setText(f"{name}<br><small>{control.span}</small>")
        place = f" &nbsp;<small>({control.equation})</small>" if control.equation else ""
        formula = f"<p style='margin: 4px 0'>{control.formula}{place}</p>"
        self.body.setText(f"{control.meaning}{formula}{control.more} {control.acts}")

    def sizeHint(self) -> QSize:
        """A usual width; the height is fixed."""
        return QSize(280, self.height())


def tip(control: Control) -> str:
    """The full explanation of a control, as the tooltip of its row."""
    place = f" ({control.equation})" if control.equation else ""
    lines = (
        f"<b>{control.title}</b> {control.facts}",
        control.meaning,
        f"{control.formula}{place}",
        control.more,
        control.acts,
    )
    return "".join(f"<p>{line}</p>" for line in lines)
