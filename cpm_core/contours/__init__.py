"""Contours: their points, measurements, and agreement with one another and with a ground truth."""

from cpm_core.contours.agreement import DEFAULT_TOLERANCE as DEFAULT_TOLERANCE
from cpm_core.contours.agreement import Agreement as Agreement
from cpm_core.contours.agreement import ObjectCounts as ObjectCounts
from cpm_core.contours.agreement import compare_boundaries as compare_boundaries
from cpm_core.contours.agreement import distances_to_contours as distances_to_contours
from cpm_core.contours.contour import assign_numbers as assign_numbers
from cpm_core.contours.contour import build_path_tree as build_path_tree
from cpm_core.contours.contour import select_bridges_on as select_bridges_on
from cpm_core.contours.graph import Graph as Graph
from cpm_core.contours.ground_truth import truth_from_contours as truth_from_contours
from cpm_core.contours.ground_truth import truth_from_mask as truth_from_mask
from cpm_core.contours.measurements import Measures as Measures
from cpm_core.contours.measurements import compute_centroid as compute_centroid
from cpm_core.contours.surface import extract_object_surface as extract_object_surface
from cpm_core.contours.surface import join_surfaces as join_surfaces
from cpm_core.contours.surface import label_voxels as label_voxels
from cpm_core.contours.surface import slice_surface as slice_surface
