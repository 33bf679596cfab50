"""Segmented objects, as a session keeps them: clicks, boundary and class; uniting, splitting and painting them."""

from cpm_core.objects.segmented.areas import lies_on as lies_on
from cpm_core.objects.segmented.areas import paint_boundary as painted
from cpm_core.objects.segmented.areas import unite_objects as union
from cpm_core.objects.segmented.by_hand import Halves as Halves
from cpm_core.objects.segmented.by_hand import round_line as line_of
from cpm_core.objects.segmented.by_hand import mark_gaps as outlined
from cpm_core.objects.segmented.by_hand import redraw_boundary as redrawn
from cpm_core.objects.segmented.by_hand import split_object as split
from cpm_core.objects.segmented.by_hand import split_object_along as split_along
from cpm_core.objects.segmented.in_volumes import fill_between_slices as between_slices
from cpm_core.objects.segmented.in_volumes import voxelize_brush as brush_in
from cpm_core.objects.segmented.in_volumes import paint_voxels as painted_in
from cpm_core.objects.segmented.in_volumes import split_painted_object as split_in_volume
from cpm_core.objects.segmented.segmented_object import DEFAULT_CLASSES as CLASSES
from cpm_core.objects.segmented.segmented_object import Click as Click
from cpm_core.objects.segmented.segmented_object import ObjectClass as ObjectClass
from cpm_core.objects.segmented.segmented_object import SegmentedObject as SegmentedObject
from cpm_core.objects.segmented.segmented_object import SegmentedObjects as SegmentedObjects
from cpm_core.objects.segmented.segmented_object import contours_from_object as contours_of
from cpm_core.objects.segmented.segmented_object import collect_points as places_of
from cpm_core.objects.segmented.segmented_object import selection_from_object as selection_of
