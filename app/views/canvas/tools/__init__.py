"""The tools by which the pointer edits the drawing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from app.model.text.language import tr
from app.session.features.contour_review import ContourReview
from app.session.session import Session
from app.views.canvas.layers.drawn.drawing import DrawingLayer
from app.views.canvas.tools.charge import STRENGTH, ChargeTool
from app.views.canvas.tools.contours import ContourTool
from app.views.canvas.tools.dragged import CircleTool, EllipseTool
from app.views.canvas.tools.path import BARRIER, GRID, POLYGON, REGION, STROKE, THRESHOLD, PathKind, PathTool
from app.views.canvas.tools.points import PointTool
from app.views.canvas.tools.ringed import EraserTool, SprayTool
from app.views.canvas.tools.select import SelectTool
from app.views.canvas.tools.tool import Tool

Maker = Callable[[Session, ContourReview, DrawingLayer, Callable[[], None]], Tool]

SELECT, START, LIMIT, CHARGE, CONTOUR = tr("Select"), tr("Start"), tr("Limit"), tr("Charge"), tr("Contour")
"""What tools are for."""


@dataclass(frozen=True, slots=True)
class ToolEntry:
    """A tool as it stands in palette and menu.

    Attributes
    ----------
    name : str
        What it is called in code; also the name of its icon.
    text : str
        Text in the menu.
    shortcut : str
        Its key.
    tip : str
        One sentence on what it does.
    group : str
        What it is for; tools of one group stand together.
    make : callable
        Makes it, of session and review of contours, the layer that shows drafts, and what is to be called when its
        advice has changed.
    """

    name: str
    text: str
    shortcut: str
    tip: str
    group: str
    make: Maker


def _plain(kind: Callable[[Session], Tool]) -> Maker:
    return lambda session, review, drawing, advised: kind(session)


def _ringed(kind: Callable[[Session, DrawingLayer], Tool]) -> Maker:
    return lambda session, review, drawing, advised: kind(session, drawing)


def _path(kind: PathKind) -> Maker:
    return lambda session, review, drawing, advised: PathTool(session, kind, drawing, advised)


def _charge(name: str, strength: float) -> Maker:
    return _plain(partial(ChargeTool, name=name, strength=strength))


TOOLS: tuple[ToolEntry, ...] = (
    ToolEntry(
        "select",
        tr("&Select tool"),
        "S",
        tr("Select, move and reshape what is drawn."),
        SELECT,
        _plain(SelectTool),
    ),
    ToolEntry(
        "eraser",
        tr("&Eraser"),
        "E",
        tr("Drag to erase points, shapes and particles; < and > change its ring."),
        SELECT,
        _ringed(EraserTool),
    ),
    ToolEntry(
        "circle",
        tr("&Circle tool"),
        "C",
        tr("Drag from the center to draw a circle."),
        START,
        _plain(CircleTool),
    ),
    ToolEntry(
        "ellipse",
        tr("E&llipse tool"),
        "L",
        tr("Drag a box to draw an ellipse; Shift makes it round, Ctrl draws it from its center."),
        START,
        _plain(EllipseTool),
    ),
    ToolEntry(
        "polygon",
        tr("P&olygon tool"),
        "O",
        tr("Click corners, or drag, along a closed line to start from."),
        START,
        _path(POLYGON),
    ),
    ToolEntry(
        "stroke",
        tr("S&troke tool"),
        "T",
        tr("Drag, or click corners, where to start."),
        START,
        _path(STROKE),
    ),
    ToolEntry(
        "points",
        tr("&Point tool"),
        "P",
        tr("Click to place a point."),
        START,
        _plain(PointTool),
    ),
    ToolEntry(
        "spray",
        tr("Spra&y tool"),
        "Y",
        tr("Drag to scatter points; < and > change the ring."),
        START,
        _ringed(SprayTool),
    ),
    ToolEntry(
        "grid_area",
        tr("&Grid tool"),
        "G",
        tr("Draw around what is to be covered with an even grid; < and > change its spacing."),
        START,
        _path(GRID),
    ),
    ToolEntry(
        "threshold",
        tr("T&hreshold tool"),
        "H",
        tr("Draw around where to start on strong edges; < and > change how strong."),
        START,
        _path(THRESHOLD),
    ),
    ToolEntry(
        "region",
        tr("Region of &interest tool"),
        "I",
        tr("Drag, or click corners, around what particles are to stay in."),
        LIMIT,
        _path(REGION),
    ),
    ToolEntry(
        "barrier",
        tr("&Barrier tool"),
        "B",
        tr("Drag, or click corners, where no particle is to cross."),
        LIMIT,
        _path(BARRIER),
    ),
    ToolEntry(
        "attract",
        tr("&Attracting charge"),
        "A",
        tr("Drop a charge that draws particles near it, and drag it while they run; < and > change its strength."),
        CHARGE,
        _charge("attract", STRENGTH),
    ),
    ToolEntry(
        "repel",
        tr("Repelling char&ge"),
        "D",
        tr("Drop a charge that drives particles away, and drag it while they run; < and > change its strength."),
        CHARGE,
        _charge("repel", -STRENGTH),
    ),
    ToolEntry(
        "contours",
        tr("C&ontour tool"),
        "V",
        tr("Click a contour to select it; X rejects, K keeps, Enter names it."),
        CONTOUR,
        lambda session, review, drawing, advised: ContourTool(review),
    ),
)
"""All tools, in the order shown: what selects, what starts, what limits and what acts on particles stand together."""
