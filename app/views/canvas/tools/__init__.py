"""The tools with which the pointer edits the drawing."""

from __future__ import annotations

from app.views.canvas.tools.brush_tools import EraserTool, SprayTool
from app.views.canvas.tools.drawn import AttractTool, CircleTool, EllipseTool, PointTool, RepelTool
from app.views.canvas.tools.mend import MendTool
from app.views.canvas.tools.objects import ObjectTool
from app.views.canvas.tools.outline import OutlineTool
from app.views.canvas.tools.path import BarrierTool, GridTool, PolygonTool, RegionTool, StrokeTool, ThresholdTool
from app.views.canvas.tools.select import SelectTool
from app.views.canvas.tools.split import SplitTool
from app.views.canvas.tools.tool import Tool

TOOLS: tuple[type[Tool], ...] = (
    ObjectTool,
    OutlineTool,
    SelectTool,
    EraserTool,
    MendTool,
    SplitTool,
    CircleTool,
    EllipseTool,
    PolygonTool,
    StrokeTool,
    PointTool,
    SprayTool,
    GridTool,
    ThresholdTool,
    RegionTool,
    BarrierTool,
    AttractTool,
    RepelTool,
)
"""All tools in the order shown, those of one group next to each other."""
