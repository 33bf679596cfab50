"""The electric field of the fixed charges, and how particles between the pixels feel it."""

from cpm_core.field.convolution import electric_field
from cpm_core.field.interpolation import interpolate

__all__ = ["electric_field", "interpolate"]
