"""The layer of the forces on the particle under the pointer."""

from __future__ import annotations

import math

import numpy as np
import pyqtgraph as pg

from cpm_app.model.text.language import localize_number, tr
from cpm_app.session.scene import Scene
from cpm_app.session.worker.requests import ForcesProbed, probe_forces
from cpm_app.views.items.item import FAINT_TEXT_COLOR, Markers, PinnedText, line_pen, to_position, to_xy
from cpm_app.views.layers.fields import build_arrow_lines
from cpm_app.views.layers.layer import Layer
from cpm_app.views.theme import theme
from cpm_core.numerics import Place

FORCE_KINDS = {
    "coulomb": (tr("Coulomb"), theme.COULOMB_COLOR),
    "lorentz": (tr("Lorentz"), theme.LORENTZ_COLOR),
    "placed": (tr("Placed charges"), theme.REGION_COLOR),
    "friction": (tr("Friction"), theme.UNKNOWN_COLOR),
    "damping": (tr("Damping"), theme.DAMPING_COLOR),
    "total": (tr("Total"), theme.SELECTED_COLOR),
}
"""Names and colors of the forces, in the order of the legend."""

_ALWAYS_LISTED = ("coulomb", "lorentz", "damping", "total")
"""Forces that are listed even when they are zero."""

_PROBE_RADIUS = 24.0
"""Largest distance of the probed particle from the pointer [px of the screen]."""

_MIN_SHOWN_FORCE = 5e-4
"""Force below which none is shown."""

_ARROW_LENGTH = 80.0
"""Length of the longest arrow [px of the screen]."""

_FULL_ARROW_FORCE = 0.2
"""Force from which the longest arrow has its full length; if all forces are weaker, all arrows are shorter."""

_FORCE_Z = 19.0
"""Place in the stack, below the legends."""


class ForceLayer(Layer):
    """Arrows for all forces on one particle, and a legend with their names and magnitudes in the upper right corner.

    The particle is the one nearest to the pointer or, without a pointer, to the center of the visible part.
    """

    name = "forces"
    title = tr("Forces under the pointer")
    tip = tr("Coulomb, Lorentz and damping force on the particle nearest to the pointer.")
    shortcut = "Alt+3"
    initially_shown = False
    colors = (theme.COULOMB_COLOR, theme.LORENTZ_COLOR, theme.DAMPING_COLOR)

    def create_items(self) -> None:
        """Create the items of the layer."""
        self._ring = Markers(_FORCE_Z, size=15.0, symbol="o", brush=None, pen=pg.mkPen(theme.SELECTED_COLOR, width=1.6))
        halo = line_pen(theme.CANVAS_HALO_COLOR, 4.6)
        self._arrows = {
            name: pg.PlotCurveItem(pen=line_pen(color, 2.2), shadowPen=halo, antialias=True, connect="pairs")
            for name, (_, color) in FORCE_KINDS.items()
        }
        self.legend = PinnedText(self.view, (1.0, 0.0))
        for item in self._arrows.values():
            item.setZValue(_FORCE_Z)
        self.add_items(self._ring, *self._arrows.values(), self.legend)
        self.probed: ForcesProbed | None = None
        """Forces that are shown."""
        self.lines: list[tuple[str, str, str]] = []
        """Name, color and magnitude of each force in the legend."""
        self._pointer: Place | None = None
        self._draw_arrows()
        self.view.sigRangeChanged.connect(self._draw_arrows)

    def set_pointer(self, place: Place | None) -> None:
        """Set the place of the pointer in the image or in the volume, or None when it has left."""
        self._pointer = place
        self._request_forces()

    def apply_visibility(self) -> None:
        """Request forces only while the layer is shown."""
        self._show_probed(None)
        self._request_forces()

    def show_scene(self, before: Scene) -> None:
        """Show requested forces; request them again when the particles have moved."""
        snapshot, probed = self.scene.snapshot, self.scene.probed
        if snapshot is not before.snapshot:
            if snapshot is None:
                self._show_probed(None)
            self._request_forces()
        answered = self.shown and probed is not before.probed
        if answered and probed is not None and snapshot is not None and probed.generation == snapshot.generation:
            self._show_probed(probed if probed.identity >= 0 else None)

    def _request_forces(self) -> None:
        """Request the forces."""
        snapshot = self.scene.snapshot
        if not self.shown or snapshot is None or self.session is None:
            return
        place, reach = self._pointer, _PROBE_RADIUS * float(self.view.viewPixelSize()[0])
        if place is None:
            place, reach = to_position(self.view.viewRect().center()), math.inf
            place = place if self.scene.slices is None else self.scene.slices.current.lift_position(place)
        self.session.post_command(probe_forces(snapshot.generation, place, reach))

    def _show_probed(self, probed: ForcesProbed | None) -> None:
        self.probed = probed
        if probed is not None:
            sizes = probed.sizes
            listed = [name for name in FORCE_KINDS if name in _ALWAYS_LISTED or sizes[name] >= _MIN_SHOWN_FORCE]
            self.lines = [(*FORCE_KINDS[name], localize_number(f"{sizes[name]:.3f}")) for name in listed]
            title = tr("Particle {number}", number=localize_number(f"{probed.identity:,}"))
            rows = (
                f"<tr><td style='color:{color}'>━ </td><td>{name} </td><td align='right'>&nbsp;{size}</td></tr>"
                for name, color, size in self.lines
            )
            self.legend.show_html(f"<div style='color:{FAINT_TEXT_COLOR}'>{title}</div><table>{''.join(rows)}</table>")
        self._draw_arrows()

    def _draw_arrows(self, *_: object) -> None:
        probed = self.probed if self.shown else None
        for item in (self._ring, *self._arrows.values(), self.legend):
            item.setVisible(probed is not None)
        if probed is None:
            return
        longest = max(_FULL_ARROW_FORCE, *(probed.sizes[name] for name in FORCE_KINDS))
        at, pixel = np.array([probed.position]), np.array(self.view.viewPixelSize()[::-1])
        for name, item in self._arrows.items():
            way = probed.forces[name] * (probed.sizes[name] >= _MIN_SHOWN_FORCE)
            item.setData(*to_xy(build_arrow_lines(at, at + _ARROW_LENGTH / longest * way * pixel)))
        self._ring.show_markers(at)
