"""The electric field of the fixed charges, eq. (7) and (8): edge map, Lorentz force, potential and placed charges.

`electric_field` uses `convolution` (exact, or cheaper by blocks) or `pppm` (as published).
"""
