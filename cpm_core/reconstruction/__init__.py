"""From particles to contours (section 3.4) and surfaces (section 5.4)."""

from cpm_core.reconstruction.by_hand.live_wire import LiveWire as LiveWire
from cpm_core.reconstruction.by_hand.live_wire import snap_path_to_ridge as snap_path_to_ridge
from cpm_core.reconstruction.by_hand.live_wire import snap_place_to_ridge as snap_place_to_ridge
from cpm_core.reconstruction.by_hand.redrawing import CurvePlace as CurvePlace
from cpm_core.reconstruction.by_hand.redrawing import RedrawnCurve as RedrawnCurve
from cpm_core.reconstruction.by_hand.redrawing import pull_curve as pull_curve
from cpm_core.reconstruction.by_hand.redrawing import replace_stretch as replace_stretch
from cpm_core.reconstruction.curve.pipeline import find_contours as find_contours
