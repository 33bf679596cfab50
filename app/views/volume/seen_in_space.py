"""What a scene with a volume shows in space; parts are made again only when they have changed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from PySide6.QtGui import QColor

from app.model.display.coloring import QUANTITIES, SHADES, InsertionTimes, colored
from app.model.display.space.picture import Colors
from app.model.display.space.triangles import Mesh
from app.model.display.space.view_in_space import ColoredMesh, Particles, ViewInSpace, Wires
from app.model.display.space.voxels import Shaded
from app.model.volume.shape_sections import wires
from app.session.exchange.messages import Reconstruction, Snapshot
from app.session.features.background import IdentityCache
from app.session.scene import Proposal, Scene
from app.views.canvas.layers import Layers
from app.views.canvas.layers.particles import BEGIN, UNKNOWN, ParticleLayer
from app.views.canvas.layers.skeleton import banded
from app.views.theme import color_maps, theme
from app.views.theme.theme import Ink, look
from cpm_core.contours.ground_truth import Truth, VolumeTruth
from cpm_core.contours.surface import Surface
from cpm_core.image.image import Image
from cpm_core.medial_axis.skeleton import Skeleton
from cpm_core.objects.segmented.segmented_object import SegmentedObjects
from cpm_core.objects.volume_partition import VolumeSelection
from cpm_core.shapes import Charge, Interest, Limit, Shape


class SeenInSpace:
    """Makes the view in space of the scenes of a session."""

    def __init__(self) -> None:
        self._parts = IdentityCache()

    def of(self, scene: Scene, layers: Layers) -> ViewInSpace | None:
        """What a scene shows; particles, gray values and what is drawn as their layers show them on the canvas."""
        image, slices, snapshot, found = scene.image, scene.slices, scene.snapshot, scene.reconstruction
        if image is None or slices is None:
            self._parts.forget()
            return None
        layer, window = layers.particles, layers.image.shown_window
        inks = tuple(look().color(ink) for ink in (theme.MOVING, theme.RESTING))
        given = snapshot, layer.word("colour"), layer.word("map"), layer.word("done"), inks
        shaded = self._parts.named("shaded", lambda: Shaded(image.values, window), image, window)
        particles = self._parts.named("particles", lambda: _particles(snapshot, layer), *given)
        mesh = self._parts.get(_mesh, found)
        drawn = (scene.document.shapes if layers.drawing.shown else (), scene.selected, image)
        skeleton = scene.skeleton if layers["skeleton"].shown else None
        lines = self._parts.get(_wires, *drawn, skeleton)
        of, offered = scene.document.objects, scene.objects.proposals
        selected = (of, offered, image.spacing) if layers["objects"].shown else None
        objects = self._parts.named("objects", lambda: () if selected is None else tuple(_objects(*selected)), selected)
        known = (scene.truth if layers["truth"].shown else None, image.spacing)
        truth = self._parts.get(_truth, *known)
        return self._parts.named(
            "contents",
            lambda: ViewInSpace(image, shaded, slices, particles, mesh, lines, layers.image.table, objects, truth),
            *(image, slices, shaded, particles, mesh, lines, layers.image.word("map"), objects, truth),
        )


def _particles(snapshot: Snapshot | None, layer: ParticleLayer) -> Particles | None:
    size = 1.0 if snapshot is None else layer.size_of(snapshot)
    if snapshot is None or size == 0.0:
        return None
    if layer.word("colour") not in QUANTITIES:
        inks = np.array([_rgb(theme.MOVING), _rgb(theme.RESTING)], np.uint8)
        return Particles(snapshot.position, inks[snapshot.resting.astype(np.intp)], size)
    times = InsertionTimes(snapshot.metrics.step, snapshot.metrics.numbered)
    marks = colored(QUANTITIES[layer.word("colour")], snapshot.state, times).marks
    palette = np.vstack([color_maps.table(layer.word("map"), SHADES, BEGIN), _rgb(UNKNOWN)]).astype(np.uint8)
    return Particles(snapshot.position, palette[marks], size)


def _mesh(found: Reconstruction | None) -> Mesh | None:
    surface = getattr(found.result, "surface", None) if found is not None else None
    return None if surface is None or not len(surface.faces) else Mesh(surface)


def _objects(
    objects: SegmentedObjects, offered: tuple[Proposal, ...], spacing: tuple[float, ...]
) -> Iterator[ColoredMesh]:
    """The objects but hidden ones and the one that is being changed, and those that are offered."""
    for item in objects.items:
        if item.body is not None and not item.hidden and item.number != objects.edited:
            yield _colored(item.body, spacing, objects.color(item))
    for each in offered:
        if isinstance(each.selection, VolumeSelection) and each.selection.found:
            yield _colored(each.selection.surface, spacing, theme.CHOSEN)


def _truth(truth: Truth | VolumeTruth | None, spacing: tuple[float, ...]) -> tuple[ColoredMesh, ...]:
    return (_colored(truth.surface, spacing, theme.TRUTH),) if isinstance(truth, VolumeTruth) else ()


def _colored(surface: Surface, spacing: tuple[float, ...], ink: Ink | str) -> ColoredMesh:
    red, green, blue = _rgb(ink).tolist()
    return ColoredMesh(Mesh(replace(surface, spacing=spacing)), (red, green, blue))


def _wires(
    shapes: tuple[Shape, ...], selected: int | None, image: Image, skeleton: Skeleton | None = None
) -> Wires | None:
    sides = tuple(side / min(image.spacing) for side in image.spacing)
    ends = [wires(shape, sides) for shape in shapes]
    inks = [_rgb(theme.CHOSEN if index == selected else _ink(shape)) for index, shape in enumerate(shapes)]
    colors = [np.tile(ink, (len(each), 1)) for ink, each in zip(inks, ends, strict=True)]
    if skeleton is not None:
        bands = [_rgb(color) for color in theme.THICKNESSES]
        for band, piece in banded(skeleton, len(bands)):
            ends.append(np.stack([piece[:-1], piece[1:]], axis=1))
            colors.append(np.tile(bands[band], (len(piece) - 1, 1)))
    return Wires(np.concatenate(ends), np.concatenate(colors).astype(np.uint8)) if any(map(len, ends)) else None


def _ink(shape: Shape) -> Ink | str:
    if isinstance(shape, Charge):
        return theme.ATTRACTING if shape.strength > 0.0 else theme.REPELLING
    return theme.REGION if isinstance(shape, Interest) else theme.BARRIER if isinstance(shape, Limit) else theme.MOVING


def _rgb(ink: Ink | str) -> Colors:
    color = QColor(look().color(ink))
    return np.array([color.red(), color.green(), color.blue()], np.uint8)
