"""What the plugin does in napari itself, run in a process of its own; see `test_napari`. Prints one line at the end."""

import gc
import json
import sys
from pathlib import Path

import cpm_app.napari
import napari
import numpy as np
from cpm_app.napari.widget import FIND_OBJECTS, RUN_FROM_SHAPES, FindWidget
from npe2 import PluginManager, PluginManifest
from qtpy.QtCore import QElapsedTimer, QEventLoop
from qtpy.QtWidgets import QApplication

from cpm_core import load_contours
from cpm_core.formats import export
from tests.core.formats.drawn import RESULT

gc.disable()  # on the thread of a run it would destroy what belongs to Qt

FOLDER = Path(sys.argv[1])


def disks(*centers, radius=15):
    """Disks, or balls, in an array just as large as it has to be."""
    shape = np.max(centers, axis=0) + 24
    places = np.moveaxis(np.indices(shape), 0, -1)
    return 20.0 + 180.0 * np.any([np.linalg.norm(places - center, axis=-1) < radius for center in centers], axis=0)


def wait(condition):
    """Let Qt work until something holds."""
    clock = QElapsedTimer()
    clock.start()
    while not condition() and not clock.hasExpired(240_000):
        QApplication.processEvents(QEventLoop.ProcessEventsFlag.AllEvents, 50)
    assert condition(), widget.message.value


def find(way, *, cancel=False, **chosen):
    """Press the button, with these layers chosen and no others; what the widget says at the end."""
    widget.way.value = way
    for name in ("outside", "shapes", "objects"):
        getattr(widget, name).value = chosen.get(name)
    for name in {"image", "points"} & set(chosen):
        getattr(widget, name).value = chosen[name]
    widget.button.changed.emit(True)
    if cancel:
        wait(lambda: "Step" in widget.message.value)
        assert "particles" in viewer.layers
        widget.button.changed.emit(True)
    wait(lambda: widget.button.text == "Find")
    return widget.message.value


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

# what is missing is said in one sentence
viewer.layers.clear()
_, widget = viewer.window.add_plugin_dock_widget(manifest.name, "Find objects and contours")
assert isinstance(widget, FindWidget)
assert find(FIND_OBJECTS) == "Open an image first, or a volume."
image = viewer.add_image(disks((30, 30), (30, 70), (70, 30)), name="image", scale=(0.5, 0.5), translate=(7, 3))
assert "Add a layer of points" in find(FIND_OBJECTS)
assert "Draw a shape" in find(RUN_FROM_SHAPES)

# objects at points, which lie in their own layer by its own scale; a further point in the same object gives no other
inside = viewer.add_points([(22.0, 18.0), (23.0, 17.0), (22.0, 38.0)], name="inside")
assert "image labels, image contours" in find(FIND_OBJECTS, points=inside)
labels, contours = viewer.layers["image labels"], viewer.layers["image contours"]
np.testing.assert_allclose(np.bincount(labels.data.ravel())[1:], np.pi * 15**2, rtol=0.03)
assert labels.data[30, 30] == 1
assert labels.data[30, 70] == 2
assert labels.features["index"].tolist() == [1, 2]
assert contours.shape_type == ["polygon"] * 2
for layer in (labels, contours):
    np.testing.assert_allclose(layer.data_to_world((30, 30)), (22.0, 18.0))

# the points correct the label that is selected, in its layer
labels.selected_label = 2
outside = viewer.add_points([(22.0, 18.0)], name="outside")
labels.data = np.where(labels.data, 2, 0)  # both are one
inside.data = [(22.0, 38.0)]
find(FIND_OBJECTS, points=inside, outside=outside, objects=labels)
assert labels.data[30, 30] == 0
assert labels.data[30, 70] == 2
assert labels.features.empty
labels.selected_label = 7
assert "No pixel has the label 7" in find(FIND_OBJECTS, points=inside, objects=labels)

# a box around an object
inside.data = np.empty((0, 2))
box = np.array([(34.0, 10.0), (34.0, 26.0), (50.0, 26.0), (50.0, 10.0)])
boxes = viewer.add_shapes([box], shape_type="rectangle", name="boxes")
assert widget.shapes.value is boxes  # it need not be chosen
find(FIND_OBJECTS, points=inside, shapes=boxes)
np.testing.assert_allclose(np.argwhere(labels.data).mean(axis=0), (70, 30), atol=0.5)

