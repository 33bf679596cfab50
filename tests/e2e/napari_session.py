"""What the plugin does in napari itself, run in a process of its own; see `test_napari`. Prints one line at the end."""

import gc
import json
import os
import sys
from pathlib import Path

import cpm_app.napari
import napari
import numpy as np
from cpm_app.napari.widget import _find, find_contours
from napari.layers import Image, Layer, Shapes
from npe2 import PluginManager, PluginManifest
from qtpy.QtCore import QElapsedTimer, QEventLoop
from qtpy.QtWidgets import QApplication

from cpm_core import load_contours
from cpm_core.formats import export
from tests.core.formats.drawn import RESULT

gc.disable()  # on the thread of a run it would destroy what belongs to Qt

FOLDER = Path(sys.argv[1])
PICTURES = os.environ["QT_QPA_PLATFORM"] != "offscreen"
"""Whether images can be shown, which takes OpenGL; without, the widget's function is given layers of no viewer."""


def disk(side=64):
    row, col = np.indices((side, side))
    return np.where(np.hypot(row - 32, col - 32) < 18, 200.0, 20.0)


def wait(condition):
    """Let Qt work until something holds."""
    clock = QElapsedTimer()
    clock.start()
    while not condition() and not clock.hasExpired(240_000):
        QApplication.processEvents(QEventLoop.ProcessEventsFlag.AllEvents, 50)
    assert condition()


def run(values, corners, kind, scale, **settings):
    """The layer that the widget finds from a shape on an image."""
    image = Image(values, name="image", scale=scale)
    start = Shapes([corners], shape_type=kind, name="start", ndim=values.ndim)
    if not PICTURES:
        found = []
        worker = _find(image, start, **settings)
        worker.returned.connect(found.append)
        wait(lambda: bool(found))
        return Layer.create(*found[0][0])
    viewer.layers.clear()
    viewer.add_layer(image)
    viewer.add_layer(start)
    widget.image.value, widget.start.value = image, start
    for name, value in settings.items():
        getattr(widget, name).value = value
    widget()
    wait(lambda: len(viewer.layers) == 3)
    return viewer.layers[-1]


manifest = PluginManifest.from_file(Path(cpm_app.napari.__file__).with_name("napari.yaml"))
manifest.validate_imports()
manager = PluginManager.instance()
if manifest.name not in manager._manifests:  # where the package is not installed, but imported from its folder
    manager.register(manifest)

viewer = napari.Viewer(show=False)

# files that are read and written by the plugin
export(RESULT, FOLDER / "a.geojson")
(layer, points) = viewer.open(str(FOLDER / "a.geojson"), plugin=manifest.name)
assert list(layer.shape_type) == ["polygon", "path", "polygon", "polygon"]
assert list(layer.features["name"]) == ["cell", "fibre", "", "Kern β"]
np.testing.assert_allclose(points.data, [(55.0, 80.5)])
for name in ("b.svg", "b.zip", "b.dxf", "b.json"):
    assert layer.save(str(FOLDER / name), plugin=manifest.name) == [str(FOLDER / name)]
    back = load_contours(FOLDER / name)
    assert [contour.name for contour in back] == ["cell", "fibre", "", "Kern β"]
    assert back[0].color.lower() == "#e69f00"
    for found, drawn in zip(back, RESULT.contours, strict=False):
        assert np.linalg.norm(found.points[:, None] - drawn.points, axis=2).min(axis=1).max() < 0.01

# a run from a circle that is drawn, on an image with pixels of its own size
_, widget = viewer.window.add_plugin_dock_widget(manifest.name, "Find contours")
assert isinstance(widget, type(find_contours()))
circle = np.array([(12.0, 12.0), (12.0, 20.0), (20.0, 20.0), (20.0, 12.0)])
found = run(disk(), circle, "ellipse", (0.5, 0.5))
assert list(found.shape_type) == ["polygon"]
np.testing.assert_allclose(np.hypot(*(found.data[0] - 32).T), 18, atol=1.0)
np.testing.assert_allclose(found.scale, (0.5, 0.5))

# a surface from a line that is drawn in a slice of a volume
ball = np.where(np.linalg.norm(np.stack(np.indices((28, 28, 28))) - 13.5, axis=0) < 8, 200.0, 20.0)
square = np.array([(13, 10.0, 10.0), (13, 10.0, 17.0), (13, 17.0, 17.0), (13, 17.0, 10.0)])
surface = run(ball, square, "polygon", (1.0, 1.0, 1.0), max_steps=150)
assert type(surface).__name__ == "Surface"
assert surface.save(str(FOLDER / "ball.stl"), plugin=manifest.name)

ours = sorted(name for name in sys.modules if name.startswith("cpm_app."))
viewer.close()
sys.stdout.write(json.dumps({"ours": ours, "files": sorted(path.name for path in FOLDER.iterdir())}) + "\n")
