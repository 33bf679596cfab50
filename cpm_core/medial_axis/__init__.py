"""The medial axis of what lies between edges: boundary, Voronoi diagram, sides, pruning, disks."""

from cpm_core.medial_axis.blur_correction import half_width
from cpm_core.medial_axis.boundary import Boundary, find_boundary
from cpm_core.medial_axis.disks import along, covered
from cpm_core.medial_axis.foreground import within_objects
from cpm_core.medial_axis.medial_axis import Axis, medial_axis
from cpm_core.medial_axis.pruning import prune

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
