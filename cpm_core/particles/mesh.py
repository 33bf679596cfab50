"""The value that carries the smooth part of the Coulomb force from step to step; `coulomb.mesh_force` makes it."""

from __future__ import annotations

from typing import NamedTuple

from cpm_core.numerics.types import Single

MESH_EVERY = 4
"""Steps for which the force on a mesh serves: meanwhile particles move by a small part of its reach."""


class MeshForce(NamedTuple):
    r"""Smooth part of the Coulomb force on the nodes of a mesh; a plain tuple for the compiled loops.

    Attributes
    ----------
    force : ndarray of float32, shape (\*nodes, D)
        The force; without any nodes when the pairs are summed whole.
    first : tuple of float
        Place of the first node [px].
    pitch : float
        Distance of the nodes [px].
    reach : float
        Distance R up to which pairs add what the mesh leaves out [px]; infinite when they are summed whole.
    softening : ndarray of float32, shape (3,)
        The polynomial that the inverse square is replaced by up to R, by powers of the squared distance; all of it
        zero when the pairs are summed whole.
    """

    force: Single
    first: tuple[float, ...]
    pitch: float
    reach: float
    softening: Single
