"""Objects: the plane is cut into faces along contours, and an object is a set of faces that clicks choose."""

from cpm_core.objects.objects_result import objects_result
from cpm_core.objects.partition import Partition, partition
from cpm_core.objects.selection import Selection
from cpm_core.objects.similar import similar

__all__ = ["Partition", "Selection", "objects_result", "partition", "similar"]
