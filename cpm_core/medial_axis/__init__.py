"""The medial axis of what lies between edges: boundary, Voronoi diagram, sides, pruning, disks."""

from cpm_core.medial_axis.axis import Axis, medial_axis
from cpm_core.medial_axis.boundary import Boundary, find_boundary
from cpm_core.medial_axis.disks import along, covered
from cpm_core.medial_axis.pruning import prune
from cpm_core.medial_axis.sides import within_objects
from cpm_core.medial_axis.smoothed_step import half_width

__all__ = [
    "Axis",
    "Boundary",
    "along",
    "covered",
    "find_boundary",
    "half_width",
    "medial_axis",
    "prune",
    "within_objects",
]
