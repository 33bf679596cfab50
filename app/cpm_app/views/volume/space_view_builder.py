"""The view in space of a scene with a volume; only parts that have changed are built again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from types import MappingProxyType
from weakref import WeakKeyDictionary

import numpy as np
from PySide6.QtGui import QColor

from cpm_app.model.display.coloring import QUANTITIES, color_particles
from cpm_app.model.display.display_image import IntensityWindow
from cpm_app.model.display.second_image import SecondImage
from cpm_app.model.space.triangles import SurfaceMesh
from cpm_app.model.space.view_in_space import ColoredMesh, Overlay, ShownParticles, ViewInSpace, Wires
from cpm_app.model.space.voxels import ShadedVolume
from cpm_app.model.volume.shape_sections import build_shape_wires
from cpm_app.session.exchange.messages import Reconstruction, Snapshot
from cpm_app.session.features.background import IdentityCache
from cpm_app.session.scene import Proposal, Scene
from cpm_app.views.layers import Layers
from cpm_app.views.layers.particles import build_quantity_palette
from cpm_app.views.layers.second_image import SecondImageLayer
from cpm_app.views.layers.skeleton import split_skeleton_by_thickness
from cpm_app.views.theme import color_maps, theme
from cpm_app.views.theme.theme import Ink, get_canvas_style
from cpm_core import Image, Skeleton, Surface, Truth, VolumeTruth
from cpm_core.numerics.polyline import pair_neighbors
from cpm_core.numerics.types import Numbers, Pixels, Sides
from cpm_core.objects.segmented import SegmentedObject, SegmentedObjects
from cpm_core.shapes import Charge, Interest, Limit, Measure, Shape, relative_sides

_ALL_SHADES = IntensityWindow(0.0, 255.0)
"""The window in which shades stay as they are."""

_NO_SURFACES: Mapping[int, Surface] = MappingProxyType({})
"""No surfaces of painted objects."""


class SpaceViewBuilder:
    """Builds the view in space of the scenes of a session."""

    def __init__(self) -> None:
        self._parts = IdentityCache()

    def build_view(
        self, scene: Scene, layers: Layers, bodies: Mapping[int, Surface] = _NO_SURFACES
    ) -> ViewInSpace | None:
        """Build the view in space of a scene, with the settings of the layers on the canvas; None without a volume.

        `bodies` are the surfaces of painted objects by object number, which another thread computes.
        """
        image, slices, snapshot, found = scene.image, scene.slices, scene.snapshot, scene.reconstruction
        if image is None or slices is None:
            self._parts.clear()
            return None
        get, layer, spacing = self._parts.get, layers.particles, image.spacing
        size = layer.diameter_factor(snapshot)
        inks = (
            get_canvas_style().resolve_color(theme.MOVING_COLOR),
            get_canvas_style().resolve_color(theme.RESTING_COLOR),
        )
        objects = scene.document.objects if layers["objects"].shown else None
        drawn = scene.document.shapes if layers.drawing.shown else ()
        return get(
            ViewInSpace,
            image,
            get(ShadedVolume, image.values, layers.image.shown_window),
            slices,
            get(_build_particles, snapshot, size, layer.get_choice("colour"), inks),
            get(_build_surface_mesh, found),
            get(_build_wires, drawn, scene.selected_shape, image, scene.skeleton if layers["skeleton"].shown else None),
            layers.image.color_table,
            self._build_overlays(scene.second, layers),
            get(_build_object_meshes, objects, scene.objects.proposals, spacing, bodies),
            get(_build_truth_mesh, scene.truth if layers["truth"].shown else None, spacing),
        )

    def _build_overlays(self, second: SecondImage | None, layers: Layers) -> tuple[Overlay, ...]:
        """Build the other channels of a composite, and the second image with the opacity of its layer."""
        get, layer = self._parts.get_named, layers["second"]
        shown: list[tuple[object, Numbers, IntensityWindow, Pixels]] = [
            (index, image.stored, window, color_maps.ramp_table(color))
            for index, (image, window, color) in layers.image.shown_channels.items()
        ]
        if second is not None and layer.shown and isinstance(layer, SecondImageLayer):
            table = self._parts.get(_fade_table, layer.color_table, layer.opacity)
            shown.append(("second", second.shades, _ALL_SHADES, table))
        overlays: list[Overlay] = []
        for name, values, window, table in shown:
            shaded = get(("shaded", name), partial(ShadedVolume, values, window), values, window)
            overlays.append(get(("overlay", name), partial(Overlay, shaded, table), shaded, table))
        return tuple(overlays)


def _fade_table(table: Pixels, opacity: float) -> Pixels:
    """Make the colors of a table, shape (256, 4), more transparent, and multiply them by their opacity."""
    share = opacity * table[:, 3:] / 255.0
    return np.rint(share * np.column_stack([table[:, :3], np.full(len(table), 255)])).astype(np.uint8)


def _build_particles(
    snapshot: Snapshot | None, size: float, quantity: str, inks: tuple[str, str]
) -> ShownParticles | None:
    if snapshot is None:
        return None
    palette: Sequence[str] = inks
    marks = snapshot.resting.astype(np.uint8)
    if quantity in QUANTITIES:
        marks, _ = color_particles(QUANTITIES[quantity], snapshot.state, snapshot.metrics)
        palette = build_quantity_palette()
    return ShownParticles(snapshot.position, np.array([*map(_to_rgb, palette)])[marks], size)


def _build_surface_mesh(found: Reconstruction | None) -> SurfaceMesh | None:
    surface = found.result.surface if found is not None else None
    return None if surface is None or not len(surface.faces) else SurfaceMesh(surface)


def _build_object_meshes(
    objects: SegmentedObjects | None,
    offered: tuple[Proposal, ...],
    spacing: Sides,
    bodies: Mapping[int, Surface],
) -> tuple[ColoredMesh, ...]:
    """Build the meshes of the objects, except hidden and edited ones, and of the proposals."""
    if objects is None:
        return ()
    seen = [item for item in objects.items if not item.hidden and item.number != objects.edited]
    shown = [(_find_body(item, bodies), objects.color_of(item), item.opacity) for item in seen]
    found = [each.selection.surface for each in offered]
    shown += [(surface, theme.PROPOSAL_COLOR, 1.0) for surface in found]
    return tuple(_color_surface(body, spacing, color, faded) for body, color, faded in shown if body is not None)


def _find_body(item: SegmentedObject, bodies: Mapping[int, Surface]) -> Surface | None:
    """Return the surface of an object: the last one known while a painted one is computed."""
    known = item.region.surface
    return known if item.region.pixels is None else bodies.get(item.number, known)


def _build_truth_mesh(truth: Truth | VolumeTruth | None, spacing: Sides) -> tuple[ColoredMesh, ...]:
    return (_color_surface(truth.surface, spacing, theme.TRUTH_COLOR),) if isinstance(truth, VolumeTruth) else ()


_MESH_CACHE: WeakKeyDictionary[Surface, SurfaceMesh] = WeakKeyDictionary()
"""Meshes of surfaces that are still in use."""


def _color_surface(surface: Surface, spacing: Sides, ink: Ink | str, opacity: float = 1.0) -> ColoredMesh:
    """Color a surface; reuse its mesh, with the normals, from the last view."""
    mesh = _MESH_CACHE.get(surface)
    if mesh is None or mesh.surface.spacing != spacing:
        mesh = _MESH_CACHE[surface] = SurfaceMesh(replace(surface, spacing=spacing))
    red, green, blue = _to_rgb(ink).tolist()
    return ColoredMesh(mesh, (red, green, blue), (red, green, blue), opacity)


def _build_wires(
    shapes: tuple[Shape, ...], selected: int | None, image: Image, skeleton: Skeleton | None = None
) -> Wires | None:
    sides = relative_sides(image.spacing)
    ends = [build_shape_wires(shape, sides) for shape in shapes]
    colors = []
    for index, (shape, each) in enumerate(zip(shapes, ends, strict=True)):
        ink: Ink | str = theme.REGION_COLOR if isinstance(shape, Interest) else theme.MOVING_COLOR
        if isinstance(shape, Charge):
            ink = theme.ATTRACTING_COLOR if shape.strength > 0.0 else theme.REPELLING_COLOR
        elif isinstance(shape, Measure):
            ink = theme.MEASURE_COLOR
        elif isinstance(shape, Limit) and not isinstance(shape, Interest):
            ink = theme.BARRIER_COLOR
        colors.append(np.tile(_to_rgb(theme.SELECTED_COLOR if index == selected else ink), (len(each), 1)))
    if skeleton is not None:
        bands = [_to_rgb(color) for color in theme.THICKNESS_COLORS]
        for band, piece in split_skeleton_by_thickness(skeleton, len(bands)):
            ends.append(pair_neighbors(piece))
            colors.append(np.tile(bands[band], (len(piece) - 1, 1)))
    return Wires(np.concatenate(ends), np.concatenate(colors).astype(np.uint8)) if any(map(len, ends)) else None


def _to_rgb(ink: Ink | str) -> Pixels:
    color = QColor(get_canvas_style().resolve_color(ink))
    return np.array([color.red(), color.green(), color.blue()], np.uint8)
