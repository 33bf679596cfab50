"""From particles to contours (section 3.4) and surfaces (section 5.4)."""

from cpm_core.reconstruction.curve.crust import reconstruct_curve
from cpm_core.reconstruction.curve.pipeline import find_contours
from cpm_core.reconstruction.surface.from_points import reconstruct_surface

__all__ = ["find_contours", "reconstruct_curve", "reconstruct_surface"]
