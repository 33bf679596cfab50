"""The tools by which the pointer edits the drawing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from app.model.language import tr
from app.session.session import Session
from app.views.layers.drawing import DrawingLayer
from app.views.tools.circle import CircleTool
from app.views.tools.contours import ContourTool
from app.views.tools.path import BARRIER, REGION, STROKE, PathTool
from app.views.tools.points import PointTool
from app.views.tools.select import SelectTool
from app.views.tools.tool import Tool


@dataclass(frozen=True, slots=True)
class ToolEntry:
    """A tool as it stands in palette and menu.

    Attributes
    ----------
    name : str
        What it is called in code; also the name of its icon.
    text : str
        Text in the menu.
    short : str
        Text on its button.
    shortcut : str
        Its key.
    tip : str
        One sentence on what it does.
    make : callable
        Makes it, of the session, the layer that shows drafts, and what is to be told when its advice has changed.
    gap : bool
        Whether a line is drawn above it.
    """

    name: str
    text: str
    short: str
    shortcut: str
    tip: str
    make: Callable[[Session, DrawingLayer, Callable[[], None]], Tool]
    gap: bool = False


TOOLS: tuple[ToolEntry, ...] = (
    ToolEntry(
        "select",
        tr("&Select tool"),
        tr("Select"),
        "S",
        tr("Select, move and reshape what is drawn."),
        lambda session, drawing, advised: SelectTool(session),
    ),
    ToolEntry(
        "circle",
        tr("&Circle tool"),
        tr("Circle"),
        "C",
        tr("Drag from the centre to draw a circle."),
        lambda session, drawing, advised: CircleTool(session),
        gap=True,
    ),
    ToolEntry(
        "points",
        tr("&Point tool"),
        tr("Points"),
        "P",
        tr("Click to place a point."),
        lambda session, drawing, advised: PointTool(session),
    ),
    ToolEntry(
        "stroke",
        tr("S&troke tool"),
        tr("Stroke"),
        "T",
        tr("Drag, or click corners, where to start."),
        lambda session, drawing, advised: PathTool(session, STROKE, drawing, advised),
    ),
    ToolEntry(
        "region",
        tr("Region of &interest tool"),
        tr("Region"),
        "I",
        tr("Drag, or click corners, around what particles are to stay in."),
        lambda session, drawing, advised: PathTool(session, REGION, drawing, advised),
        gap=True,
    ),
    ToolEntry(
        "barrier",
        tr("&Barrier tool"),
        tr("Barrier"),
        "B",
        tr("Drag, or click corners, where no particle is to cross."),
        lambda session, drawing, advised: PathTool(session, BARRIER, drawing, advised),
    ),
    ToolEntry(
        "contours",
        tr("C&ontour tool"),
        tr("Contours"),
        "V",
        tr("Click a contour to select it; X rejects, K keeps, Enter names it."),
        lambda session, drawing, advised: ContourTool(session),
        gap=True,
    ),
)
"""All tools, in the order shown: what selects, what starts and what limits stand together."""
