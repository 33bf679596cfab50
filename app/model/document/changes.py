"""Changes of a document in words: what has become what, and an icon for it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from app.model.document.document import Document
from app.model.parameters.controls import Control, choice_controls, controls, value_of
from app.model.text.language import tr, written
from cpm_core.shapes import Charge, Everywhere, Interest, Limit, Points, Shape

_ICONS: tuple[tuple[Any, str], ...] = (
    (Charge, "attract"), (Interest, "region"), (Limit, "barrier"), (Everywhere, "everywhere"), (Points, "points"),
    (object, "circle"),
)  # fmt: skip
"""Icons of shapes, those of their tools; the first kind that a shape is of counts."""

_PARTS = (("objects", "objects"), ("hand_edits", "edit_contours"), ("marks", "contours"), ("mode", "run"))
"""Other parts of a document and the icons of their changes."""


@dataclass(frozen=True, slots=True)
class ChangeInWords:
    """A change of a document: a line of text, and the name of its icon, empty for none."""

    text: str
    icon: str = ""


def described(name: str, before: Document, after: Document) -> ChangeInWords:
    """What has become what; the name of the change if there is no short way to say it."""
    text = name[:1].upper() + name[1:]
    if before.parameters != after.parameters:
        return ChangeInWords(_parameter(before, after) or text, "slider")
    if before.shapes != after.shapes:
        return ChangeInWords(text, _icon_of_shapes(before.shapes, after.shapes))
    icons = (icon for part, icon in _PARTS if getattr(before, part) != getattr(after, part))
    return ChangeInWords(text, next(icons, ""))


def _icon_of_shapes(before: tuple[Shape, ...], after: tuple[Shape, ...]) -> str:
    """The icon of what was drawn or changed, or a bin."""
    added = [shape for shape in after if shape not in before]
    if not added:
        return "bin"
    return next(icon for kind, icon in _ICONS if isinstance(added[0], kind))


def _parameter(before: Document, after: Document) -> str:
    """The values of the only parameter that differs; empty if there are several."""
    old, new = before.parameters, after.parameters
    lines = [
        tr("{name} {old} → {new}").format(name=control.title, old=_shown(control, one), new=_shown(control, other))
        for control in controls()
        if not _same(one := value_of(old, control.name), other := value_of(new, control.name))
    ]
    for choice in choice_controls():
        titles = {value: title for value, title, _ in choice.choices}
        one, other = (titles[str(value_of(of, choice.name))] for of in (old, new))
        if one != other:
            lines.append(tr("{name} {old} → {new}").format(name=choice.title, old=one, new=other))
    return lines[0] if len(lines) == 1 else ""


def _same(one: float | str, other: float | str) -> bool:
    if isinstance(one, str) or isinstance(other, str):
        return one == other
    return math.isclose(one, other, rel_tol=1e-9, abs_tol=1e-12)


def _shown(control: Control, value: float | str) -> str:
    if isinstance(value, str):
        return tr("auto")
    return dict(control.words).get(value) or written(f"{value:.{control.decimals}f}")
