"""Objects: the plane is cut into faces along contours, and an object is a set of faces that clicks choose.

A volume is cut by closed surfaces into bodies, and an object is a set of these (`faces.space`).
"""

from cpm_core.objects.objects_result import boundaries_result as boundaries_result
from cpm_core.objects.objects_result import objects_result
from cpm_core.objects.partition import EVERYWHERE as EVERYWHERE
from cpm_core.objects.partition import Partition, partition
from cpm_core.objects.selection import Selection
from cpm_core.objects.similar import similar
from cpm_core.objects.volume_partition import VolumePartition, VolumeSelection

__all__ = ["Partition", "Selection", "VolumePartition", "VolumeSelection", "objects_result", "partition", "similar"]
