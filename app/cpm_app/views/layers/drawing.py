"""The drawing layer: starts with their particles and handles, limits, placed charges, and the current draft."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QColor, QPainter, QPainterPath
from PySide6.QtWidgets import QStyleOptionGraphicsItem, QWidget

from cpm_app.model.text.language import tr
from cpm_app.model.volume.shape_sections import Section, cut_sphere, whole_shape
from cpm_app.session.scene import Scene
from cpm_app.views.items.curves import Curves
from cpm_app.views.items.discs import Discs
from cpm_app.views.items.item import ImageOverlay, Markers, enable_caching, line_pen, to_xy
from cpm_app.views.layers.layer import Layer
from cpm_app.views.theme import theme
from cpm_core.field import CHARGE_RADIUS, CHARGE_REACH
from cpm_core.numerics import Array, Place
from cpm_core.numerics.types import NO_POINTS, Extent
from cpm_core.shapes import (
    Barrier,
    Box,
    BoxGrid,
    BoxThreshold,
    Charge,
    Circle,
    Ellipse,
    Everywhere,
    Grid,
    Interest,
    Limit,
    Measure,
    Points,
    Polygon,
    SeedingKind,
    Sphere,
    Start,
    Stroke,
    Threshold,
)

_VEIL_Z = 2.5
"""Place of the veil in the stack, below particles and contours."""

_LIMIT_Z = 6.5
"""Place of regions and barriers in the stack, above particles and contours."""

_START_Z = 7.0
"""Place of starts in the stack."""

_CHARGE_Z = 7.6
"""Place of placed charges in the stack."""

_DRAFT_Z = 8.0
"""Place of drafts in the stack."""

_BEHIND_RUN_OPACITY = 0.45
"""Opacity of starts behind a run."""

_COMPUTED_OPACITY = 0.55
"""Opacity of particles computed from the image."""

_CHARGE_DIAMETER = 18.0
"""Diameter of the disc of a charge of strength 0 [px of the screen]."""

_DIAMETER_PER_STRENGTH = 2.0
"""Increase of the diameter per unit of strength [px of the screen]."""

_CHARGE_SIGN_SIZE = 11.0
"""Size of the sign of a charge [px of the screen]."""

_SEED_DIAMETERS: dict[SeedingKind | None, float] = {"grid": 4.0, "gradient": 3.0, "centers": 6.0, None: 3.0}
"""Diameters of computed particles [px of the screen], smaller for kinds with many; None means areas."""

_Line = Circle | Ellipse | Polygon | Stroke | Sphere | Box
"""Starts that are shown as lines with their particles."""

_Area = Grid | Threshold | BoxGrid | BoxThreshold
"""Starts that are shown as areas with their particles."""

# pyqtgraph caches the picture of a symbol by its brush and pen objects, so equal colors must share them
_cached_brush = lru_cache(pg.mkBrush)
_cached_pen = lru_cache(pg.mkPen)


class RegionVeil(ImageOverlay):
    """A veil over the image outside the regions of interest."""

    count = 0

    def __init__(self) -> None:
        super().__init__(_VEIL_Z, 0.0)
        self._veil = QPainterPath()
        enable_caching(self)

    def show_regions(self, regions: list[Section]) -> None:
        """Dim everything outside the regions; without regions, dim nothing."""
        if not regions and not self.count:
            return
        self._veil = QPainterPath()
        if regions:
            self._veil.addRect(self._room)
            for outline in _shape_outlines(regions, Interest):
                inside = pg.arrayToQPath(*map(np.ascontiguousarray, to_xy(outline)))
                # A self-crossing path has no holes: by this rule, everything that it winds around is inside.
                inside.setFillRule(Qt.FillRule.WindingFill)
                self._veil = self._veil.subtracted(inside)
        self.update_count(len(regions))

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Draw the veil."""
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.fillPath(self._veil, QColor(theme.DIMMED_COLOR))


