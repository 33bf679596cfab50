"""Noise: how strong it is in an image, and the image without it."""

from cpm_core.image.denoising.cleaning import Cleaned, clean
from cpm_core.image.denoising.total_variation import noise_level

__all__ = ["Cleaned", "clean", "noise_level"]
