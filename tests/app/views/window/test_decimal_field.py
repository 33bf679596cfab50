"""Numbers and dates of the window in its language; fields take a point for the decimal mark as well."""

from __future__ import annotations

import subprocess
import sys

import pytest
from cpm_app.views.application import locale_of
from cpm_app.views.widgets.fields import DecimalField
from PySide6.QtCore import QDate, QLocale


def field_in(qtbot, language: str, most: float = 100.0) -> DecimalField:
    field = DecimalField()
    field.setLocale(QLocale(language))
    field.setDecimals(3)
    field.setRange(0.0, most)
    field.setSuffix(" px")
    qtbot.addWidget(field)
    field.show()
    return field


@pytest.mark.parametrize(
    ("language", "typed", "value", "shown"),
    [
        ("de", "0.25", 0.25, "0,250 px"),
        ("de", "0,25", 0.25, "0,250 px"),
        ("de", "1.250", 1.25, "1,250 px"),  # 1250 is out of range
        ("de", "12.5", 12.5, "12,500 px"),
        ("fr", "0.25", 0.25, "0,250 px"),
        ("fr", "1.250", 1.25, "1,250 px"),
        ("es", "3.5", 3.5, "3,500 px"),
        ("en", "0.25", 0.25, "0.250 px"),
        ("ja", "0.25", 0.25, "0.250 px"),
    ],
)
def test_a_typed_number_is_taken_with_the_mark_of_the_language_or_a_point(qtbot, language, typed, value, shown) -> None:
    field = field_in(qtbot, language)
    field.selectAll()
    qtbot.keyClicks(field.lineEdit(), typed)
    field.interpretText()
    assert field.value() == value
    field.clearFocus()
    field.stepBy(0)
    field.setValue(value)
    assert field.textFromValue(field.value()) + field.suffix() == shown


def test_what_the_language_reads_as_thousands_stays_thousands(qtbot) -> None:
    field = field_in(qtbot, "de", 5000.0)
    assert field.valueFromText("1.250 px") == 1250.0
    assert field.valueFromText("1.25 px") == 1.25


def test_dates_and_numbers_are_those_of_the_language_and_of_the_desktop_where_it_speaks_the_same() -> None:
    swiss, british = QLocale("de_CH"), QLocale("en_GB")
    assert locale_of("de", swiss) == swiss
    assert locale_of("en", british) == british
    assert locale_of("de", british).toString(1.5) == "1,5"
    assert locale_of("en", swiss).toString(1.5) == "1.5"
    day = QDate(2026, 11, 23)
    assert locale_of("ja", british).toString(day, QLocale.FormatType.ShortFormat) == "2026/11/23"
    assert locale_of("de", british).toString(day, QLocale.FormatType.ShortFormat) == "23.11.26"


def test_the_program_writes_numbers_in_the_language_that_is_chosen() -> None:
    code = (
        "from cpm_app.model.text.language import use_language; use_language('de')\n"
        "from cpm_app.views.application import make_application; application = make_application()\n"
        "from PySide6.QtCore import QLocale; print(QLocale().toString(1.5))\n"
        "from cpm_app.model.display.lengths import format_measured_length\n"
        "print(format_measured_length(12345.6, (1.0, 1.0), None))"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert said.split("\n")[:2] == ["1,5", "12.345,6 px"]
