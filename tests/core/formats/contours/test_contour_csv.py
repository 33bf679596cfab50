"""CSV: the table holds every vertex, in words and numbers that a spreadsheet reads."""

import csv
from dataclasses import replace

import numpy as np
import pytest

from cpm_core.formats import export, load_points

from ..drawn import LINE, LINE_AND_SQUARE, SQUARE

RESULT = LINE_AND_SQUARE


def table(path, result=RESULT):
    export(result, path)
    with path.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def test_each_vertex_is_a_row_in_order(tmp_path):
    rows = table(tmp_path / "a.csv")
    assert [int(row["contour"]) for row in rows] == [1] * 3 + [2] * 4
    assert [int(row["vertex"]) for row in rows] == [1, 2, 3, 1, 2, 3, 4]
    points = np.array([[float(row["row"]), float(row["col"])] for row in rows])
    assert np.allclose(points, np.concatenate([LINE.points, SQUARE.points]), atol=1e-4)
    assert np.allclose(load_points(tmp_path / "a.csv"), points), "it can be the start of another run"
    assert [row["closed"] for row in rows] == ["FALSE"] * 3 + ["TRUE"] * 4
    assert [float(row["strength"]) for row in rows] == [3.0] * 3 + [12.5] * 4
    assert [int(row["label"]) for row in rows] == [0] * 3 + [1] * 4


def test_columns_in_units_appear_only_where_the_size_of_a_pixel_is_known(tmp_path):
    plain = ["contour", "closed", "label", "strength", "vertex", "row", "col"]
    end = ["program", "image", "steps", "stop_reason"]
    assert list(table(tmp_path / "a.csv")[0]) == [*plain, "contrast", *end]
    rows = table(tmp_path / "b.csv", replace(RESULT, spacing=(0.5, 0.25), unit="µm"))
    assert list(rows[0]) == [*plain, "x_um", "y_um", "contrast", *end]
    for row in rows:
        assert float(row["x_um"]) == pytest.approx(0.25 * float(row["col"]))
        assert float(row["y_um"]) == pytest.approx(0.5 * float(row["row"]))


def test_a_result_without_contours_is_a_header(tmp_path):
    assert table(tmp_path / "a.csv", replace(RESULT, contours=())) == []
    assert (tmp_path / "a.csv").read_text(encoding="utf-8").startswith("contour,closed,")


def test_names_and_colours_stand_where_any_contour_has_one(tmp_path):
    named = replace(SQUARE, name='two, "words"', color="#e69f00")
    rows = table(tmp_path / "a.csv", replace(RESULT, contours=(LINE, named)))
    assert [row["name"] for row in rows] == [""] * 3 + ['two, "words"'] * 4
    assert [row["color"] for row in rows] == [""] * 3 + ["#e69f00"] * 4
