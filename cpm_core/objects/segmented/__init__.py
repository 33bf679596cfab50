"""Segmented objects, as a session keeps them: clicks, boundary and class; uniting, splitting and painting them."""

from cpm_core.objects.segmented.areas import boundary_from_polygon as boundary_from_polygon
from cpm_core.objects.segmented.areas import lies_on as lies_on
from cpm_core.objects.segmented.areas import paint_boundary as paint_boundary
from cpm_core.objects.segmented.areas import polygon_from_boundary as polygon_from_boundary
from cpm_core.objects.segmented.areas import unite_objects as unite_objects
from cpm_core.objects.segmented.by_hand import Halves as Halves
from cpm_core.objects.segmented.by_hand import mark_gaps as mark_gaps
from cpm_core.objects.segmented.by_hand import redraw_boundary as redraw_boundary
from cpm_core.objects.segmented.by_hand import round_line as round_line
from cpm_core.objects.segmented.by_hand import split_object as split_object
from cpm_core.objects.segmented.by_hand import split_object_along as split_object_along
from cpm_core.objects.segmented.in_volumes import fill_between_slices as fill_between_slices
from cpm_core.objects.segmented.in_volumes import paint_voxels as paint_voxels
from cpm_core.objects.segmented.in_volumes import split_painted_object as split_painted_object
from cpm_core.objects.segmented.in_volumes import voxelize_brush as voxelize_brush
from cpm_core.objects.segmented.segmented_object import DEFAULT_CLASSES as DEFAULT_CLASSES
from cpm_core.objects.segmented.segmented_object import Click as Click
from cpm_core.objects.segmented.segmented_object import ObjectClass as ObjectClass
from cpm_core.objects.segmented.segmented_object import SegmentedObject as SegmentedObject
from cpm_core.objects.segmented.segmented_object import SegmentedObjects as SegmentedObjects
from cpm_core.objects.segmented.segmented_object import class_label as class_label
from cpm_core.objects.segmented.segmented_object import collect_points as collect_points
from cpm_core.objects.segmented.segmented_object import contours_from_object as contours_from_object
from cpm_core.objects.segmented.segmented_object import object_label as object_label
from cpm_core.objects.segmented.segmented_object import selection_from_object as selection_from_object
