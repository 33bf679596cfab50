"""The tools with which the pointer edits the drawing."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import chain

from cpm_app.model.text.language import tr
from cpm_app.views.tools.brush_tools import EraserTool, SprayTool
from cpm_app.views.tools.gesture_tools import AttractTool, CircleTool, EllipseTool, PointTool, RepelTool
from cpm_app.views.tools.measure import AngleTool, OvalTool, RulerTool
from cpm_app.views.tools.mend import MendTool
from cpm_app.views.tools.objects import ObjectTool
from cpm_app.views.tools.outline import OutlineTool
from cpm_app.views.tools.path import BarrierTool, GridTool, PolygonTool, RegionTool, StrokeTool, ThresholdTool
from cpm_app.views.tools.select import SelectTool
from cpm_app.views.tools.split import SplitTool
from cpm_app.views.tools.tool import Tool

AUTO_GROUP = tr("Auto")
"""Group of the starts that need no drawing; it has no tools."""

TOOLS_BY_GROUP: Mapping[str, tuple[type[Tool], ...]] = {
    tr("Objects"): (ObjectTool, OutlineTool),
    tr("Select"): (SelectTool, EraserTool),
    tr("Measure"): (RulerTool, AngleTool, OvalTool),
    tr("Mend"): (MendTool, SplitTool),
    tr("Circle"): (CircleTool, EllipseTool, PolygonTool),
    tr("Stroke"): (StrokeTool, PointTool, SprayTool),
    tr("Area"): (GridTool, ThresholdTool),
    AUTO_GROUP: (),
    tr("Limit"): (RegionTool, BarrierTool),
    tr("Charge"): (AttractTool, RepelTool),
}
"""All tools in display order, by the title of their group."""

TOOLS = tuple(chain(*TOOLS_BY_GROUP.values()))
