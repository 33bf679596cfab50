"""Objects: what points, scribbles, boxes and lassos select in an image, and bodies in a volume."""

from cpm_core.numerics.grids import compute_iou as compute_iou
from cpm_core.objects.partition import Partition
from cpm_core.objects.partition import partition_without_run as partition_without_run
from cpm_core.objects.selection import Selection
from cpm_core.objects.volume_partition import VolumePartition

__all__ = ["Partition", "Selection", "VolumePartition"]
