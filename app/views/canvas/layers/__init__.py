"""The layers of the canvas, from the image below to the drawing on top."""

from __future__ import annotations

from collections.abc import Iterator

import pyqtgraph as pg
from PySide6.QtWidgets import QWidget

from app.session.scene import Scene
from app.views.canvas.layers.contours.contours import ContourLayer
from app.views.canvas.layers.contours.skeleton import SkeletonLayer
from app.views.canvas.layers.contours.truth import TruthLayer
from app.views.canvas.layers.drawn.drawing import DrawingLayer
from app.views.canvas.layers.fields.field import FieldLayer
from app.views.canvas.layers.fields.scalar import EdgeMapLayer, PotentialLayer
from app.views.canvas.layers.image.image import ImageLayer
from app.views.canvas.layers.image.image_form import ImageForm
from app.views.canvas.layers.image.scale_bar import ScaleBarLayer
from app.views.canvas.layers.layer import Layer, Requests
from app.views.canvas.layers.layer_form import LayerForm
from app.views.canvas.layers.particles.forces import ForceLayer
from app.views.canvas.layers.particles.ghost import GhostLayer
from app.views.canvas.layers.particles.particles import ParticleLayer
from app.views.canvas.layers.particles.trails import TrailLayer

LAYERS: tuple[type[Layer], ...] = (
    ParticleLayer,
    TrailLayer,
    ForceLayer,
    ContourLayer,
    GhostLayer,
    TruthLayer,
    SkeletonLayer,
    DrawingLayer,
    EdgeMapLayer,
    PotentialLayer,
    FieldLayer,
    ImageLayer,
    ScaleBarLayer,
)
"""All layers in the order in which panel and menu list them; where they lie in the pile they know themselves."""


class Layers:
    """The layers of one canvas by name.

    Parameters
    ----------
    view : pg.ViewBox
        Where they lie.
    requests : Requests
        Where they ask for what the worker makes.
    """

    def __init__(self, view: pg.ViewBox, requests: Requests) -> None:
        self._layers = {kind.name: kind(view, requests) for kind in LAYERS}

    def __getitem__(self, name: str) -> Layer:
        return self._layers[name]

    def __iter__(self) -> Iterator[Layer]:
        return iter(self._layers.values())

    def draw(self, scene: Scene) -> None:
        """Draw a scene."""
        for layer in self:
            layer.draw(scene)

    @property
    def particles(self) -> ParticleLayer:
        """The particles."""
        layer = self._layers["particles"]
        assert isinstance(layer, ParticleLayer)
        return layer

    @property
    def forces(self) -> ForceLayer:
        """The forces on the particle under the pointer."""
        layer = self._layers["forces"]
        assert isinstance(layer, ForceLayer)
        return layer

    @property
    def contours(self) -> ContourLayer:
        """The contours."""
        layer = self._layers["contours"]
        assert isinstance(layer, ContourLayer)
        return layer

    @property
    def drawing(self) -> DrawingLayer:
        """What is drawn."""
        layer = self._layers["drawing"]
        assert isinstance(layer, DrawingLayer)
        return layer


def form_of(layer: Layer) -> QWidget:
    """A form for what can be chosen about a layer, made anew at each call."""
    return ImageForm(layer) if isinstance(layer, ImageLayer) else LayerForm(layer)
