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
the cut-off of 10 px; angles as above, and processor time next to that of the convolution:

==========  =======  =====================  =====================  =========  ============  ============
volume      sweeps   up to 3 px from edges  further away           of size    time          convolution
==========  =======  =====================  =====================  =========  ============  ============
64^3        60       0.1 to 0.2, 95 %: 2.4  0.1 to 0.2, 95 %: 0.4  0.8 %      1.0 s         0.1 s
128^3       50       3.8 to 12, 95 %: 34    6.7 to 12, 95 %: 29    14 to 30 %
128^3       100      0.2 to 0.3, 95 %: 6.5  0.1 to 0.2, 95 %: 0.7  0.7 %      6.5 s         1.1 to 1.4 s
==========  =======  =====================  =====================  =========  ============  ============

The times were taken with direct sums pair by pair, nine tenths of them; as a convolution these take less. With a
cut-off of 20 px the error is no smaller (0.9 to 1.2 % of size).

There are two deviations from the published text. The direct part is differentiated analytically: the differences of
algorithm 1 would include the pixel of the charge itself, which eq. (7) leaves out of the potential. And the faces of
the mesh have the potential of the charges. Faces at zero would screen it: the angle is then 8 to 17 degrees away from
edges, 95 %: 37 to 56, wherever there is more than one object; and on a mesh as fine as the pixels, which fifty sweeps
cannot cross, it is 9 to 15 and 42 to 90.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import reduce

import numpy as np
import scipy

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array

_CUTOFF_BY_AXES = {2: 20.0, 3: 10.0}
"""Cut-offs [px]; in a volume the time of the direct sums grows with the cube of the cut-off."""


def pppm_field(f: Array) -> Array:
    r"""Compute the electric field of the fixed charges, shape (D, \*shape), by the published PPPM method.

    It is an inverse square. `f` is the edge strength of every pixel, shape (H, W) or (P, H, W). There are 50 sweeps of
    successive over-relaxation, and more in a volume of more than some 70 px along each axis.
    """
    cutoff = _CUTOFF_BY_AXES[f.ndim]
    return direct_field(f, cutoff) + mesh_field(f, cutoff / CELLS_PER_CUTOFF)


def direct_field(f: Array, cutoff: float) -> Array:
    r"""Compute the field of the direct interaction, eq. (17), shape (D, \*shape); `f` has the shape (\*shape).

    Minus the gradient of ``-f (1 - erf(R / sigma)) / R``, summed over all other charges up to the cut-off [px].
    """
    sigma = GAUSSIAN_WIDTH * cutoff / CELLS_PER_CUTOFF
    reach = [min(int(cutoff), n - 1) for n in f.shape]
    offsets = np.indices([2 * r + 1 for r in reach], float) - np.reshape(reach, (-1, *[1] * f.ndim))
    distance = reduce(np.hypot, offsets)
    away = np.where(distance > 0.0, distance, np.inf)
    slope = (
        scipy.special.erfc(away / sigma) / away**2
        + 2.0 / (math.sqrt(math.pi) * sigma) * np.exp(-((away / sigma) ** 2)) / away
    )
    pulls = np.where(distance <= cutoff, slope / away, 0.0) * offsets
    return np.stack([scipy.signal.oaconvolve(f, -pull, "same") for pull in pulls])  # they are odd


CELLS_PER_CUTOFF = 5
"""Mesh cells to the cut-off: at the cut-off 1 - erf(R / sigma) is 0.0004."""

_DIFFUSION_COEFFICIENT = 5.0 / 48.0
"""Coefficient D of the diffusion [cells^2 / step]."""

_DIFFUSION_STEPS = 8
"""Number N_t of the steps of diffusion."""

_SHARING_SPREAD = 1.0 / 6.0
"""Mean spread of a charge by the sharing among nodes, to the mesh and back; in the units of D N_t."""

GAUSSIAN_WIDTH = 2.0 * math.sqrt(_DIFFUSION_COEFFICIENT * _DIFFUSION_STEPS + _SHARING_SPREAD)
"""Width sigma = 2 sqrt(D N_t) of the Gaussians: two cells."""

_LUMP_CELLS = 4
"""Mesh cells from one lump of charge to the next."""

_FACE_DISTANCE_CELLS = 8
"""Mesh cells from the image to the faces of the mesh: two lumps, so that the lumps act like the charges that they
represent."""

_PUBLISHED_SWEEPS = 50
"""Least number of sweeps of over-relaxation: the paper's, enough for a slab, whose faces are near."""

_SWEEPS_PER_NODE = 1.25
"""Sweeps for each node along one side of a cubic mesh: a sweep carries the potential inward by a cell or so."""

_FACE_NODES_PER_PASS = 256
"""Nodes on the faces of the mesh whose distances from all lumps are computed together."""