class DraftItems:
    """A path with its corners, the closing segment of a closed path, and the ring of a tool."""

    def __init__(self, view: pg.ViewBox) -> None:
        self.path, self._closing, self._ring = (pg.PlotCurveItem(antialias=True) for _ in range(3))
        self._corners = Markers(
            _DRAFT_Z + 0.5, size=6.0, symbol="s", pen=pg.mkPen(theme.CANVAS_HALO_COLOR), brush=pg.mkBrush("w")
        )
        for item in (self.path, self._closing, self._ring):
            item.setZValue(_DRAFT_Z)
            item.hide()
        for item in (self.path, self._closing, self._ring, self._corners):
            view.addItem(item, ignoreBounds=True)

    def show_path(self, corners: Array, path: Array, color: str, closed: bool) -> None:
        """Show a path with corners, each of shape (K, 2)."""
        _draw_path(self.path, path, color, 2.0, 4.0)
        dashed = line_pen(color, 1.4, "shapes")
        dashed.setStyle(Qt.PenStyle.DashLine)
        self._closing.setPen(dashed)
        self._closing.setData(*to_xy(path[[-1, 0]] if closed and len(path) > 2 else path[:0]))
        self._closing.setVisible(closed)
        self._corners.show_markers(corners)

    def show_ring(self, rim: Array, color: str) -> None:
        """Show the ring of a tool, shape (K, 2); an empty array hides it."""
        _draw_path(self._ring, rim, color, 1.6, 3.4)


def _draw_path(item: pg.PlotCurveItem, path: Array, color: str, width: float, halo: float) -> None:
    """Draw a path, shape (K, 2), with a halo."""
    item.setPen(line_pen(color, width, "shapes"))
    item.setShadowPen(line_pen(theme.CANVAS_HALO_COLOR, halo, "shapes"))
    item.setData(*to_xy(path))
    item.setVisible(len(path) > 0)


