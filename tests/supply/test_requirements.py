"""Each requirement names its oldest allowed release, and none is under the GPL alone."""

import sys

import pytest

from .requirements import licenses, oldest, requirements, under_gpl


def test_every_requirement_names_the_oldest_release_that_is_allowed():
    assert all(oldest(required).startswith(f"{required.name}==") for required in requirements())


def test_nothing_that_is_installed_for_the_program_is_under_the_gpl_alone():
    named = licenses(sys.path)
    assert {"numpy", "pyside6-essentials", "llvmlite"} <= named.keys()
    assert under_gpl(named) == {}


@pytest.mark.parametrize(
    ("license", "refused"),
    [
        ("GPL-3.0-only", True),
        ("AGPL-3.0-or-later", True),
        ("GNU General Public License v3 (GPLv3)", True),
        ("unknown", True),
        ("LGPL-3.0-only OR GPL-2.0-only", False),
        ("GNU Lesser General Public License v3 (LGPLv3)", False),
        ("BSD License; GNU General Public License v2 (GPLv2)", False),
        ("MIT", False),
    ],
)
def test_a_license_is_refused_when_it_leaves_no_choice_but_the_gpl(license, refused):
    assert bool(under_gpl({"a": license})) == refused