def mesh_field(f: Array, cell: float) -> Array:
    r"""Compute the field of the charges spread to Gaussians, shape (D, \*shape), from Poisson's equation on a mesh.

    `f` is the edge strength, shape (\*shape), of two or three axes. The sweeps of successive over-relaxation begin with
    a potential of zero inside the mesh; there are as many as leave only the error of the mesh.
    """
    flat = f.ndim == 2
    shares = []
    for count in f.shape:
        # centered on the image and of an odd number of nodes, so that a mirrored image has a mirrored mesh, including
        # the order of relaxation, and the lumps fit
        half = 0.5 * (count - 1)
        nodes = _LUMP_CELLS * math.ceil((half / cell + _FACE_DISTANCE_CELLS) / _LUMP_CELLS)
        shares.append(_hat_weights((np.arange(count, dtype=np.float64) - half) / cell + nodes, 2 * nodes + 1))
    if flat:
        f, shares = f[None], [np.ones((1, 1)), *shares]
    charge = _multiply_along_axes(shares, -f)
    density = _diffuse_charge(charge, flat)
    potential = np.zeros_like(density)
    _charge_faces(potential, charge, flat)
    angles = [math.pi / (n - 1) for n in potential.shape]
    angles[0] *= 0.5 if flat else 1.0
    # the factor by which a Jacobi sweep reduces the slowest error; it sets the over-relaxation
    radius = sum(map(math.cos, angles)) / 3.0
    sweeps = max(_PUBLISHED_SWEEPS, math.ceil(_SWEEPS_PER_NODE * math.pi / math.sqrt(2.0 * (1.0 - radius))))
    _relax_potential(potential, 4.0 * math.pi * density, sweeps, radius, 0 if flat else 1)
    back = [part.T for part in shares]  # the same shares, so that no charge acts on itself, eq. (20)
    there = potential[: len(charge)]
    field = (
        np.stack([-_multiply_along_axes(back, np.gradient(there, axis=axis)) for axis in range(int(flat), 3)]) / cell**2
    )
    return field[:, 0] if flat else field


def _hat_weights(places: Array, count: int) -> Array:
    """Return the weight ``max(0, 1 - |x - i|)`` of each position x at each node i; shape (count, positions)."""
    return np.maximum(0.0, 1.0 - np.abs(places[None, :] - np.arange(count)[:, None]))


def _multiply_along_axes(weights: Sequence[Array], values: Array) -> Array:
    """Multiply values along each axis by a sparse matrix, in an order that does not depend on the processor."""
    for axis, weight in enumerate(weights):
        lines = np.moveaxis(values, axis, 0)
        product = np.asarray(scipy.sparse.csr_array(weight) @ lines.reshape(len(lines), -1))
        values = np.moveaxis(product.reshape(len(weight), *lines.shape[1:]), 0, axis)
    return values


def _diffuse_charge(charge: Array, flat: bool) -> Array:
    """Diffuse the charge on the nodes of a mesh; that of an image, shape (1, R, C), into the upper half of its slab."""
    density = np.zeros((_FACE_DISTANCE_CELLS + 1 if flat else len(charge), *charge.shape[1:]))
    density[: len(charge)] = charge
    for _ in range(_DIFFUSION_STEPS):
        wide = np.pad(density, 1)
        if flat:
            wide[0] = wide[2]  # the lower half mirrors the upper
        inner = wide[1:-1, 1:-1, 1:-1]
        around = wide[:-2, 1:-1, 1:-1] + wide[2:, 1:-1, 1:-1] + wide[1:-1, :-2, 1:-1] + wide[1:-1, 2:, 1:-1]
        around = around + wide[1:-1, 1:-1, :-2] + wide[1:-1, 1:-1, 2:]
        density = (1.0 - 6.0 * _DIFFUSION_COEFFICIENT) * inner + _DIFFUSION_COEFFICIENT * around
    return density


def _charge_faces(potential: Array, charge: Array, flat: bool) -> None:
    """Set the potential on the faces of the mesh to that of the charges, gathered into lumps."""
    lumps = _multiply_along_axes(
        [_hat_weights(np.arange(n) / _LUMP_CELLS, (n - 1) // _LUMP_CELLS + 1) for n in charge.shape], charge
    )
    faces = np.ones(potential.shape, bool)
    faces[0 if flat else 1 : -1, 1:-1, 1:-1] = False
    nodes, places, charges = np.argwhere(faces), _LUMP_CELLS * np.argwhere(lumps), lumps[lumps != 0.0]
    for first in range(0, len(nodes), _FACE_NODES_PER_PASS):
        some = nodes[first : first + _FACE_NODES_PER_PASS]
        potential[tuple(some.T)] = (1.0 / scipy.spatial.distance.cdist(some, places)) @ charges


@compiled
def _relax_potential(potential: Array, source: Array, iterations: int, radius: float, begin: int) -> None:
    """Solve ``laplacian(potential) = -source`` inside the faces of the mesh by successive over-relaxation.

    Nodes of even and of odd parity take turns; the relaxation factor rises to its best value by Chebyshev's recursion.
    `begin` is the first plane that is no face: 0 where the plane below it mirrors the one above it.
    """
    planes, rows, cols = potential.shape
    relaxation = 1.0
    for half_sweep in range(2 * iterations):
        for p in range(begin, planes - 1):
            below = p - 1 if p > 0 else 1
            for r in range(1, rows - 1):
                for c in range(1 + (p + r + 1 + half_sweep) % 2, cols - 1, 2):
                    around = potential[p + 1, r, c] + potential[below, r, c]
                    around += potential[p, r - 1, c] + potential[p, r + 1, c]
                    around += potential[p, r, c - 1] + potential[p, r, c + 1]
                    potential[p, r, c] += relaxation * ((around + source[p, r, c]) / 6.0 - potential[p, r, c])
        relaxation = 1.0 / (1.0 - (0.5 if half_sweep == 0 else 0.25 * relaxation) * radius * radius)
