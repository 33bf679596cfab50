"""Widget for napari: objects at points by the network, and runs from shapes, with layers in and layers out."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np
from magicgui.widgets import ComboBox, Container, FloatSlider, Label, PushButton, create_widget
from napari import Viewer
from napari.layers import Image, Labels, Layer, Points, Shapes
from napari.qt.threading import GeneratorWorker, create_worker
from qtpy.QtWidgets import QLineEdit

import cpm_core as cpm
from cpm_app.napari import finding
from cpm_app.napari.layers import (
    Frame,
    LayerData,
    build_result_layers,
    lines_from_shapes,
    place_in_stack,
    prepend_frame,
    put_into,
)
from cpm_core.image.drawing import PARTICLE_COLOR
from cpm_core.numerics import Array
from cpm_core.numerics.types import JsonDict
from cpm_core.objects.prior.larger_models import is_fetched

FIND_OBJECTS = "Objects at the points"
"""Choice that finds an object at each point."""

RUN_FROM_SHAPES = "Run from the shapes"
"""Choice that starts particles along the shapes."""

_SLIDER_NAMES = ("beta", "w1", "w2", "annealing")
"""Parameters with a slider."""

_PLACING_ATTRIBUTES = ("scale", "translate", "rotate", "shear", "affine")
"""Attributes of a layer that determine its place in the viewer."""

_PARTICLE_LAYER = "particles"
"""Name of the layer of particles during a run."""

_MIN_NUMBER_WIDTH = 40
"""Smallest width of the field of a slider's number [px]; 1 in the style of napari."""

_EXTENTS = [("The image in view", 2), ("The volume in view", 3)]
"""What is searched in a layer of more axes: titles, and how many axes from the last one on."""

_TIME_NAMES = ("t", "time", "frame")
"""Names of an axis that is no depth."""

_LAYER_CHOICES = {
    "points": (Points, "Points inside", "Each point lies in an object of its own."),
    "outside": (Points | None, "Points outside", "No object reaches these points."),
    "shapes": (
        Shapes | None,
        "Shapes",
        "Objects: closed shapes are boxes around them, lines lie in them. Run: particles start along the shapes.",
    ),
    "objects": (
        Labels | None,
        "Labels",
        "Objects: the points correct the label that is selected in this layer. "
        "Run: particles start along the boundaries of the labels.",
    ),
}
"""Layers that can be selected in addition to the image: name -> kind of layer, title and explanation."""


