"""What the plugin gives napari, without napari: layers with measures, samples, and entries of its manifest."""

import importlib
from pathlib import Path

import cpm_app.napari
import numpy as np
import pytest
from cpm_app.napari import files, finding
from cpm_app.napari.layers import build_contour_layer, build_result_layers, place_in_stack

import cpm_core as cpm

MANIFEST = Path(cpm_app.napari.__file__).with_name("napari.yaml")


def objects_at(image, *places):
    """The objects at these places."""
    work = finding.find_objects_at(image, np.array(places, float), np.empty((0, image.ndim)), ())
    while True:
        try:
            next(work)
        except StopIteration as end:
            return end.value


@pytest.mark.parametrize(
    ("image", "places", "size"),
    [
        (cpm.example("disks"), [(32, 18), (32, 46)], 310),
        (cpm.Image(np.stack([cpm.example("disks").values.astype(np.uint8)] * 3, axis=-1)), [(32, 18), (32, 46)], 310),
        (cpm.example("ball"), [(15, 15, 15)], 3054),
    ],
    ids=["gray", "color", "volume"],
)
def test_labels_carry_the_measures_of_their_objects(compiled_loops, image, places, size):
    labels, settings, kind = build_result_layers(objects_at(image, *places), "a")[0]
    features = settings["features"]
    assert kind == "labels"
    assert labels.shape == image.shape
    assert features["index"].tolist() == [labels[place] for place in places]
    assert len({len(column) for column in features.values()}) == 1
    np.testing.assert_allclose(features["area" if image.ndim == 2 else "volume"], size, rtol=0.1)


def test_contours_of_other_frames_keep_their_colors_where_a_frame_has_none():
    square = cpm.Contour(np.array([(1.0, 1.0), (1.0, 5.0), (5.0, 5.0), (5.0, 1.0)]), closed=True)
    with_one, with_none = (build_contour_layer(lines, "a", (8, 8)) for lines in ([square], []))
    ((lines, look, kind),) = place_in_stack([with_one], (0,), (3, 8, 8), {})
    pandas = pytest.importorskip("pandas")
    shown = {**look, "features": pandas.DataFrame(look["features"]), "edge_color": np.array([(1.0, 0.0, 0.0, 1.0)])}
    ((kept, look, _),) = place_in_stack([with_none], (1,), (3, 8, 8), {"a": (lines, shown, kind)})
    assert len(kept) == 1 and look["edge_color"] == ["#ff0000"]


def test_the_manifest_has_a_menu_and_samples_that_open():
    npe2 = pytest.importorskip("npe2")
    told = npe2.PluginManifest.from_file(MANIFEST).contributions
    assert [entry.command for entry in told.menus["napari/layers/segment"]] == ["cpm-particles.find"]
    names = {command.id: command.python_name for command in told.commands}
    for sample in told.sample_data:
        module, _, name = names[sample.command].partition(":")
        ((values, _, kind),) = getattr(importlib.import_module(module), name)()
        assert kind == "image"
        assert (values.ndim == 3) == ("3D" in sample.display_name)
    assert files.sample_disks()[0][1] == {"name": "disks"}
