"""The shapes that a user draws: starts, which give particles; limits, which hold them back; placed charges; measures.

A shape is frozen and checks its values. It can be moved, resized and reshaped by its handles, and gives the distance of
a position. Shapes do not depend on the window. A new shape needs a class and an entry in the unions below; session
files then keep its fields, and a start gives particles on the command line as well. A limit also needs an entry in
`document_shapes.collect_regions`. To draw it in the window add a tool (`cpm_app.views.tools`), an item in the layer of
drawn shapes (`cpm_app.views.layers.annotations`) and its texts (`cpm_app.model.state.resolve`).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import get_args

from cpm_core.shapes.areas import Grid, Threshold
from cpm_core.shapes.charge import Charge
from cpm_core.shapes.ellipse import Circle, Ellipse
from cpm_core.shapes.everywhere import Everywhere
from cpm_core.shapes.lines import Barrier, Points, Polygon, PolygonRegion, Stroke
from cpm_core.shapes.measures import Measure
from cpm_core.shapes.solids import Box, BoxGrid, BoxRegion, BoxThreshold, Sphere
from cpm_core.shapes.volume_limits import EnclosedRegion, EnclosingWall, PrismRegion, Wall

Start = (
    Circle | Ellipse | Polygon | Stroke | Points | Grid | Threshold | Everywhere | Sphere | Box | BoxGrid | BoxThreshold
)
"""Shapes that give particles; spheres and all boxes lie in volumes, polygons, strokes and points in either."""

Interest = PolygonRegion | BoxRegion | PrismRegion | EnclosedRegion
"""Regions of interest, the first in images."""

Limit = PolygonRegion | Barrier | BoxRegion | PrismRegion | Wall | EnclosedRegion | EnclosingWall
"""Shapes that hold particles back; the first two in images."""

Shape = Start | Limit | Charge | Measure

SHAPES_BY_NAME: Mapping[str, type[Shape]] = {
    "region" if kind is PolygonRegion else kind.__name__.lower(): kind for kind in get_args(Shape)
}
"""Shapes by the names that files have for them."""
