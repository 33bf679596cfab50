"""The electric field of the fixed charges, eq. (7) and (8): edge map, Lorentz force, potential and placed charges.

It is computed by `convolution`: exact, or cheaper by blocks.
"""

from cpm_core.field.placed_charges import CHARGE_RADIUS as CHARGE_RADIUS
from cpm_core.field.placed_charges import CHARGE_REACH as CHARGE_REACH
from cpm_core.field.placed_charges import sort_charges as sort_charges
from cpm_core.field.scale_field import ScaleField as ScaleField