class DrawingLayer(Layer):
    """Shapes of the document; starts are opaque before a run and faint behind one.

    Limits and placed charges stay visible during a run, because they always act. The disc of a charge grows with its
    strength; a thin ring shows where its force is largest, a dashed ring around the selected charge where it vanishes.
    """

    name = "drawing"
    title = tr("Drawing")
    tip = tr("What a run starts from, regions of interest, barriers and placed charges.")
    shortcut = "Alt+6"
    draft_shown = Signal(object, object, str, bool)
    """Another draft is shown: the arguments of `show_draft`."""
    ring_shown = Signal(object, float, str, object)
    """Another ring is shown: the arguments of `show_ring`."""
    colors = (
        theme.DRAWING_COLOR,
        theme.REGION_COLOR,
        theme.BARRIER_COLOR,
        theme.ATTRACTING_COLOR,
        theme.REPELLING_COLOR,
    )

    def create_items(self) -> None:
        """Create the items of the layer."""
        self._lines = _create_shape_curves(theme.DRAWING_COLOR, _START_Z, 1.4)
        self._selected_lines = _create_shape_curves(theme.SELECTED_COLOR, _START_Z + 0.1, 2.2)
        self._areas = _create_shape_curves(theme.DRAWING_COLOR, _START_Z, 1.2, dashed=True)
        self.computed = {
            kind: Discs(theme.MOVING_COLOR, diameter, _START_Z + 0.2) for kind, diameter in _SEED_DIAMETERS.items()
        }
        self._seeds = Discs(theme.MOVING_COLOR, 6.0, _START_Z + 0.6)
        self._selected_points = Discs(theme.SELECTED_COLOR, 9.0, _START_Z + 0.7)
        self._handles = Markers(
            _START_Z + 0.8,
            size=10.0,
            symbol="s",
            pen=pg.mkPen(theme.CANVAS_HALO_COLOR, width=1.2),
            brush=pg.mkBrush(theme.SELECTED_COLOR),
        )
        self._starts = (self._lines, self._areas, self._seeds, self._selected_points)
        self._dim = RegionVeil()
        self._regions = _create_shape_curves(theme.REGION_COLOR, _LIMIT_Z, 1.8)
        self._barriers = _create_shape_curves(theme.BARRIER_COLOR, _LIMIT_Z + 0.1, 3.6, halo=5.6)
        self._rings = _create_shape_curves(theme.ATTRACTING_COLOR, _CHARGE_Z - 0.2, 1.8)
        self._reach = _create_shape_curves(theme.SELECTED_COLOR, _CHARGE_Z - 0.1, 1.2, halo=2.6, dashed=True)
        self._charges = Markers(_CHARGE_Z, size=_CHARGE_DIAMETER)
        self._signs = Markers(_CHARGE_Z + 0.1, size=_CHARGE_SIGN_SIZE, pen=None, brush=pg.mkBrush("w"))
        self.add_items(
            self._lines, self._areas, self._selected_lines, *self.computed.values(), self._seeds, self._selected_points
        )
        self.add_items(self._handles, self._dim, self._regions, self._barriers, self._rings, self._reach)
        self.add_items(self._charges, self._signs)
        self._draft = DraftItems(self.view)
        self._hides_computed = False

    @property
    def selected_shape(self) -> Section | None:
        """Selected shape, in a volume its section."""
        shapes, index = self._shapes, self.scene.selected_shape
        return shapes[index] if index is not None and index < len(shapes) else None

    @property
    def _shapes(self) -> tuple[Section, ...]:
        """Shapes that are shown, in a volume their sections."""
        return self.scene.document.shapes

    def set_image_shape(self, shape: Extent) -> None:
        """Fit the items to an image of this shape, with a rim for shapes beyond its border."""
        for item, _ in self._items:
            if isinstance(item, ImageOverlay):
                item.set_image_shape(shape, 0.0 if item is self._dim else float(max(shape)) + CHARGE_REACH)

    def show_scene(self, before: Scene) -> None:
        """Show other shapes, another selection, or fainter starts behind a run."""
        scene = self.scene
        others = scene.document.shapes is not before.document.shapes
        if others or (scene.selected_shape, scene.has_particles) != (before.selected_shape, before.has_particles):
            self._show_starts()
            self._show_limits_and_charges()
            self.apply_opacity()
        elif scene.image_seeds is not before.image_seeds:
            self._show_computed()

    def hide_computed(self, hides: bool) -> None:
        """Hide the seeds computed from the image, which would lie over what is clicked, or show them again."""
        self._hides_computed = hides
        self._show_computed()

    def show_draft(
        self,
        corners: Sequence[Place] = (),
        path: Sequence[Place] | Array = (),
        color: str = theme.DRAWING_COLOR,
        closed: bool = False,
    ) -> None:
        """Show the draft of a path; without arguments, hide it.

        Parameters
        ----------
        corners : sequence of tuple of float
            Corners that are marked: (row, col) in an image or slice, (plane, row, col) in a volume [px].
        path : sequence of tuple of float or ndarray, shape (K, 2) or (K, 3)
            Vertices of the path, in the same coordinates.
        color : str
            Color of the path.
        closed : bool
            Whether to draw the closing segment.
        """
        self._draft.show_path(self._flatten_places(corners), self._flatten_places(path), color, closed)
        self.draft_shown.emit(corners, path, color, closed)

    def show_ring(
        self,
        center: Place | None = None,
        radius: float = 0.0,
        color: str = theme.DRAWING_COLOR,
        axis: int | None = None,
    ) -> None:
        """Show the ring of a tool, or hide it if `center` is None.

        In a volume it is the section of a ball with a radius in smallest sides of a voxel; with `axis`, only slices
        across that axis show it.
        """
        here = None if self.scene.slices is None else self.scene.slices.axis
        self._draft.show_ring(self._ring_outline(center if axis in (None, here) else None, radius), color)
        self.ring_shown.emit(center, radius, color, axis)

    def _flatten_places(self, places: Sequence[Place] | Array) -> Array:
        """Return places as (row, col) in the slice that is shown, shape (K, 2)."""
        if not len(places):
            return NO_POINTS
        slices, flat = self.scene.slices, np.array(places, dtype=float)
        return flat if slices is None or flat.shape[1] == 2 else slices.current.project_points(flat)

    def _ring_outline(self, center: Place | None, radius: float) -> Array:
        """Return the outline of a ring, shape (K, 2), empty if there is none."""
        if center is None:
            return NO_POINTS
        slices, volume = self.scene.slices, self.scene.volume
        if slices is None or volume is None or len(center) == 2:
            return Circle(center, radius).outline
        line = cut_sphere(Sphere.from_voxel_size(center, radius, volume.spacing), slices.current)
        return NO_POINTS if line is None else line.outline

    def _show_starts(self) -> None:
        """Show lines, areas and handles; hide the seeds during a run, because they would cover its particles."""
        selected, shapes = self.selected_shape, self._shapes
        rest = [shape for shape in shapes if shape is not selected]
        self._lines.show_paths(_shape_outlines(rest, _Line))
        self._areas.show_paths(_shape_outlines(rest, _Area))
        chosen = [] if selected is None else [selected]
        self._selected_lines.show_paths(_shape_outlines(chosen, _Line | _Area | Limit | Measure))
        # A selected circle shows handles; a selected stroke can be recognized only by its particles.
        pointed = _shape_seeds(chosen, Points | Stroke)
        self._selected_points.show_discs(pointed)
        seen = () if self.scene.has_particles else rest if len(pointed) else shapes
        self._seeds.show_discs(_shape_seeds(seen, _Line | Points | Grid | BoxGrid))
        self._handles.show_markers(selected.handles() if selected else ())
        self._show_computed()

    def _show_computed(self) -> None:
        """Show the seeds computed from the image."""
        seeds = {} if self.scene.has_particles or self._hides_computed else self.scene.image_seeds
        starts = [start for start in self.scene.document.image_starts if start in seeds]
        for kind, discs in self.computed.items():
            discs.show_discs(
                _concatenate_positions([seeds[start] for start in starts if getattr(start, "kind", None) == kind])
            )

    def _show_limits_and_charges(self) -> None:
        """Show regions, barriers and placed charges."""
        selected, shapes = self.selected_shape, self._shapes
        regions = [shape for shape in shapes if isinstance(whole_shape(shape), Interest)]
        self._dim.show_regions(regions)
        self._regions.show_paths(_shape_outlines(regions, Interest))
        self._barriers.show_paths(_shape_outlines(shapes, Barrier))
        found = [(shape, whole) for shape in shapes if isinstance(whole := whole_shape(shape), Charge)]
        rings = [(self._ring_outline(whole.position, CHARGE_RADIUS), _charge_color(whole)) for _, whole in found]
        self._rings.show_paths([ring for ring, _ in rings], [color for _, color in rings])
        reaching = [whole.position for shape, whole in found if shape is selected]
        self._reach.show_paths([self._ring_outline(position, CHARGE_REACH) for position in reaching])
        found = [(shape, whole) for shape, whole in found if shape is whole or len(shape.outline)]
        charges = [whole for _, whole in found]
        places = self._flatten_places([charge.position for charge in charges])
        rims = [
            _cached_pen(theme.SELECTED_COLOR, width=2.6)
            if shape is selected
            else _cached_pen(theme.CANVAS_HALO_COLOR, width=1.4)
            for shape, _ in found
        ]
        self._charges.show_markers(
            places,
            size=[_CHARGE_DIAMETER + _DIAMETER_PER_STRENGTH * abs(charge.strength) for charge in charges],
            brush=[_cached_brush(_charge_color(charge)) for charge in charges],
            pen=rims,
        )
        self._signs.show_markers(places, symbol=["+" if charge.strength > 0.0 else "_" for charge in charges])

    def apply_opacity(self) -> None:
        """Set the opacity; starts are faint behind a run."""
        super().apply_opacity()
        selected = self.selected_shape
        if self.scene.has_particles and not isinstance(whole_shape(selected), Start):
            for item in self._starts:
                item.setOpacity(self.opacity * _BEHIND_RUN_OPACITY)
        for kind, discs in self.computed.items():
            strong = isinstance(selected, Threshold) if kind is None else selected == Everywhere(kind)
            discs.setOpacity(self.opacity * (1.0 if strong else _COMPUTED_OPACITY))


def _create_shape_curves(color: str, z: float, width: float, halo: float = 3.6, dashed: bool = False) -> Curves:
    """Create curves with the line width preferred for shapes."""
    return Curves(color, z, width, halo, dashed, "shapes")


def _shape_outlines(shapes: Sequence[Section], kinds: Any) -> list[Array]:
    """Return the outlines, each of shape (K, 2), of shapes of some kinds; a region in other slices has none."""
    found = (shape.outline for shape in shapes if isinstance(whole_shape(shape), kinds))
    return [np.array(outline) for outline in found if len(outline)]


def _charge_color(charge: Charge) -> str:
    return theme.ATTRACTING_COLOR if charge.strength > 0.0 else theme.REPELLING_COLOR


def _shape_seeds(shapes: Sequence[Any], kinds: Any) -> Array:
    """Return the particles, shape (N, 2), of shapes of some kinds, all of which have particles."""
    return _concatenate_positions([shape.seeds() for shape in shapes if isinstance(whole_shape(shape), kinds)])


def _concatenate_positions(positions: Sequence[Array]) -> Array:
    return np.concatenate([NO_POINTS, *positions])
