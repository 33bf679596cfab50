"""The forces of eq. (12) on particles, each separately: a step adds them up without keeping them."""

from __future__ import annotations

from dataclasses import dataclass

from cpm_core.numerics.types import Array
from cpm_core.parameters.quotation import counted, described


@dataclass(frozen=True, eq=False, slots=True)
class Forces:
    """Forces on particles in eq. (12), with their weights; all of shape (N, D) [px of the scale / unit of time^2].

    Attributes
    ----------
    coulomb : ndarray
        ``w1 F_c``, as far as the repulsion has not faded.
    lorentz : ndarray
        ``w2 F_l``, of the image alone.
    placed : ndarray
        ``w2`` times the force of the placed charges.
    friction : ndarray
        What holds a slow particle, or one at rest, on its edge: it cancels the part of the other forces along the edge.
    damping : ndarray
        ``-beta v``, with a larger beta for particles that are brought to rest; zero for those that a step skips.

    Examples
    --------
    >>> engine = cpm.Engine(cpm.example("disk"))
    >>> forces = engine.forces(engine.start(cpm.circle((32, 32), 8)), cpm.Parameters())
    >>> forces.coulomb.shape, bool(np.allclose(forces.total, forces.coulomb + forces.lorentz + forces.placed))
    ((25, 2), True)
    """

    coulomb: Array
    lorentz: Array
    placed: Array
    friction: Array
    damping: Array

    @property
    def total(self) -> Array:
        """Sum of all forces: the acceleration with which the next step begins."""
        return self.coulomb + self.lorentz + self.placed + self.friction + self.damping

    def __repr__(self) -> str:
        return described("Forces", f"on {counted(len(self.coulomb), 'particle')}")
