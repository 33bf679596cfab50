"""The medial axis between edges: boundary, Voronoi diagram, foreground, polarity, strips, pruning, disks."""

from cpm_core.medial_axis.outlines import SkeletonTarget as SkeletonTarget
from cpm_core.medial_axis.skeleton_method import SkeletonMethod as SkeletonMethod
