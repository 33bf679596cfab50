"""The widget for napari: finds contours, or a surface, from the shapes that are drawn on an image."""

import numpy as np
from magicgui import magic_factory
from napari.layers import Image, Shapes
from napari.qt.threading import FunctionWorker, thread_worker
from napari.types import LayerDataTuple

import cpm_core as cpm
from cpm_app.napari.layers import LayerData, layers_of_result, seeds_of
from cpm_core.image import luminance

_AS_KIND = "for the image"


def _find(
    image: Image, start: Shapes, preset: str = _AS_KIND, max_steps: int = 2000
) -> FunctionWorker[list[LayerDataTuple]]:
    """Find contours.

    Parameters
    ----------
    image : Image
        Image, or volume.
    start : Shapes
        Shapes inside the object, or around it: particles begin along their lines.
    preset : str
        Named settings; by default those for shapes, or for volumes.
    max_steps : int
        Greatest number of steps.
    """
    values = np.asarray(image.data, dtype=float)
    if image.rgb:
        values = luminance(values[..., :3])
    places = [[image.world_to_data(start.data_to_world(corner)) for corner in one] for one in start.data]
    seeds = seeds_of([np.array(one)[:, -values.ndim :] for one in places], list(start.shape_type))
    usual = "volume" if values.ndim == 3 else "shape"
    parameters = cpm.PRESETS[usual if preset == _AS_KIND else preset]
    settings = {"scale": image.scale[-values.ndim :], "translate": image.translate[-values.ndim :]}
    name, spacing = image.name, tuple(image.scale[-values.ndim :])

    def work() -> list[LayerData]:
        found = cpm.segment(cpm.Image(values, spacing=spacing, source=name), seeds, parameters, max_steps=max_steps)
        return layers_of_result(found, name, **settings)

    return thread_worker(work, start_thread=True)()


find_contours = magic_factory(
    _find, call_button="Find contours", preset={"choices": [_AS_KIND, *cpm.PRESETS]}, max_steps={"max": 100_000}
)
"""Makes the widget."""
