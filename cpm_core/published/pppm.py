"""The field of the fixed charges by the particle-particle particle-mesh method (section 3.5.2, eq. (16) to (22)).

The error function splits the potential of a charge, ``1 / R``, in two, eq. (22). The near part, ``(1 - erf(R / sigma))
/ R``, has decayed at the cut-off and is summed directly, eq. (17). The rest, ``erf(R / sigma) / R``, is the potential
of the charge spread to a Gaussian; it is smooth enough for a mesh. Charges are shared linearly among the eight mesh
nodes around them, eq. (19), and spread by steps of diffusion, ``sigma = 2 sqrt(D N_t)``; Poisson's equation, eq. (18),
is solved by successive over-relaxation.

An image is a volume of one plane: Poisson's equation in the plane would give ``-log R``, which is not the potential
that was split. The text leaves open the mesh, of a fifth of the cut-off here, D and N_t, and the potential on the faces
of the mesh, which is that of the charges gathered into lumps: faces at zero would screen it.

It points where the exact sum does, within 0.3 degrees on half of the pixels and 3 on 95 % (`tests/core/published`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import scipy

from cpm_core.numerics.parallel import limit_blas
from cpm_core.numerics.types import Array

R_C = 20.0
"""Cut-off of the direct interaction [px]."""

N_P = 50
"""Least number of iterations of over-relaxation: the paper's."""

_ITERATIONS_PER_NODE = 1.25
"""Iterations for each node along one side of a cubic mesh: one carries the potential inward by a cell or so."""

CELLS_PER_CUTOFF = 5
"""Mesh cells to the cut-off: at the cut-off 1 - erf(R / sigma) is 0.0004."""

D = 5.0 / 48.0
"""Coefficient of the diffusion [cells^2 / step]."""

N_T = 8
"""Number of steps of the diffusion."""

_SHARING_SPREAD = 1.0 / 6.0
"""Mean spread of a charge by the sharing among nodes, to the mesh and back; in the units of D N_t."""

GAUSSIAN_WIDTH = 2.0 * math.sqrt(D * N_T + _SHARING_SPREAD)
"""Width sigma = 2 sqrt(D N_t) of the Gaussians: two cells."""

_LUMP_CELLS = 4
"""Mesh cells from one lump of charge to the next."""

_FACE_CELLS = 8
"""Mesh cells from the image to the faces of the mesh."""

_NODES_PER_PASS = 256
"""Nodes on the faces whose distances from all lumps are computed together."""


def pppm_field(f: Array) -> Array:
    r"""Compute the field, shape (D, \*shape), of the charges ``-f``, shape (\*shape), with the cut-off `R_C`."""
    volume = f.reshape(-1, *f.shape[-2:])
    field = direct_field(volume, R_C) + mesh_field(volume, R_C / CELLS_PER_CUTOFF)
    return field if f.ndim == 3 else field[1:, 0]


def direct_field(f: Array, r_c: float) -> Array:
    """Compute the direct part, minus the gradient of eq. (17), shape (3, P, H, W), of charges ``-f``, shape (P, H, W).

    The gradient is taken before the sum: differences of the sums would include the charge of the pixel itself at its
    neighbors, which eq. (7) leaves out.
    """
    sigma = GAUSSIAN_WIDTH * r_c / CELLS_PER_CUTOFF
    reach = [min(int(r_c), n - 1) for n in f.shape]
    offsets = np.indices([2 * r + 1 for r in reach], float) - np.reshape(reach, (3, 1, 1, 1))
    away = np.sqrt((offsets**2).sum(axis=0))
    away[(away == 0.0) | (away > r_c)] = np.inf
    gauss = 2.0 / (math.sqrt(math.pi) * sigma) * np.exp(-((away / sigma) ** 2))
    slope = (scipy.special.erfc(away / sigma) / away + gauss) / away
    return np.stack([scipy.signal.oaconvolve(f, -pull, "same") for pull in slope / away * offsets])  # they are odd