# a run from a circle, and one from labels; the contour is where the edge is
circle = viewer.add_shapes([np.add(box, 2)], shape_type="ellipse", name="circle")
find(RUN_FROM_SHAPES, shapes=circle)
np.testing.assert_allclose(np.hypot(*(viewer.layers["image contours"].data[0] - (70, 30)).T), 15, atol=1.0)
find(RUN_FROM_SHAPES, objects=labels)
np.testing.assert_allclose(np.hypot(*(viewer.layers["image contours"].data[0] - (70, 30)).T), 15, atol=1.0)
widget.sliders[1].value = 1.9
assert "w2 is 1.75" in find(RUN_FROM_SHAPES, shapes=circle)

# a volume: bodies at points, and a surface from a line in a slice
viewer.layers.clear()
volume = viewer.add_image(disks((20, 20, 20), radius=9), name="volume", scale=(2, 1, 1))
inside = viewer.add_points([(40.0, 20.0, 20.0)], name="inside")
find(FIND_OBJECTS, image=volume, points=inside)
ball, surface = viewer.layers["volume labels"], viewer.layers["volume surface"]
np.testing.assert_allclose((ball.data > 0).sum(), 4 / 3 * np.pi * 9**3, rtol=0.1)
np.testing.assert_allclose(surface.data_to_world(surface.data[0].mean(axis=0)), (40, 20, 20), atol=1.0)
outside = viewer.add_points([(50.0, 20.0, 20.0)], name="outside")
find(FIND_OBJECTS, points=inside, outside=outside, objects=ball)
assert ball.data[20, 20, 20]
assert not ball.data[25, 20, 20]
square = np.array([(40, 16.0, 16.0), (40, 16.0, 24.0), (40, 24.0, 24.0), (40, 24.0, 16.0)])
line = viewer.add_shapes([square], shape_type="polygon", name="line")
assert "objects are found at points" in find(FIND_OBJECTS, points=inside, shapes=line)
assert find(RUN_FROM_SHAPES, shapes=line, cancel=True) == "Canceled."
assert "particles" not in viewer.layers
find(RUN_FROM_SHAPES, shapes=line)
surface = viewer.layers["volume surface"]
np.testing.assert_allclose(np.linalg.norm(surface.data[0] - 20, axis=1).mean(), 9, atol=0.5)
assert surface.save(str(FOLDER / "ball.stl"), plugin=manifest.name)

# a series in time: objects of the image in view, beside those of other times
viewer.layers.clear()
series = np.stack([disks((30, 30), (30, 70)), disks((30, 30), (30, 70))[:, ::-1]])
series = viewer.add_image(series, name="series", scale=(3, 1, 1), axis_labels=("t", "y", "x"))
assert widget.extent.value == 2
inside = viewer.add_points([(0.0, 30.0, 30.0), (3.0, 30.0, 22.0), (3.0, 30.0, 63.0)], name="inside")
viewer.dims.set_point(0, 0)
find(FIND_OBJECTS, image=series, points=inside)
labels = viewer.layers["series labels"]
assert labels.data.shape == (2, 54, 94)
assert labels.data[0, 30, 30] == 1
assert not labels.data[1].any()
viewer.dims.set_point(0, 3)
find(FIND_OBJECTS, points=inside)
assert labels.data[0, 30, 30] == 1
assert labels.data[1, 30, 22] == 2
assert labels.data[1, 30, 63] == 3
assert labels.features["index"].tolist() == [1, 2, 3]
assert [line[:, 0].mean() for line in viewer.layers["series contours"].data] == [0, 1, 1]
outline = [(3.0, 20.0, 10.0), (3.0, 20.0, 36.0), (3.0, 44.0, 36.0), (3.0, 44.0, 10.0)]
line = viewer.add_shapes([outline], shape_type="polygon", name="outline")
find(RUN_FROM_SHAPES, shapes=line)
assert labels.data[0, 30, 30] == 1
assert np.unique(labels.data[1]).tolist() == [0, 2]
np.testing.assert_allclose(np.hypot(*(viewer.layers["series contours"].data[1][:, 1:] - (30, 23)).T), 15, atol=1.0)

# volumes in time
film = viewer.add_image(np.stack([disks((20, 20, 20), radius=9)] * 2), name="film")
inside = viewer.add_points([(1.0, 20.0, 20.0, 20.0)], name="inside in film")
viewer.dims.set_point(0, 1)
find(FIND_OBJECTS, image=film, points=inside)
assert widget.extent.value == 3
assert viewer.layers["film labels"].data[1, 20, 20, 20] == 1
assert not viewer.layers["film labels"].data[0].any()
np.testing.assert_allclose(viewer.layers["film surface"].data[0].mean(axis=0), (1, 20, 20, 20), atol=0.5)

ours = sorted(name for name in sys.modules if name.startswith("cpm_app."))
viewer.close()
sys.stdout.write(json.dumps({"ours": ours, "files": sorted(path.name for path in FOLDER.iterdir())}) + "\n")
