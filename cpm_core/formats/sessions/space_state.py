"""What a state of a run in a volume holds beside that of one in the plane, as plain JSON."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from cpm_core.formats.sessions.plain_arrays import array_from_plain, array_to_plain
from cpm_core.formats.sessions.plain_values import number
from cpm_core.model.coverage import SurfaceCoverage
from cpm_core.model.state import State, SurfaceContact

_UNIT = 1.0 + 1e-6
"""Greatest length of a normal, with rounding."""


def space_to_plain(state: State) -> dict[str, Any]:
    """Contact of the particles with surfaces, and the coverage of a volume."""
    contact, space = state.particles.contact, state.space
    assert contact is not None
    assert space is not None
    return {
        "normal": array_to_plain(contact.normal),
        "seated": array_to_plain(contact.seated.astype(np.int32)),
        "strength": array_to_plain(contact.strength),
        "woken": array_to_plain(contact.woken),
        "covered": array_to_plain(space.covered.cells),
        "side": space.covered.side,
    }


def contact_from_plain(given: Mapping[str, Any], count: int) -> SurfaceContact:
    """Contact of so many particles; ValueError when it cannot be one."""
    normal = array_from_plain(given.get("normal"), float, (count, 3), "normal of state")
    seated = array_from_plain(given.get("seated"), np.int32, (count,), "seated of state")
    strength = array_from_plain(given.get("strength"), float, (count,), "strength of state")
    woken = array_from_plain(given.get("woken"), np.int64, (count,), "woken of state")
    if not (np.linalg.norm(normal, axis=1) <= _UNIT).all():
        raise ValueError("normal of state holds a direction longer than one.")
    if not np.isfinite(strength).all():
        raise ValueError("strength of state holds a value that is not a number.")
    return SurfaceContact(normal, seated != 0, strength, woken)


def covered_from_plain(given: Mapping[str, Any]) -> SurfaceCoverage:
    """Coverage of a volume; ValueError when it cannot be one."""
    cells = array_from_plain(given.get("covered"), np.int64, (None,), "covered of state")
    side = number(given.get("side"), "side of state")
    if not side > 0.0:
        raise ValueError(f"side of state is {side} but must be above 0.")
    if (np.diff(cells) <= 0).any():
        raise ValueError("covered of state holds cells that do not ascend.")
    return SurfaceCoverage(cells, side)