def mesh_field(f: Array, h: float) -> Array:
    """Compute the field, shape (3, P, H, W), of charges ``-f`` spread to Gaussians, by a mesh of spacing `h` [px]."""
    shares = []
    for count in f.shape:  # a mesh centered on the image, whose nodes the lumps fit
        half = 0.5 * (count - 1)
        nodes = _LUMP_CELLS * math.ceil((half / h + _FACE_CELLS) / _LUMP_CELLS)
        shares.append(_hat_weights((np.arange(count) - half) / h + nodes, 2 * nodes + 1))
    q = _multiply_along_axes(shares, -f)
    phi = _potential_on_faces(q)
    _relax(phi, 4.0 * math.pi * _diffuse(q))
    back = [part.T for part in shares]  # the same shares, so that no charge acts on itself, eq. (20)
    return -np.stack([_multiply_along_axes(back, np.gradient(phi, axis=axis)) for axis in range(3)]) / h**2


def _hat_weights(places: Array, count: int) -> Array:
    """Return the weight H of each place x at each node i, eq. (19); shape (count, places)."""
    return np.maximum(0.0, 1.0 - np.abs(places[None, :] - np.arange(count)[:, None]))


def _multiply_along_axes(weights: Sequence[Array], values: Array) -> Array:
    """Multiply values along each axis by a sparse matrix, in an order that does not depend on the processor."""
    for axis, weight in enumerate(weights):
        lines = np.moveaxis(values, axis, 0)
        product = np.asarray(scipy.sparse.csr_array(weight) @ lines.reshape(len(lines), -1))
        values = np.moveaxis(product.reshape(len(weight), *lines.shape[1:]), 0, axis)
    return np.ascontiguousarray(values)


def _sum_of_neighbors(values: Array) -> Array:
    """Return the sum of the six neighbors of the nodes inside the faces."""
    inner, around = slice(1, -1), np.zeros(np.subtract(values.shape, 2))
    for axis in range(3):
        for side in (slice(None, -2), slice(2, None)):
            around += values[tuple(side if k == axis else inner for k in range(3))]
    return around


def _diffuse(q: Array) -> Array:
    """Spread the charges on the nodes by a diffusion."""
    for _ in range(N_T):
        q = (1.0 - 6.0 * D) * q + D * _sum_of_neighbors(np.pad(q, 1))
    return q


@limit_blas()
def _potential_on_faces(q: Array) -> Array:
    """Return the potential on the faces of the mesh, from charges gathered into lumps; zero inside."""
    gathered = [_hat_weights(np.arange(n) / _LUMP_CELLS, (n - 1) // _LUMP_CELLS + 1) for n in q.shape]
    lumps = _multiply_along_axes(gathered, q)
    potential, faces = np.zeros(q.shape), np.ones(q.shape, bool)
    faces[1:-1, 1:-1, 1:-1] = False
    nodes, places, charges = np.argwhere(faces), _LUMP_CELLS * np.argwhere(lumps), lumps[lumps != 0.0]
    for first in range(0, len(nodes), _NODES_PER_PASS):
        some = nodes[first : first + _NODES_PER_PASS]
        potential[tuple(some.T)] = (1.0 / scipy.spatial.distance.cdist(some, places)) @ charges
    return potential


def _relax(potential: Array, source: Array) -> None:
    """Solve ``laplacian(potential) = -source`` inside the faces of the mesh by successive over-relaxation.

    Nodes of even and of odd parity take turns; the relaxation factor rises to its best value by Chebyshev's recursion.
    """
    inner = (slice(1, -1),) * 3
    # the factor by which a Jacobi iteration reduces the slowest error; it sets the over-relaxation
    radius = sum(math.cos(math.pi / (n - 1)) for n in potential.shape) / 3.0
    needed = math.ceil(_ITERATIONS_PER_NODE * math.pi / math.sqrt(2.0 * (1.0 - radius)))
    odd = np.indices(source[inner].shape).sum(axis=0) % 2
    relaxation = 1.0
    for half in range(2 * max(N_P, needed)):
        change = (_sum_of_neighbors(potential) + source[inner]) / 6.0 - potential[inner]
        potential[inner] += relaxation * np.where(odd == half % 2, change, 0.0)
        relaxation = 1.0 / (1.0 - (0.5 if half == 0 else 0.25 * relaxation) * radius**2)
