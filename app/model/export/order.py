"""What is exported: which contours, whether open ones are closed, filled or as lines, and the size of a pixel."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

from app.model.document.document import Document
from app.model.document.objects import objects_result
from app.model.text.language import tr, written
from cpm_core.contours.result import Result
from cpm_core.contours.review import apply, reviewed, with_kept
from cpm_core.field.edge_map import edge_map
from cpm_core.formats import left_out
from cpm_core.image.geometry import Convention
from cpm_core.image.image import Image
from cpm_core.medial_axis.skeleton import Skeleton
from cpm_core.parameters import Parameters
from cpm_core.reconstruction.curve.closing import can_be_closed, close_contours

Closing = Literal["", "edges", "straight"]
"""How open contours are closed: not at all, along the edges of the image, or straight."""


@dataclass(frozen=True, eq=False, slots=True)
class Given:
    """What there is to export: the outcome of a run, document and image, and the numbers of the selected contours."""

    result: Result | None
    document: Document
    selected: frozenset[int] = frozenset()
    image: Image | None = None


@dataclass(frozen=True, slots=True)
class Source:
    """A choice of what is exported.

    Attributes
    ----------
    name, title : str
        Name in code, and label.
    of : callable
        What is written; None where there is nothing of the kind.
    needs_run : bool
        Whether it consists of contours of the run.
    without_run : callable
        Whether a document has something of the kind that needs no run.
    """

    name: str
    title: str
    of: Callable[[Given], Result | None]
    needs_run: bool = True
    without_run: Callable[[Document], bool] = lambda _: False


def _all(given: Given) -> Result | None:
    if given.result is None:
        return None
    marks = given.document.marks
    return apply(with_kept(given.result, marks), marks)


def _kept(given: Given) -> Result | None:
    if given.result is None:
        return None
    marks = given.document.marks
    result = with_kept(given.result, marks)
    kept = {one.index for one in reviewed(result.contours, marks) if one.verdict == "kept"}
    others = [contour for index, contour in enumerate(result.contours) if index not in kept]
    return _without(given, {contour.number for contour in others})


def _selected(given: Given) -> Result | None:
    found = _all(given)
    return None if found is None else _without(given, {one.number for one in found.contours} - given.selected)


def _without(given: Given, numbers: set[int]) -> Result | None:
    """All contours but those with some numbers, and the bridges on them."""
    found = _all(given)
    if found is None:
        return None
    left = tuple(contour for contour in found.contours if contour.number not in numbers)
    vertices = {tuple(point) for contour in left for point in contour.points.tolist()}
    bridges = tuple(bridge for bridge in found.bridges if tuple(bridge.points[1].tolist()) in vertices)
    return replace(found, contours=left, bridges=bridges)


def _objects(given: Given) -> Result | None:
    found = objects_result(given.document)
    if found is None or found.surface is None:
        return found
    return replace(found, image=given.image)  # which says where a volume lies in space


SOURCES: tuple[Source, ...] = (
    Source("all", tr("All that are not rejected"), _all),
    Source("kept", tr("Kept ones only"), _kept),
    Source("selected", tr("The selection"), _selected),
    Source(
        "objects",
        tr("Objects"),
        _objects,
        needs_run=False,
        without_run=lambda document: any(not item.hidden for item in document.objects.items),
    ),
)
"""What can be exported, in the order shown."""


@dataclass(frozen=True, slots=True)
class ExportOrder:
    """How contours are exported.

    Attributes
    ----------
    source : str
        Name of one of `SOURCES`.
    selected : frozenset of int
        Numbers of the selected contours.
    closing : {"", "edges", "straight"}
        How open contours are closed whose ends are near each other.
    outlines : bool
        Whether masks hold lines in place of filled contours.
    spacing : float
        Size of a pixel in `unit`; 0 for that of the image.
    unit : str
        Unit of `spacing`.
    space : {"LPS", "RAS"}
        Where the coordinates of a surface point.
    """

    source: str = "all"
    selected: frozenset[int] = frozenset()
    closing: Closing = ""
    outlines: bool = False
    spacing: float = 0.0
    unit: str = ""
    space: Convention = "LPS"


def can_be_exported(document: Document) -> bool:
    """Whether a document has something to export that needs no run."""
    return any(source.without_run(document) for source in SOURCES)


def source_of(order: ExportOrder) -> Source:
    """The source of an order."""
    return next(source for source in SOURCES if source.name == order.source)


def chosen(
    found: Result | Skeleton | None, document: Document, order: ExportOrder, image: Image | None = None
) -> Result | Skeleton:
    """What is exported, before open contours are closed; ValueError where there is nothing of the kind."""
    if isinstance(found, Skeleton):
        result: Result | Skeleton | None = found
    else:
        result = source_of(order).of(Given(found, document, order.selected, image))
    if result is None:
        raise ValueError(tr("There is nothing to export yet: let the particles run first."))
    if order.spacing > 0.0:
        result = replace(result, spacing=(order.spacing,) * 2, unit=order.unit or None)
    return result


def closed(result: Result | Skeleton, order: ExportOrder, image: Image, parameters: Parameters) -> Result | Skeleton:
    """The result with open contours closed as ordered."""
    if not order.closing or isinstance(result, Skeleton) or not any(map(can_be_closed, result.contours)):
        return result
    gray = image.gray(parameters.channel)
    return close_contours(result, edge_map(gray, parameters.smoothing) if order.closing == "edges" else None)


@dataclass(frozen=True, slots=True)
class Account:
    """How many contours are written and left out, and how many of those written were open and have been closed.

    `objects` is the number of
    objects whose boundaries the contours are, 0 for other contours. `triangles` is the number of those of the
    surface that a run in a volume has found, 0 for an image.
    """

    written: int
    left_out: int
    bridged: int
    objects: int = 0
    triangles: int = 0


def account(before: Result | Skeleton, after: Result | Skeleton, suffix: str, order: ExportOrder) -> Account:
    """What a file with a suffix holds of a result `before` and `after` open contours were closed."""
    missing = left_out(after, suffix, outlines=order.outlines)
    bridged = sum(one.closed for one in after.contours) - sum(one.closed for one in before.contours)
    whole = isinstance(after, Result) and order.source == "objects"
    objects = len({one.group for one in after.contours}) if whole else 0
    surface = after.surface if isinstance(after, Result) else None
    triangles = 0 if surface is None else len(surface.faces)
    if surface is not None and surface.numbers is not None:
        objects = len(set(surface.numbers.tolist()))
    return Account(len(after.contours) - missing, missing, bridged, objects, triangles)


def in_words(counts: Account) -> str:
    """What is written and what is left out, in one line."""
    if counts.objects:
        parts = [tr("1 object") if counts.objects == 1 else tr("{count} objects").format(count=counts.objects)]
    elif counts.triangles:
        parts = []
    else:
        parts = [tr("1 contour") if counts.written == 1 else tr("{count} contours").format(count=counts.written)]
    if counts.triangles:
        parts.append(tr("a surface of {count} triangles").format(count=written(f"{counts.triangles:,}")))
    if counts.bridged:
        parts.append(tr("{count} of them closed for the export").format(count=counts.bridged))
    if counts.left_out:
        parts.append(tr("{count} open ones left out").format(count=counts.left_out))
    return ", ".join(parts)
