"""The mesh part of PPPM: the potential of charges spread to Gaussians, by Poisson's equation, eq. (18) to (20).

The mesh always fills space. That of a volume reaches beyond all its faces. That of an image is a slab with the image in
its middle plane; since its two halves mirror each other, only the upper one is kept, and the image is its first plane.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import scipy

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import share
from cpm_core.numerics.types import Array

CELLS_A_CUTOFF = 5
"""Mesh cells to the cut-off: at the cut-off 1 - erf(R / sigma) is 0.0004."""

_DIFFUSION, _DIFFUSION_STEPS = 5.0 / 48.0, 8
"""Coefficient D [cells^2 / step] and number N_t of the steps of diffusion."""

_SHARED_OUT = 1.0 / 6.0
"""Mean spread of a charge by the sharing among nodes, to the mesh and back; in the units of D N_t."""

SIGMA = 2.0 * math.sqrt(_DIFFUSION * _DIFFUSION_STEPS + _SHARED_OUT)
"""Width sigma = 2 sqrt(D N_t) of the Gaussians: two cells."""

_LUMP = 4
"""Mesh cells from one lump of charge to the next."""

_MARGIN = 8
"""Mesh cells from the image to the faces of the mesh: two lumps, so that the lumps act like the charges that they
represent."""

_SWEEPS, _SWEEPS_A_NODE = 50, 1.25
"""Sweeps of over-relaxation by default: the paper's, or those for each node along one side of a cubic mesh. A sweep
carries the potential of the faces inward by a cell or so. Those of a slab are near, those of a volume may be far."""

_WORTH_A_THREAD = 200_000
"""Pairs of a lump and a node from which a thread pays."""


def mesh_field(f: Array, cell: float, iterations: int | None) -> Array:
    r"""Field of the charges spread to Gaussians, shape (D, \*shape), from Poisson's equation on a mesh.

    `f` is the edge strength, shape (\*shape), of two or three axes. The sweeps of successive over-relaxation begin with
    a potential of zero inside the mesh; by default there are as many as leave only the error of the mesh.
    """
    flat = f.ndim == 2
    shares = [_shares(n, cell) for n in f.shape]
    if flat:
        f, shares = f[None], [np.ones((1, 1)), *shares]
    charge = _carried(shares, -f)
    density = _spread(charge, flat)
    potential = np.zeros_like(density)
    _charge_faces(potential, charge, flat)
    radius = _jacobi_radius(potential.shape, flat)
    usual = max(_SWEEPS, math.ceil(_SWEEPS_A_NODE * math.pi / math.sqrt(2.0 * (1.0 - radius))))
    sweeps = usual if iterations is None else int(iterations)
    _relax(potential, 4.0 * math.pi * density, sweeps, radius, 0 if flat else 1)
    back = [part.T for part in shares]
    there = potential[: len(charge)]
    field = np.stack([-_carried(back, _slope(there, axis)) for axis in range(int(flat), 3)]) / cell**2
    return field[:, 0] if flat else field


def _shares(count: int, cell: float) -> Array:
    """Share of each of `count` pixels in a row of mesh nodes, eq. (19); shape (nodes, count).

    The same shares carry charges to the mesh and the field back, so that no charge acts on itself, eq. (20). The mesh
    is centered on the image and has an odd number of nodes, so that a mirrored image has a mirrored mesh, including the
    order of relaxation, and the lumps fit.
    """
    half = 0.5 * (count - 1)
    nodes = _LUMP * math.ceil((half / cell + _MARGIN) / _LUMP)
    return _hats((np.arange(count, dtype=np.float64) - half) / cell + nodes, 2 * nodes + 1)


def _hats(places: Array, count: int) -> Array:
    """Weight ``max(0, 1 - |x - i|)`` of each position x at each of `count` nodes i; shape (count, positions)."""
    return np.asarray(np.maximum(0.0, 1.0 - np.abs(places[None, :] - np.arange(count)[:, None])))


def _carried(weights: Sequence[Array], values: Array) -> Array:
    """Values multiplied along each axis by a matrix of few weights, in an order that is the same everywhere."""
    for axis, weight in enumerate(weights):
        lines = np.moveaxis(values, axis, 0)
        product = np.asarray(scipy.sparse.csr_array(weight) @ lines.reshape(len(lines), -1))
        values = np.moveaxis(product.reshape(len(weight), *lines.shape[1:]), 0, axis)
    return values


def _slope(values: Array, axis: int) -> Array:
    """Central differences along an axis, zero on the faces of the mesh."""
    slope = np.zeros(values.shape)
    lines, out = np.moveaxis(values, axis, 0), np.moveaxis(slope, axis, 0)
    out[1:-1] = 0.5 * (lines[2:] - lines[:-2])
    return slope


def _spread(charge: Array, flat: bool) -> Array:
    """Charge on the nodes of a mesh, diffused; that of an image, shape (1, R, C), into the upper half of its slab."""
    density = np.zeros((_MARGIN + 1 if flat else len(charge), *charge.shape[1:]))
    density[: len(charge)] = charge
    for _ in range(_DIFFUSION_STEPS):
        wide = np.pad(density, 1)
        if flat:
            wide[0] = wide[2]  # the lower half mirrors the upper
        inner = wide[1:-1, 1:-1, 1:-1]
        around = wide[:-2, 1:-1, 1:-1] + wide[2:, 1:-1, 1:-1] + wide[1:-1, :-2, 1:-1] + wide[1:-1, 2:, 1:-1]
        around = around + wide[1:-1, 1:-1, :-2] + wide[1:-1, 1:-1, 2:]
        density = (1.0 - 6.0 * _DIFFUSION) * inner + _DIFFUSION * around
    return density


def _charge_faces(potential: Array, charge: Array, flat: bool) -> None:
    """Set the potential on the faces of the mesh to that of the charges, gathered into lumps."""
    lumps = _carried([_hats(np.arange(n) / _LUMP, (n - 1) // _LUMP + 1) for n in charge.shape], charge)
    faces = np.ones(potential.shape, bool)
    faces[0 if flat else 1 : -1, 1:-1, 1:-1] = False
    held = np.ascontiguousarray(np.argwhere(faces).T, float)
    charged = np.argwhere(lumps)
    place, size = _LUMP * charged.astype(float), lumps[tuple(charged.T)]
    values = np.zeros(held.shape[1])
    least = _WORTH_A_THREAD // max(len(size), 1) + 1
    share(lambda first, last: _sum_lumps(held, place, size, first, last, values), len(values), least)
    potential[faces] = values


def _jacobi_radius(shape: tuple[int, ...], flat: bool) -> float:
    """Factor by which a Jacobi sweep reduces the slowest error in a mesh; it sets the over-relaxation."""
    planes, rows, cols = shape
    angles = ((0.5 if flat else 1.0) * math.pi / (planes - 1), math.pi / (rows - 1), math.pi / (cols - 1))
    return sum(math.cos(angle) for angle in angles) / 3.0


@compiled
def _sum_lumps(held: Array, place: Array, charge: Array, first: int, last: int, out: Array) -> None:
    """Add the potential of lumps, positions of shape (L, 3), to some of the nodes, positions of shape (3, N)."""
    for j in range(len(charge)):
        p, r, c = place[j, 0], place[j, 1], place[j, 2]
        for i in range(first, last):
            plane, row, col = held[0, i] - p, held[1, i] - r, held[2, i] - c
            out[i] += charge[j] / np.sqrt(plane * plane + row * row + col * col)


@compiled
def _relax(potential: Array, source: Array, iterations: int, radius: float, begin: int) -> None:
    """Sweeps of successive over-relaxation of ``laplacian(potential) = -source`` inside the faces of the mesh.

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
