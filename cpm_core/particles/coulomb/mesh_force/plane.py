"""The smooth part of the Coulomb force on a mesh of rows and columns."""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Single
from cpm_core.particles.coulomb.mesh_force import PITCH, convolved, mesh_shape, softening, spline
from cpm_core.particles.mesh import MeshForce

NO_MESH = MeshForce(np.zeros((0, 0, 2), np.float32), (0.0, 0.0), 1.0, np.inf, np.zeros(3, np.float32))
"""No mesh: the whole force is summed over pairs."""


def mesh_force(position: Array, shape: tuple[int, ...], reach: float) -> MeshForce:
    """Smooth part of the Coulomb force of all particles, shape (N, 2) [px], on the nodes of a mesh over an image.

    `reach` is the distance R up to which pairs add what the mesh leaves out [px].
    """
    rows, cols = mesh_shape(shape, reach)
    pitch = PITCH * reach
    # centered, so that a mirrored image has a mirrored mesh
    top, left = (0.5 * (n - 1) - 0.5 * pitch * (m - 1) for n, m in zip(shape, (rows, cols), strict=True))
    charge = np.zeros((rows, cols), np.float32)
    _spread(position, top, left, 1.0 / pitch, charge)
    return MeshForce(convolved(charge, reach), (top, left), pitch, reach, softening(reach))


@compiled
def mesh_force_at(force: Single, down: float, right: float) -> tuple[float, float]:
    """Smooth part of the Coulomb force at a position between the nodes of a mesh, in units of the pitch."""
    row, a, b, c = spline(down)
    col, d, e, f = spline(right)
    return _mixed(force, row, col, 0, a, b, c, d, e, f), _mixed(force, row, col, 1, a, b, c, d, e, f)


@compiled
def _mixed(
    force: Single, row: int, col: int, k: int, a: float, b: float, c: float, d: float, e: float, f: float
) -> float:
    """Component `k` of the force on nine nodes, weighted."""
    upper = d * force[row, col, k] + e * force[row, col + 1, k] + f * force[row, col + 2, k]
    middle = d * force[row + 1, col, k] + e * force[row + 1, col + 1, k] + f * force[row + 1, col + 2, k]
    lower = d * force[row + 2, col, k] + e * force[row + 2, col + 1, k] + f * force[row + 2, col + 2, k]
    mixed: float = a * upper + b * middle + c * lower
    return mixed


@compiled
def _spread(position: Array, top: float, left: float, density: float, charge: Single) -> None:
    """Spread unit charges over the nodes of a mesh."""
    for i in range(len(position)):
        row, a, b, c = spline((position[i, 0] - top) * density)
        col, d, e, f = spline((position[i, 1] - left) * density)
        for m, down in ((0, a), (1, b), (2, c)):
            charge[row + m, col] += down * d
            charge[row + m, col + 1] += down * e
            charge[row + m, col + 2] += down * f
