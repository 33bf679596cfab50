"""Segmented objects, as a session keeps them: clicks, boundary and class; uniting, splitting and painting them."""

from cpm_core.objects.segmented.areas import lies_on as lies_on
from cpm_core.objects.segmented.areas import painted as painted
from cpm_core.objects.segmented.areas import union as union
from cpm_core.objects.segmented.by_hand import Halves as Halves
from cpm_core.objects.segmented.by_hand import line_of as line_of
from cpm_core.objects.segmented.by_hand import outlined as outlined
from cpm_core.objects.segmented.by_hand import redrawn as redrawn
from cpm_core.objects.segmented.by_hand import split as split
from cpm_core.objects.segmented.by_hand import split_along as split_along
from cpm_core.objects.segmented.in_volumes import between_slices as between_slices
from cpm_core.objects.segmented.in_volumes import brush_in as brush_in
from cpm_core.objects.segmented.in_volumes import painted_in as painted_in
from cpm_core.objects.segmented.in_volumes import split_in_volume as split_in_volume
from cpm_core.objects.segmented.segmented_object import CLASSES as CLASSES
from cpm_core.objects.segmented.segmented_object import Click as Click
from cpm_core.objects.segmented.segmented_object import ObjectClass as ObjectClass
from cpm_core.objects.segmented.segmented_object import SegmentedObject as SegmentedObject
from cpm_core.objects.segmented.segmented_object import SegmentedObjects as SegmentedObjects
from cpm_core.objects.segmented.segmented_object import contours_of as contours_of
from cpm_core.objects.segmented.segmented_object import places_of as places_of
from cpm_core.objects.segmented.segmented_object import selection_of as selection_of
