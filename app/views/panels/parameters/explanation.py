"""The explanation of the parameter under the pointer or with the focus."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QHBoxLayout, QLabel, QSizePolicy, QVBoxLayout, QWidget

from app.model.parameters.controls import Control
from app.model.text.language import tr
from app.model.text.wording import FIRST_WORDING, Wording
from app.views.panels.parameters.illustration import Illustration

_FULL_CONTRAST = 255.0


class Explanation(QWidget):
    """The illustration with symbol, name and range beside it, and below the meaning and effect of the parameter.

    In a low panel only its name and effect are shown; the rest is in the tooltip of its row.
    """

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("explanation")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.illustration = Illustration()
        self._control: Control | None = None
        self._wording: Wording = FIRST_WORDING
        self._brief = False
        self.head, self.body = QLabel(), QLabel()
        for label in (self.head, self.body):
            label.setTextFormat(Qt.TextFormat.RichText)
            label.setWordWrap(True)
            label.setAlignment(Qt.AlignmentFlag.AlignTop | Qt.AlignmentFlag.AlignLeft)
            label.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Expanding)
        self.body.setObjectName("dim")
        above = QHBoxLayout()
        above.setSpacing(10)
        above.addWidget(self.illustration, alignment=Qt.AlignmentFlag.AlignTop)
        above.addWidget(self.head, 1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 8, 0, 2)
        layout.setSpacing(4)
        layout.addLayout(above)
        layout.addWidget(self.body, 1)
        self._fix_height()

    @property
    def control(self) -> Control | None:
        """The control that is explained."""
        return self._control

    def explain(self, control: Control, value: float | str, contrast: float) -> None:
        """Explain a control at its value; gray levels are scaled by the contrast of the image."""
        if control is not self._control:
            self._control = control
            self._write()
        if control.in_gray_levels and not isinstance(value, str) and contrast > 0:
            value = value * _FULL_CONTRAST / contrast
        self.illustration.show_control(control.name, value)

    def use_wording(self, wording: Wording) -> None:
        """Put plain words first, or the symbol."""
        self._wording = wording
        self._write()

    def set_brief(self, brief: bool) -> None:
        """Show only name and effect where there is little room, or everything."""
        if brief != self._brief:
            self._brief = brief
            self._fix_height()
            self._write()

    def _fix_height(self) -> None:
        """Fix the height to that of the longest explanation, so that the layout stays the same for all of them."""
        line = self.fontMetrics().lineSpacing()
        self.body.setVisible(not self._brief)
        self.setFixedHeight(7 * line + 10 if self._brief else self.illustration.height() + 8 * line + 18)

    def _write(self) -> None:
        control = self._control
        if control is None:
            return
        names = (f"<b>{control.intuitive}</b>", f"{control.rich_symbol} – {control.title}")
        if self._wording == "formula":
            names = (f"<b>{control.rich_symbol} – {control.title}</b>", control.intuitive)
        if self._brief:
            name = control.intuitive if self._wording == "intuitive" else control.title
            self.head.setText(f"<b>{name}</b> {control.rich_symbol}<br><small>{control.more}</small>")
            return
        self.head.setText("<br>".join((*names, f"<small>{control.span}</small>")))
        place = f" &nbsp;<small>({control.equation})</small>" if control.equation else ""
        formula = f"<p style='margin: 4px 0'>{control.formula}{place}</p>"
        self.body.setText(f"{control.meaning}{formula}{control.more} {control.acts}")

    def sizeHint(self) -> QSize:
        """A usual width; the height is fixed."""
        return QSize(280, self.height())


def tip(control: Control) -> str:
    """The full explanation of a control, as the tooltip of its row."""
    place = f" ({control.equation})" if control.equation else ""
    names = tr("{plain}: {title}").format(plain=control.intuitive, title=control.title)
    lines = (
        f"<b>{names}</b> {control.facts}",
        control.meaning,
        f"{control.formula}{place}",
        control.more,
        control.acts,
    )
    return "".join(f"<p>{line}</p>" for line in lines)
