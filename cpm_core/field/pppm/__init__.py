"""The electric field as published: particle-particle particle-mesh (section 3.5.2, eq. (16)-(22)).

The error function splits the potential of a charge, ``1 / R``, in two, eq. (22). The near part, ``(1 - erf(R / sigma))
/ R``, has decayed at the cut-off and is summed directly, eq. (17). The rest, ``erf(R / sigma) / R``, is the potential
of the charge spread to a Gaussian; it is smooth enough for a mesh of a fifth of the cut-off. Charges are shared
linearly among mesh nodes, eq. (19), and spread by steps of diffusion, ``sigma = 2 sqrt(D N_t)``; Poisson's equation,
eq. (18), is solved by successive over-relaxation.

Poisson's equation in the plane would give the potential ``-log R``, which is not the one that was split. The mesh is
therefore a slab of space with the image in its middle plane: the force of charges in a plane on charges in that plane
is then the inverse square of eq. (8). The slab is thin. The potential on its faces, computed from the charges gathered
into lumps, represents the space beyond; so few sweeps are enough, since the distance between the faces is small.

Angle between this field and the exact one (`convolution`), measured on six edge maps of 200 to 1000 px a side (a disk,
several objects, two far apart, a spiral, noise, blocks):

============  ======================  ============
sweeps        up to 3 px from edges   further away
============  ======================  ============
10            0.1 to 0.8, 95 %: 4.6   0.2 to 5.8, 95 %: 22 to 170
20            0.0 to 0.3, 95 %: 3.5   0.4 to 0.8, 95 %: 4 to 23
50            0.0 to 0.1, 95 %: 0.8   0.0 to 0.1, 95 %: 1.6
============  ======================  ============

These are medians, and the angle below which 95 % of the pixels are, in degrees. More than the paper's fifty sweeps
change no digit. The remaining error is that of the mesh: it spreads a charge by up to a cell on the way to the mesh and
back, which matters where forces from all sides cancel. The error of the size of the vectors is 1 % (root mean square);
for a single charge up to 13 %, near the cut-off.

In a volume the mesh fills the volume and eight cells beyond each of its faces, and all else is the same. The force
stays the inverse square, since Poisson's equation has no other: compare it with the exact field of exponent 2, not with
that of exponent 3 that runs in volumes use. Sweeps must carry the potential of the faces across the whole mesh, so by
default their number grows with it. Measured on three edge maps (a torus, a ball and a box, the same under noise) with
the cut-off of 10 px; angles as above, and processor time beside that of the convolution:

==========  =======  =====================  =====================  =========  ============  ============
volume      sweeps   up to 3 px from edges  further away           of size    time          convolution
==========  =======  =====================  =====================  =========  ============  ============
64^3        60       0.1 to 0.2, 95 %: 2.4  0.1 to 0.2, 95 %: 0.4  0.8 %      1.0 s         0.1 s
128^3       50       3.8 to 12, 95 %: 34    6.7 to 12, 95 %: 29    14 to 30 %
128^3       100      0.2 to 0.3, 95 %: 6.5  0.1 to 0.2, 95 %: 0.7  0.7 %      6.5 s         1.1 to 1.4 s
==========  =======  =====================  =====================  =========  ============  ============

The time is that of the direct sums, nine tenths of it. With a cut-off of 20 px they take seven times as long, and the
error is no smaller (0.9 to 1.2 % of size).

There are two deviations from the published text. The direct part is differentiated analytically: the differences of
algorithm 1 would include the pixel of the charge itself, which eq. (7) leaves out of the potential. And the faces of
the mesh have the potential of the charges. Faces at zero would screen it: the angle is then 8 to 17 degrees away from
edges, 95 %: 37 to 56, wherever there is more than one object; and on a mesh as fine as the pixels, which fifty sweeps
cannot cross, it is 9 to 15 and 42 to 90.
"""

from __future__ import annotations

from numpy.typing import ArrayLike

from cpm_core.field.pppm.direct_sum import summed_pairs
from cpm_core.field.pppm.mesh import CELLS_A_CUTOFF, SIGMA, mesh_field
from cpm_core.numerics.real_numbers import checked_number, grid_of_numbers
from cpm_core.numerics.types import Array

_LEAST_CUTOFF, _LARGEST_CUTOFF = 5.0, 100.0
_MOST_ITERATIONS = 100_000

_CUTOFFS = {2: 20.0, 3: 10.0}
"""Cut-offs by default [px]; in a volume the time of the direct sums grows with the cube of the cut-off."""


def pppm_field(edge_map: ArrayLike, cutoff: float | None = None, iterations: int | None = None) -> Array:
    r"""Electric field of the fixed charges by the published PPPM method, shape (D, \*shape); an inverse square.

    `edge_map` is the edge strength ``f`` of every pixel, shape (H, W) or (P, H, W); `cutoff` the reach of the direct
    sums, from 5 to 100 px, five times the cell of the mesh, by default 20 px in the plane and 10 px in a volume;
    `iterations` the number of sweeps of successive over-relaxation, at least 1, by default 50, and more in a volume of
    more than some 70 px along each axis.
    Raises `ValueError` for what is no edge map, or for a cut-off or a number of sweeps out of range.
    """
    f = grid_of_numbers(edge_map)
    reach = _CUTOFFS[f.ndim] if cutoff is None else cutoff
    wanted = f"from {_LEAST_CUTOFF:g} to {_LARGEST_CUTOFF:g} px"
    checked_number("cutoff", reach, lambda number: _LEAST_CUTOFF <= number <= _LARGEST_CUTOFF, wanted)
    wanted = f"a whole number from 1 to {_MOST_ITERATIONS}"
    if iterations is not None:
        checked_number("iterations", iterations, lambda n: 1 <= n <= _MOST_ITERATIONS and n == int(n), wanted)
    return short_range(f, reach) + mesh_part(f, reach, iterations)


def short_range(f: Array, cutoff: float) -> Array:
    r"""Field of the direct interaction, eq. (17), summed charge by charge, shape (D, \*shape)."""
    return summed_pairs(f, cutoff, SIGMA * cutoff / CELLS_A_CUTOFF)


def mesh_part(f: Array, cutoff: float, iterations: int | None = None) -> Array:
    r"""Field of the charges spread to Gaussians, shape (D, \*shape), from the mesh for this cut-off."""
    return mesh_field(f, cutoff / CELLS_A_CUTOFF, iterations)
