"""What the plugin gives napari, without napari: layers with measures, samples, and entries of its manifest."""

import importlib
from pathlib import Path

import cpm_app.napari
import numpy as np
import pytest
from cpm_app.napari import files, finding
from cpm_app.napari.layers import build_result_layers

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
