"""The layers of the canvas, from the image below to the drawing on top."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeVar

import pyqtgraph as pg

from cpm_app.session.scene import Scene
from cpm_app.session.session import Session
from cpm_app.views.layers.annotations import OrientationLayer, ScaleBarLayer
from cpm_app.views.layers.contours import ContourLayer, TruthLayer
from cpm_app.views.layers.drawing import DrawingLayer
from cpm_app.views.layers.fields import EdgeMapLayer, FieldLayer, PotentialLayer, StartAreaLayer
from cpm_app.views.layers.forces import ForceLayer
from cpm_app.views.layers.image_layer import ImageLayer
from cpm_app.views.layers.layer import Layer, LegendEntry
from cpm_app.views.layers.measures import MeasureLayer
from cpm_app.views.layers.objects import ObjectLayer
from cpm_app.views.layers.particles import ParticleLayer
from cpm_app.views.layers.second_image import SecondImageLayer
from cpm_app.views.layers.skeleton import SkeletonLayer

L = TypeVar("L", bound=Layer)

LAYER_CLASSES: tuple[type[Layer], ...] = (
    ParticleLayer,
    ForceLayer,
    ContourLayer,
    ObjectLayer,
    TruthLayer,
    SkeletonLayer,
    DrawingLayer,
    MeasureLayer,
    StartAreaLayer,
    EdgeMapLayer,
    PotentialLayer,
    FieldLayer,
    SecondImageLayer,
    ImageLayer,
    ScaleBarLayer,
    OrientationLayer,
)
"""All layers in the order of panel and menu; each sets its own place in the stack."""


class Layers:
    """The layers of one canvas by name; `view` is the parent of their items, `session` has the worker that they ask."""

    def __init__(self, view: pg.ViewBox, session: Session | None) -> None:
        self._layers = {kind.name: kind(view, session) for kind in LAYER_CLASSES}
        self.particles = self._get_layer(ParticleLayer)
        self.forces = self._get_layer(ForceLayer)
        self.contours = self._get_layer(ContourLayer)
        self.drawing = self._get_layer(DrawingLayer)
        self.measures = self._get_layer(MeasureLayer)
        self.image = self._get_layer(ImageLayer)

    def __getitem__(self, name: str) -> Layer:
        return self._layers[name]

    def __iter__(self) -> Iterator[Layer]:
        return iter(self._layers.values())

    def draw_scene(self, scene: Scene) -> None:
        """Draw a scene."""
        for layer in self:
            layer.set_scene(scene)

    def collect_legend_entries(self) -> list[LegendEntry]:
        """Collect the entries of all visible layers: contours and ground truth first, then the rest."""
        first = (self.contours, self["truth"])
        rest = [layer for layer in self if layer not in first]
        return [entry for layer in (*first, *rest) if layer.shown for entry in layer.legend_entries()]

    def _get_layer(self, kind: type[L]) -> L:
        layer = self._layers[kind.name]
        assert isinstance(layer, kind)
        return layer
