"""From particles to contours (section 3.4)."""

from cpm_core.reconstruction.curve.crust import reconstruct_curve
from cpm_core.reconstruction.curve.pipeline import find_contours

__all__ = ["find_contours", "reconstruct_curve"]
