"""From particles to contours (section 3.4) and surfaces (section 5.4)."""

from cpm_core.reconstruction.by_hand.live_wire import LiveWire as LiveWire
from cpm_core.reconstruction.by_hand.live_wire import nearest_ridge as nearest_ridge
from cpm_core.reconstruction.by_hand.live_wire import on_ridge as on_ridge
from cpm_core.reconstruction.by_hand.operations import Contact as Contact
from cpm_core.reconstruction.by_hand.operations import carried_out as carried_out
from cpm_core.reconstruction.by_hand.operations import chain as chain
from cpm_core.reconstruction.by_hand.operations import connect as connect
from cpm_core.reconstruction.by_hand.operations import cut as cut
from cpm_core.reconstruction.by_hand.operations import deletion as deletion
from cpm_core.reconstruction.by_hand.operations import pull as pull
from cpm_core.reconstruction.by_hand.operations import wire_from as wire_from
from cpm_core.reconstruction.curve.crust import reconstruct_curve
from cpm_core.reconstruction.curve.pipeline import find_contours
from cpm_core.reconstruction.surface.from_points import reconstruct_surface

__all__ = ["find_contours", "reconstruct_curve", "reconstruct_surface"]
