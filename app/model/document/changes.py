"""Changes of a document in words: what has become what, and an icon for it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from app.model.document.document import Document
from app.model.parameters.controls import Control, choice_controls, controls, value_of
from app.model.text.language import from_core, tr, written
from cpm_core.numerics.types import Place
from cpm_core.shapes import (
    Barrier,
    Box,
    BoxGrid,
    BoxRegion,
    BoxThreshold,
    Charge,
    Circle,
    Ellipse,
    EnclosedRegion,
    EnclosingWall,
    Everywhere,
    Grid,
    Points,
    Polygon,
    PrismRegion,
    Region,
    Shape,
    Sphere,
    Stroke,
    Threshold,
    Wall,
)
from cpm_core.shapes.solids import Cuboid
from cpm_core.shapes.volume_limits import Enclosed

_ICONS: Mapping[type, str] = MappingProxyType(
    {
        Barrier: "barrier", Charge: "attract", Circle: "circle", Ellipse: "ellipse", Everywhere: "everywhere",
        Grid: "grid_area", Points: "points", Polygon: "polygon", Region: "region", Stroke: "stroke",
        Sphere: "circle", Threshold: "threshold", Box: "box", BoxRegion: "region", PrismRegion: "region",
        Wall: "barrier", EnclosedRegion: "region", EnclosingWall: "barrier", BoxGrid: "grid_area",
        BoxThreshold: "threshold",
    }
)  # fmt: skip
"""Icons of shapes, those of their tools."""

_PARTS = (("objects", "objects"), ("hand_edits", "edit_contours"), ("marks", "contours"), ("mode", "run"))
"""Other parts of a document and the icons of their changes."""


@dataclass(frozen=True, slots=True)
class ChangeInWords:
    """A change of a document: a line of text, and the name of its icon, empty for none."""

    text: str
    icon: str = ""


def in_words(name: str, before: Document, after: Document) -> ChangeInWords:
    """What has become what, and where; the name of the change if there is no short way to say it."""
    text = name[:1].upper() + name[1:]
    if before.parameters != after.parameters:
        return ChangeInWords(_parameter(before, after) or text, "slider")
    if before.shapes != after.shapes:
        return _shapes(text, before.shapes, after.shapes)
    icons = (icon for part, icon in _PARTS if getattr(before, part) != getattr(after, part))
    return ChangeInWords(text, next(icons, ""))


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


def _shapes(text: str, before: tuple[Shape, ...], after: tuple[Shape, ...]) -> ChangeInWords:
    added = [shape for shape in after if shape not in before]
    removed = [shape for shape in before if shape not in after]
    if len(added) == 1 and not removed:
        return ChangeInWords(_with_place(tr("{shape} drawn at {place}"), text, added[0]), _ICONS[type(added[0])])
    if len(removed) == 1 and not added:
        return ChangeInWords(_with_place(tr("{shape} at {place} deleted"), text, removed[0]), "bin")
    if len(removed) == len(added) == 1:
        moved = _place(removed[0]) != _place(added[0]) and _size(removed[0]) == _size(added[0])
        words = tr("{shape} moved to {place}") if moved else tr("{shape} at {place} changed")
        return ChangeInWords(_with_place(words, text, added[0]), _ICONS[type(added[0])])
    return ChangeInWords(text, "bin" if len(removed) > len(added) else "")


def _with_place(words: str, otherwise: str, shape: Shape) -> str:
    place = _place(shape)
    if place is None:
        return otherwise
    name = from_core(shape.title)
    return words.format(shape=name[:1].upper() + name[1:], place=", ".join(written(f"{at:.0f}") for at in place))


def _size(shape: Shape) -> object:
    """What stays the same while a shape is only moved."""
    if isinstance(shape, Circle | Sphere):
        return shape.radius
    if isinstance(shape, Ellipse):
        return shape.radii, shape.angle
    if isinstance(shape, Cuboid):
        return tuple(round(high - low, 6) for low, high in zip(shape.first, shape.last, strict=True))
    return shape.strength if isinstance(shape, Charge) else None


def _place(shape: Shape) -> Place | None:
    """Row and column of the center, or of the first corner; None for what is all over the image."""
    if isinstance(shape, Circle | Ellipse | Sphere | Cuboid | Enclosed):
        return shape.center
    if isinstance(shape, Charge):
        return shape.position
    if isinstance(shape, Everywhere):
        return None
    if isinstance(shape, PrismRegion | Wall):
        plane, row, col = shape.outline[0].tolist()
        return plane, row, col
    return (shape.positions if isinstance(shape, Points) else shape.points)[0]
