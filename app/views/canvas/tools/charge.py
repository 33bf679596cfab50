"""The tools that place charges."""

from __future__ import annotations

import math

from app.model.text.language import from_core, tr
from app.views.canvas.tools.tool import ShapeTool
from cpm_core.numerics.types import Place
from cpm_core.shapes import Charge


class ChargeTool(ShapeTool):
    """Places a charge, or takes hold of an existing one; the charge follows the pointer while the button is down."""

    by_keys = tr("Enter places it or picks one up, arrow keys move it, Enter puts it down.")
    strength: float
    """Strength of the charges, above zero for attracting ones."""

    def press(self, at: Place, reach: float) -> None:
        """Take hold of the charge under the pointer, or place one."""
        self.used = True
        self._begin(self._found(at, reach))
        if self._before is None:
            self._place(Charge(at, self.strength))
        self._session.select(self._index)

    def drag(self, at: Place) -> None:
        """Move the charge to the pointer."""
        charge = self._drawn
        if isinstance(charge, Charge):
            self._place(Charge(at, charge.strength))

    def _place(self, charge: Charge) -> None:
        verb = tr("drop {charge}") if self._before is None else tr("move {charge}")
        self._put(verb.format(charge=from_core(charge.title)), charge)

    def _found(self, at: Place, reach: float) -> int | None:
        """Index of the charge nearest to the pointer, the topmost of equally near ones."""
        near = [
            (math.dist(shape.position, at), -index)
            for index, shape in enumerate(self._session.document.shapes)
            if isinstance(shape, Charge) and math.dist(shape.position, at) <= reach
        ]
        return -min(near)[1] if near else None


class AttractTool(ChargeTool):
    """Places charges that attract particles."""

    name = "attract"
    tip = tr("Place a charge that attracts particles, and drag it while they run; < and > change its strength.")
    guidance = tr("Click to place a charge that attracts particles; drag it while they run.")
    strength = 2.0


class RepelTool(ChargeTool):
    """Places charges that repel particles."""

    name = "repel"
    tip = tr("Place a charge that repels particles, and drag it while they run; < and > change its strength.")
    guidance = tr("Click to place a charge that repels particles; drag it while they run.")
    strength = -2.0
