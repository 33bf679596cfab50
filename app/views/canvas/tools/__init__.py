"""The tools with which the pointer edits the drawing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from app.model.text.language import tr
from app.views.canvas.tools.brush_tools import BrushTool, EraserTool, SprayTool
from app.views.canvas.tools.contours import ContourTool
from app.views.canvas.tools.drawn import AttractTool, CircleTool, EllipseTool, PointTool, RepelTool
from app.views.canvas.tools.edit_contours import EditContoursTool
from app.views.canvas.tools.objects import ObjectTool
from app.views.canvas.tools.outline import OutlineTool
from app.views.canvas.tools.path import BARRIER, GRID, POLYGON, REGION, STROKE, THRESHOLD, PathKind, PathTool
from app.views.canvas.tools.select import SelectTool
from app.views.canvas.tools.tool import Tool, ToolContext

OBJECT, SELECT, START = tr("Objects"), tr("Select"), tr("Start")
LIMIT, CHARGE, CONTOUR = tr("Limit"), tr("Charge"), tr("Contour")
"""Groups of tools by purpose."""


@dataclass(frozen=True, slots=True)
class ToolEntry:
    """A tool in palette and menu.

    Attributes
    ----------
    make : callable
        Makes the tool from its context.
    text, shortcut, group : str
        Text in the menu, key, and group.
    name, tip : str
        Name in code, which is also the name of the icon; one sentence on what the tool does.
    """

    make: Callable[[ToolContext], Tool]
    text: str
    shortcut: str
    group: str
    name: str
    tip: str


def _entry(made: type[Tool] | PathKind, text: str, shortcut: str, group: str) -> ToolEntry:
    make = partial(PathTool, kind=made) if isinstance(made, PathKind) else made
    return ToolEntry(make, text, shortcut, group, made.name, made.tip)


TOOLS: tuple[ToolEntry, ...] = (
    _entry(ObjectTool, tr("Select ob&jects"), "W", OBJECT),
    _entry(SelectTool, tr("&Select tool"), "S", SELECT),
    _entry(EraserTool, tr("&Eraser"), "E", SELECT),
    _entry(CircleTool, tr("&Circle tool"), "C", START),
    _entry(EllipseTool, tr("E&llipse tool"), "L", START),
    _entry(POLYGON, tr("P&olygon tool"), "O", START),
    _entry(STROKE, tr("S&troke tool"), "T", START),
    _entry(PointTool, tr("&Point tool"), "P", START),
    _entry(SprayTool, tr("Spra&y tool"), "Y", START),
    _entry(GRID, tr("&Grid tool"), "G", START),
    _entry(THRESHOLD, tr("T&hreshold tool"), "H", START),
    _entry(REGION, tr("Region of &interest tool"), "I", LIMIT),
    _entry(BARRIER, tr("&Barrier tool"), "B", LIMIT),
    _entry(AttractTool, tr("&Attracting charge"), "A", CHARGE),
    _entry(RepelTool, tr("Repelling char&ge"), "D", CHARGE),
    _entry(ContourTool, tr("C&ontour tool"), "V", CONTOUR),
    _entry(EditContoursTool, tr("Edit contours by han&d"), "J", CONTOUR),
    _entry(OutlineTool, tr("O&utline tool"), "U", CONTOUR),
    _entry(BrushTool, tr("Paint objects &with a brush"), "Z", CONTOUR),
)
"""All tools in the order shown, those of one group next to each other."""
