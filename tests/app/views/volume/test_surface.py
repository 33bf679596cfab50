"""The surface that a run finds: its sections, its figures, and its files."""

from __future__ import annotations

import csv

import numpy as np
import pytest
import tifffile
from cpm_app.model.export import list_export_formats
from cpm_app.views.features.run import RunControlFeature
from cpm_app.views.widgets.containers import ElidedLabel
from PySide6.QtCore import Qt

from cpm_core.formats import VOLUMES_WRITABLE
from tests.app.exporting import asked, check, order
from tests.app.reading import contour_counts

pytestmark = pytest.mark.shared_window

RADIUS, CENTER = 7.0, np.array([11.5, 13.5, 15.5])


@pytest.fixture
def found(volume, hand):
    """A window on the ball after a run."""
    hand.drag((14, 16), (14, 18), (14, 20))
    hand.key(Qt.Key.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: volume.session.idle and volume.session.scene.reconstruction is not None)
    return volume


def numbers(window) -> dict[str, str]:
    return {label: value for label, value, _ in window.session.resolved.numbers}


def test_each_slice_shows_where_it_cuts_the_surface(found) -> None:
    canvas = found.canvas_area.canvas
    for axis, index, off in ((0, 12, 0.5), (0, 7, 4.5), (1, 16, 2.5), (2, 11, 4.5)):
        found.workspace.slices.set_axis(axis)
        found.workspace.slices.go_to(index)
        (contour,) = canvas.drawn_scene.contours
        away = np.linalg.norm(contour.points - np.delete(CENTER, axis), axis=1)
        assert away.mean() == pytest.approx(np.sqrt(RADIUS**2 - off**2), abs=0.35)
        assert contour_counts(canvas.layers.contours) == (1, 0)
    found.workspace.slices.go_to(0)
    assert canvas.drawn_scene.contours == ()


def test_the_panel_tells_what_makes_the_surface_worth_trust(found) -> None:
    shown = numbers(found)
    assert (shown["Surface"], shown["Closed"], shown["Euler number"]) == ("1 part", "yes", "2")
    assert float(shown["Volume"].split()[0].replace(",", "")) == pytest.approx(4 / 3 * np.pi * RADIUS**3, rel=0.1)
    assert float(shown["Area"].split()[0].replace(",", "")) == pytest.approx(4 * np.pi * RADIUS**2, rel=0.1)
    assert "Contours" not in shown
    status = found.panels["run"].status
    assert [label.text() for label in status.findChildren(ElidedLabel) if label.accessibleName() == "Surface"] == [
        "1 part"
    ]
    assert found.get_feature(RunControlFeature)


def test_an_image_has_no_figures_of_a_surface(window) -> None:
    assert "Surface" not in numbers(window)
    assert "Contours" in numbers(window)


def test_surface_labels_and_particles_are_exported_at_once(found, hand, tmp_path) -> None:
    dialog = asked(hand.qtbot, found)
    assert {*list_export_formats("surface")} == set(VOLUMES_WRITABLE) - {".csv", ".tiff", ".nii", ".seg.dcm"}
    check(hand.qtbot, dialog, *(f"surface:{suffix}" for suffix in list_export_formats("surface")))
    assert "a surface of " in dialog.summary.text()
    assert dialog.windowTitle() == "Export surface"
    for path in order(hand.qtbot, found, dialog, tmp_path):
        assert path.stat().st_size > 100
    assert "triangles" in found.canvas_area.messages.text
    (row,) = csv.DictReader(next(tmp_path.glob("*_surface.csv")).read_text(encoding="utf-8").splitlines())
    assert float(row["volume_px3"]) == pytest.approx(4 / 3 * np.pi * RADIUS**3, rel=0.1)
    labels = tifffile.imread(next(tmp_path.glob("*.tif")))
    assert (labels > 0).sum() == pytest.approx(4 / 3 * np.pi * RADIUS**3, rel=0.1)
    rows = np.loadtxt(next(tmp_path.glob("*.points.csv")), delimiter=",", skiprows=1, usecols=(0, 1, 2))
    np.testing.assert_allclose(rows, found.session.scene.snapshot.position, rtol=1e-5)
