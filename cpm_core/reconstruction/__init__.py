"""From particles to contours (section 3.4) and surfaces (section 5.4)."""

from cpm_core.reconstruction.by_hand.live_wire import LiveWire as LiveWire
from cpm_core.reconstruction.by_hand.live_wire import snap_path_to_ridge as snap_path_to_ridge
from cpm_core.reconstruction.by_hand.live_wire import snap_place_to_ridge as snap_place_to_ridge
from cpm_core.reconstruction.by_hand.operations import Contact as Contact
from cpm_core.reconstruction.by_hand.operations import chain_contours as chain_contours
from cpm_core.reconstruction.by_hand.operations import connect_by_path as connect_by_path
from cpm_core.reconstruction.by_hand.operations import cut_contour as cut_contour
from cpm_core.reconstruction.by_hand.operations import delete_stretch as delete_stretch
from cpm_core.reconstruction.by_hand.operations import live_wire_from as live_wire_from
from cpm_core.reconstruction.by_hand.operations import pull_contour as pull_contour
from cpm_core.reconstruction.curve.pipeline import find_contours

__all__ = ["find_contours"]
