"""The electric field of the fixed charges, eq. (7) and (8): edge map, Lorentz force, potential and placed charges.

`electric_field` uses one of two methods, `convolution` (exact) or `pppm` (as published).
"""
