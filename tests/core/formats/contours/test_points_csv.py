"""Points: a table of positions is read, and a bad line is named."""

import re

import numpy as np
import pytest

from cpm_core.formats import load_points


@pytest.mark.parametrize(
    "text",
    ["1,2\n3.5,-4\n", "row,col\n1,2\n3.5,-4\n", "\ufeffRow, Col\r\n1, 2\r\n\r\n3.5, -4\r\n", "col,row\n2,1\n-4,3.5\n"],
)
def test_points_are_rows_and_columns_with_or_without_a_header(tmp_path, text):
    (tmp_path / "p.csv").write_text(text, encoding="utf-8")
    points = load_points(tmp_path / "p.csv")
    assert points.dtype == np.float64
    assert np.array_equal(points, [[1, 2], [3.5, -4]])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "p.csv contains no points"),
        ("row,col\n\n", "p.csv contains no points"),
        ("1,2\n3\n", 'Line 2 of p.csv is "3"'),
        ("1,2\n\n3,x\n", 'Line 3 of p.csv is "3,x"'),
        ("1,nan\n", 'Line 1 of p.csv is "1,nan"'),
        ("row,col\n1,inf\n", 'Line 2 of p.csv is "1,inf"'),
    ],
)
def test_a_bad_table_is_refused_by_its_line(tmp_path, text, words):
    (tmp_path / "p.csv").write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=re.escape(words)):
        load_points(tmp_path / "p.csv")


def test_a_file_that_is_no_text_is_refused(tmp_path):
    (tmp_path / "p.csv").write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(ValueError, match=r"p\.csv is not a text file"):
        load_points(tmp_path / "p.csv")


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"none\.csv in .* does not exist"):
        load_points(tmp_path / "none.csv")


def test_a_line_is_quoted_in_printable_characters_and_cut_short(tmp_path):
    (tmp_path / "a.csv").write_text("1,2\n\x00\x1b[31m" + "x" * 5000)
    with pytest.raises(ValueError, match="Line 2 of a") as caught:
        load_points(tmp_path / "a.csv")
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 200
