"""From particles to contours (section 3.4)."""

from cpm_core.reconstruction.contours import find_contours
from cpm_core.reconstruction.curve import reconstruct_curve

__all__ = ["find_contours", "reconstruct_curve"]