class FindWidget(Container):  # type: ignore[misc, type-arg, unused-ignore]
    """Choose an image, and layers that determine what to find in it."""

    def __init__(self, napari_viewer: Viewer) -> None:
        self._viewer = napari_viewer
        self._worker: GeneratorWorker[finding.WorkProgress, None, list[LayerData] | str] | None = None
        self._parameters = cpm.Parameters()
        self._found_in: Frame = ()
        self.button, self.message = PushButton(text="Find"), Label(value="")
        self.sliders = [
            FloatSlider(
                name=name, label=info.title, min=info.slider_low, max=info.slider_high, step=info.step,
                tooltip=f"{info.meaning} {info.effect_of_larger}",
            )
            for name in _SLIDER_NAMES
            for info in [cpm.PARAMETERS[name]]
        ]  # fmt: skip
        super().__init__(
            widgets=[
                create_widget(annotation=Image, name="image", label="Image"),
                ComboBox(
                    name="extent",
                    label="In",
                    choices=_EXTENTS,
                    tooltip="What is searched. Along other axes, such as time, the sliders below the canvas choose it.",
                ),
                ComboBox(name="way", label="Find", choices=[FIND_OBJECTS, RUN_FROM_SHAPES]),
                *(
                    create_widget(annotation=kind, name=name, label=title, options={"tooltip": tooltip})
                    for name, (kind, title, tooltip) in _LAYER_CHOICES.items()
                ),
                ComboBox(
                    name="model",
                    label="Model",
                    choices=[
                        ("Network", ""),
                        *((one.title, name) for name, one in cpm.MODELS.items() if is_fetched(name)),
                    ],
                    tooltip="What answers in images.",
                ),
                *self.sliders,
                self.button,
                self.message,
            ]
        )
        self.message.native.setWordWrap(True)
        for slider in self.sliders:
            slider.native.findChild(QLineEdit).setMinimumWidth(_MIN_NUMBER_WIDTH)
            slider.changed.connect(self._on_slider_changed)
        self.image.changed.connect(self._update_extent)
        self.extent.changed.connect(self._apply_preset)
        self.way.changed.connect(self._update_rows)
        self.button.changed.connect(self._on_button_clicked)
        napari_viewer.layers.events.inserted.connect(lambda event: self._on_layer_inserted(event.value))
        self._update_extent()
        self._update_rows()

    def _on_layer_inserted(self, layer: Layer) -> None:
        """Choose shapes that the user has begun to draw; layers of results are told by their metadata."""
        if isinstance(layer, Shapes) and not layer.metadata and self.shapes.value is None:
            self.shapes.reset_choices()
            self.shapes.value = layer

    def _update_rows(self) -> None:
        for row in (self.points, self.outside, self.model, *self.sliders):
            row.visible = (row in self.sliders) == (self.way.value == RUN_FROM_SHAPES)

    def _update_extent(self) -> None:
        """Choose the volume where a layer has one, or the image where its third axis from the end is time."""
        layer = self.image.value
        has_more_axes = layer is not None and layer.ndim > 2
        self.extent.visible = has_more_axes
        if has_more_axes:
            self.extent.value = 2 if layer.axis_labels[-3].lower() in _TIME_NAMES else 3
        self._apply_preset()

    @property
    def _dimension(self) -> int:
        """How many axes of the image are searched, from the last one on."""
        return 2 if self.image.value is None else min(self.extent.value, self.image.value.ndim)

    @property
    def _frame(self) -> Frame:
        """Where the viewer is along the axes of the image that are not searched."""
        layer = self.image.value
        place = np.round(layer.world_to_data(self._viewer.dims.point[-layer.ndim :])).astype(int)
        largest = np.array(_shape(layer)) - 1
        return tuple(np.clip(place, 0, largest)[: layer.ndim - self._dimension].tolist())

    @property
    def _preset(self) -> cpm.Parameters:
        return cpm.PRESETS["shape" if self._dimension == 2 else "volume"]

    def _apply_preset(self) -> None:
        for slider in self.sliders:
            slider.value = getattr(self._preset, slider.name)

    def _on_slider_changed(self) -> None:
        """Pass the values of the sliders to the next step of a run, and to the next run."""
        try:
            self._parameters = self._parameters_from_sliders()
            self.message.value = ""
        except ValueError as error:
            self.message.value = str(error)

    def _parameters_from_sliders(self) -> cpm.Parameters:
        values: JsonDict = {slider.name: slider.value for slider in self.sliders}
        return replace(self._preset, **values)

    def _on_button_clicked(self) -> None:
        if self._worker is not None:
            self._worker.quit()
            return
        try:
            work, build_layers = self._prepare_work()
        except ValueError as error:
            self.message.value = str(error)
            return
        self.button.text = "Cancel"
        self._worker = create_worker(_find_layers, work, build_layers, _progress={"desc": "CPM"})
        self._worker.yielded.connect(self._on_progress)
        self._worker.aborted.connect(lambda: self._on_progress(("Canceled.", None)))
        self._worker.returned.connect(self._on_layers_found)
        self._worker.finished.connect(self._on_finished)
        self._worker.start()

    def _prepare_work(self) -> tuple[finding.Work, Callable[[Any], list[LayerData]]]:
        """Return the computation for the selected layers, and the function that builds layers of its outcome."""
        layer, shapes, chosen = (choice.value for choice in (self.image, self.shapes, self.objects))
        if layer is None:
            raise ValueError("Open an image first, or a volume.")
        frame = self._found_in = self._frame
        values = np.asarray((layer.data[0] if layer.multiscale else layer.data)[frame])
        image = cpm.Image(values, spacing=tuple(np.abs(layer.scale[len(frame) :])), source=layer.name)
        if chosen is not None and chosen.data.shape != _shape(layer):
            raise ValueError(f"{chosen.name} and {layer.name} have different sizes: choose the labels of the image.")
        labels = None if chosen is None else np.asarray(chosen.data[frame])
        drawn = []
        for corners, kind in zip(shapes.data, shapes.shape_type, strict=True) if shapes else ():
            if len(places := self._map_to_frame(shapes, corners, frame)):
                drawn += lines_from_shapes([places], [kind])
        inside, outside = (
            np.empty((0, image.ndim)) if points is None else self._map_to_frame(points, points.data, frame)
            for points in (self.points.value, self.outside.value)
        )
        model = self.model.value if image.ndim == 2 else ""
        if self.way.value == RUN_FROM_SHAPES:
            self._parameters = self._parameters_from_sliders()
            work = finding.run_from_seeds(image, finding.collect_drawn_seeds(drawn, labels), lambda: self._parameters)
        elif labels is not None and len(inside) + len(outside):
            name, number = chosen.name, chosen.selected_label
            corrected = finding.correct_label(image, labels, number, inside, outside, model)
            without_measures = {"name": name, "features": {}}  # those of the object before are no longer true
            return corrected, lambda found: [(put_into(chosen.data, found, frame), without_measures, "labels")]
        elif labels is not None or not len(inside) + len(drawn):
            raise ValueError("Add a layer of points and click into the objects, or draw boxes around them as shapes.")
        else:
            work = finding.find_objects_at(image, inside, outside, drawn, model)
        placing = {name: getattr(layer, name) for name in _PLACING_ATTRIBUTES}
        others = [each for each in self._viewer.layers if isinstance(each, Labels | Shapes)]
        known = {each.name: each.as_layer_data_tuple() for each in others}
        return work, lambda found: place_in_stack(
            build_result_layers(found, layer.name, **placing), frame, _shape(layer), known
        )

    def _map_to_frame(self, layer: Points | Shapes, positions: Array, frame: Frame) -> Array:
        """Map positions of a layer that lie in a frame to pixels there.

        Along axes that the layer lacks they are at the viewer's point.
        """
        world, image = np.array(self._viewer.dims.point, dtype=float), self.image.value
        found = np.empty((len(positions), image.ndim))
        for row, place in zip(found, positions, strict=True):
            world[-layer.ndim :] = layer.data_to_world(place)
            row[:] = image.world_to_data(world[-image.ndim :])
        return found[(np.round(found[:, : len(frame)]) == frame).all(axis=1), len(frame) :]

    def _on_progress(self, progress: finding.WorkProgress) -> None:
        self.message.value, position = progress
        if position is not None:
            placing = {name: getattr(self.image.value, name) for name in _PLACING_ATTRIBUTES}
            look = {"name": _PARTICLE_LAYER, "size": 2, "border_width": 0, "face_color": PARTICLE_COLOR, **placing}
            self._show_layer(prepend_frame(position, self._found_in), look, "points")

    def _on_layers_found(self, found: list[LayerData] | str) -> None:
        """Show the layers that were found, or the error."""
        if isinstance(found, str):
            self.message.value = found
            return
        self.message.value = "In the layers: " + ", ".join(settings["name"] for _, settings, _ in found)
        for layer in found:
            self._show_layer(*layer)

    def _show_layer(self, data: Any, settings: JsonDict, kind: str) -> None:
        """Replace the layer of the same name, which remains selected where its data can be replaced."""
        with suppress(KeyError):
            known = self._viewer.layers[settings["name"]]
            if kind != "shapes":
                known.data = data
                known.features = settings.get("features", known.features)
                return
            self._viewer.layers.remove(known)
        self._viewer.add_layer(Layer.create(data, settings, kind))

    def _on_finished(self) -> None:
        self._worker, self.button.text = None, "Find"
        with suppress(KeyError):
            self._viewer.layers.remove(self._viewer.layers[_PARTICLE_LAYER])


def _shape(layer: Image) -> tuple[int, ...]:
    """Return the shape of an image, in its finest resolution, without channels of color."""
    return tuple((layer.data[0] if layer.multiscale else layer.data).shape[: layer.ndim])


def _find_layers(
    work: finding.Work, build_layers: Callable[[Any], list[LayerData]]
) -> Generator[finding.WorkProgress, None, list[LayerData] | str]:
    """Return the layers of the outcome of a computation, or the sentence of its error."""
    try:
        return build_layers((yield from work))
    except ValueError as error:
        return str(error)
