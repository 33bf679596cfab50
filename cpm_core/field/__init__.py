"""The electric field of the fixed charges, and how particles between the pixels feel it.

`electric` is the door: it asks one of the methods, `convolution` (exact) or `pppm` (as published).
"""

from cpm_core.field.electric import electric_field
from cpm_core.field.interpolation import interpolate

__all__ = ["electric_field", "interpolate"]
