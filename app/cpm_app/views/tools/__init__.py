"""The tools with which the pointer edits the drawing."""

from __future__ import annotations

from cpm_app.views.tools.brush_tools import EraserTool, SprayTool
from cpm_app.views.tools.gesture_tools import AttractTool, CircleTool, EllipseTool, PointTool, RepelTool
from cpm_app.views.tools.mend import MendTool
from cpm_app.views.tools.objects import ObjectTool
from cpm_app.views.tools.outline import OutlineTool
from cpm_app.views.tools.path import BarrierTool, GridTool, PolygonTool, RegionTool, StrokeTool, ThresholdTool
from cpm_app.views.tools.select import SelectTool
from cpm_app.views.tools.split import SplitTool
from cpm_app.views.tools.tool import Tool

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
"""All tools in display order, those of a group next to each other."""
