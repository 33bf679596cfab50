"""Objects have pictures in notebooks, plots on axes of matplotlib, and figures in files that their programs read."""

from __future__ import annotations

import io
from xml.etree import ElementTree as ET

import matplotlib as mpl
import numpy as np
import PIL.Image
import pytest
from matplotlib import pyplot
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

import cpm_core as cpm
from cpm_core.image.drawing import CLOSED_CURVE_COLOR, OPEN_CURVE_COLOR, fit_scale_bar


@pytest.fixture(scope="module")
def result():
    return cpm.segment(cpm.example("disks"), cpm.uniform_grid((64, 64)))


@pytest.fixture(scope="module")
def ball():
    return cpm.segment(cpm.example("ball"), cpm.sphere((15, 15, 15), 4, 60), cpm.PRESETS["volume"])


@pytest.fixture(autouse=True)
def no_windows():
    before = mpl.get_backend()
    pyplot.switch_backend("agg")
    yield
    pyplot.close("all")
    pyplot.switch_backend(before)


def pixels_of(png):
    return np.asarray(PIL.Image.open(io.BytesIO(png)).convert("RGB")).astype(int)


def test_all_that_has_a_shape_has_a_picture(result, ball):
    image = result.image
    partition = cpm.partition(result)
    moment = next(cpm.evolve(image, cpm.circle((32, 18), 5)))
    truth = cpm.Truth(result.labels, result.contours)
    shown = [cpm.skeleton(image), partition, partition.select([(32, 18)]), moment, truth, ball, cpm.example("colors")]
    for one in shown:
        assert pixels_of(one._repr_png_()).std() > 5.0, one


def test_result_is_plotted_on_the_axes_that_are_given(result):
    ax = Figure().add_subplot()
    assert result.plot(ax, particles=True, labels=True) is ax
    _, lines = (some for some in ax.collections if isinstance(some, LineCollection))  # the halos, then the lines
    assert {to_hex(color) for color in lines.get_colors()} <= {CLOSED_CURVE_COLOR, OPEN_CURVE_COLOR}
    assert len(lines.get_paths()) == len(result.contours)
    assert np.allclose(lines.get_paths()[0].vertices[:, ::-1], result.contours[0].path)
    texts = {text.get_text() for text in ax.texts}
    assert texts == {"1", "2", "5 µm"}
    assert ax.get_ylim() == (63.5, -0.5)


def test_the_scale_bar_is_as_long_as_it_says(result):
    ax = result.plot()
    bar = next(line for line in ax.lines if to_hex(line.get_color()) == "#ffffff")
    assert np.ptp(bar.get_xdata()) * 0.5 == pytest.approx(5.0)
    assert fit_scale_bar(0.3 * 64, 0.5, "µm").label == "5 µm"
    unmeasured = cpm.Image(result.image.values).plot()
    assert [text.get_text() for text in unmeasured.texts] == ["10 px"]


def test_image_skeleton_moment_and_surface_are_plotted(result, ball):
    ax = result.image.plot()
    cpm.skeleton(result.image).plot(ax)
    moment = next(cpm.evolve(result.image, cpm.circle((32, 18), 5)))
    moment.plot()
    moment.plot(contours=True)
    assert ball.plot().name == ball.surface.plot().name == "3d"
    with pytest.raises(ValueError, match="axes of matplotlib in space"):
        ball.plot(ax)
    with pytest.raises(ValueError, match="must be axes of matplotlib"):
        result.plot("here")


def test_figures_are_read_as_what_their_suffix_says(result, ball, tmp_path):
    files = [tmp_path / f"figure{suffix}" for suffix in (".svg", ".png", ".pdf")]
    cpm.write_figure(result, *files, labels=True)
    svg = ET.parse(files[0]).getroot()
    assert svg.tag.endswith("svg")
    assert "5 µm" in "".join(svg.itertext())
    assert CLOSED_CURVE_COLOR in files[0].read_text(encoding="utf-8")
    with PIL.Image.open(files[1]) as png:
        assert png.size == (1200, 1200)
        assert "disks" in png.info["Description"]
    assert files[2].read_bytes().startswith(b"%PDF-")
    cpm.write_figure(cpm.skeleton(result.image), tmp_path / "bones.svg")
    cpm.write_figure(ball, tmp_path / "ball.png")
    with pytest.raises(ValueError, match="names no format of a figure"):
        cpm.write_figure(result, tmp_path / "figure.gif")
