"""Deletion of particles that are too near to others (section 3.6).

Of two particles nearer than half of ``d_min`` the one on the weaker edge goes, and among equals the later one. A
particle that goes takes no other with it: particles are looked at from the strongest edge to the weakest, and each is
compared with those that stay.
"""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.types import Array, Index

NEAR = 0.5
"""Distance, in d_min, that two particles must keep."""


def by_strength(index: Index, strength: Array) -> Index:
    """Order some particles, shape (M,), from the strongest edge to the weakest, equals as they come."""
    return index[np.argsort(-strength[index], kind="stable")]
