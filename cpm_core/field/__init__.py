"""The electric field of the fixed charges, eq. (7) and (8), and how particles between the pixels feel it.

`electric_field` asks one of the methods, `convolution` (exact) or `pppm` (as published).
"""
