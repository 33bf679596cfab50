"""The smooth part of the Coulomb force, which a state keeps for some steps; `coulomb.mesh_force` computes it."""

from __future__ import annotations

from typing import NamedTuple

from cpm_core.numerics.types import Single

MESH_EVERY = 4
"""Steps for which the force on a mesh is used: during these, particles move by a small part of its reach."""


class MeshForce(NamedTuple):
    r"""Smooth part of the Coulomb force on the nodes of a mesh; a plain tuple for the compiled loops.

    Attributes
    ----------
    force : ndarray of float32, shape (\*nodes, D)
        The force; no nodes when the whole force is summed over pairs.
    first : tuple of float
        Position of the first node [px].
    pitch : float
        Distance of the nodes [px].
    reach : float
        Distance R up to which pairs add what the mesh leaves out [px]; infinite when there is no mesh.
    softening : ndarray of float32, shape (3,)
        Coefficients of the polynomial that replaces the inverse square up to R, by powers of the squared distance; zero
        when there is no mesh.
    """

    force: Single
    first: tuple[float, ...]
    pitch: float
    reach: float
    softening: Single
