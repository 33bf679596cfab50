"""Numbers that have the same bits on every processor, whatever the width of its vector registers.

Where they differ in the last digit, particles in a crowd may make 0.0001 px of it. NumPy has exponentials, logarithms,
powers and arc tangents for each kind of vector register, and so has its product of complex numbers; they differ in one
of twenty results. Its sums, products, quotients and roots are the same everywhere, and so are the transforms of SciPy.
What particles feel is made of these, and of what is here. Linear algebra (`@`, `np.linalg`) differs as well: it may
measure contours, but not make the fields.
"""
