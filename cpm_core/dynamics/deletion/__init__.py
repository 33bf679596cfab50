"""Deletion of particles that are too near to others (section 3.6).

Of two particles nearer than half of ``d_min`` the one on the weaker edge is deleted, and of equal ones the later. A
deleted particle deletes no other: particles are examined from the strongest edge to the weakest, and each is compared
with those that stay.
"""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.types import Array, Index

NEAR = 0.5
"""Least distance of two particles, in d_min."""


def by_strength(index: Index, strength: Array) -> Index:
    """Order some particles, shape (M,), from the strongest edge to the weakest; equal ones keep their order."""
    return index[np.argsort(-strength[index], kind="stable")]
