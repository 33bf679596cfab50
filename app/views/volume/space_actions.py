"""What the menu of the view in space offers: where it is seen from, what is shown, and its picture."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

from PySide6.QtWidgets import QApplication

from app.model.state.situation import Condition, Situation, has_volume
from app.model.text.language import tr
from app.model.volume.slices import AXES, ends_of
from app.session.session import Session
from app.session.signals import EXPORTING
from app.views.volume.space_bar import PARTS
from app.views.volume.space_panel import SpacePanel
from app.views.widgets.actions import ActionSpec

_MENU = "View>" + tr("In s&pace")

_FROM = {"A": tr("From the &front"), "P": tr("From the &front"), "L": tr("From the &left side"),
         "R": tr("From the &left side"), "S": tr("From &below"), "I": tr("From &below")}  # fmt: skip
"""Where a patient is seen from along an axis that ends at a letter, as slices across it are."""


def specs(panel: SpacePanel, session: Session) -> Iterator[ActionSpec]:
    """The actions of the view in space."""
    view, bar = panel.view, panel.bar
    yield ActionSpec("space_whole", _MENU, tr("&Whole volume"),
                     tr("See the whole volume from where it is seen first (0 in the view)."), view.show_all,
                     when=has_volume)  # fmt: skip
    for axis, name in enumerate(AXES):
        yield ActionSpec(f"space_along_{axis}", _MENU, tr("Along the &{axis}").format(axis=name),
                         tr("Look at the volume as at its slices across the axis: {axis} ({key} in the view).")
                         .format(axis=name, key=axis + 1), partial(view.look_along, axis), when=has_volume,
                         worded=_worded(session, axis))  # fmt: skip
    for name, (title, tip) in PARTS.items():
        yield ActionSpec(f"space_{name}", _MENU, title, tip, bar.checks[name].toggle, gap=name == "particles",
                         when=has_volume, holds=_is_shown(panel, name))  # fmt: skip
    yield ActionSpec("copy_space", _MENU, tr("&Copy picture"),
                     tr("Copy what the view in space shows to the clipboard."), partial(_copy, panel, session),
                     gap=True, when=has_volume)  # fmt: skip


def _worded(session: Session, axis: int) -> Callable[[Situation], str]:
    """The text of a view along an axis: in words of a patient where the volume tells how it lies."""

    def text(_: Situation) -> str:
        image = session.scene.image
        if image is None or image.geometry is None or image.ndim != 3:
            return tr("Along the &{axis}").format(axis=AXES[axis])
        return _FROM[ends_of(image)[axis][1]]

    return text


def _is_shown(panel: SpacePanel, name: str) -> Condition:
    return lambda _: panel.bar.checks[name].isChecked()


def _copy(panel: SpacePanel, session: Session) -> None:
    QApplication.clipboard().setImage(panel.view.picture())
    session.say(tr("The picture in space is on the clipboard."), topic=EXPORTING)
