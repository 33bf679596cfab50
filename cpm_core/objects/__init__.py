"""Objects: what points, scribbles, boxes and lassos select in an image, and bodies in a volume."""

from cpm_core.objects.objects_result import boundaries_result as boundaries_result
from cpm_core.objects.objects_result import objects_result
from cpm_core.objects.partition import EVERYWHERE_PARAMETERS as EVERYWHERE_PARAMETERS
from cpm_core.objects.partition import Partition, partition
from cpm_core.objects.partition import partition_without_run as partition_without_run
from cpm_core.objects.select import select, select_all
from cpm_core.objects.selection import Selection
from cpm_core.objects.selection import compute_iou as compute_iou
from cpm_core.objects.view import NotebookView, notebook_view
from cpm_core.objects.volume_partition import VolumePartition, VolumeSelection

__all__ = [
    "NotebookView",
    "Partition",
    "Selection",
    "VolumePartition",
    "VolumeSelection",
    "notebook_view",
    "objects_result",
    "partition",
    "select",
    "select_all",
]
