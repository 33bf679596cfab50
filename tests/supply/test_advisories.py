"""Known faults: records of them are read from a file, and compared with what is installed."""

import argparse
import json
import subprocess
import zipfile

import pytest

from tests.supply import __main__ as supply
from tests.supply.advisories import known_faults, read


def record(*events, name="Some_Package", versions=(), **more):
    ranges = [{"type": "ECOSYSTEM", "events": [dict([event]) for event in events]}]
    affected = {"package": {"name": name, "ecosystem": "PyPI"}, "ranges": ranges, "versions": list(versions)}
    return {"id": "X-1", "summary": "reads too\nfar", "affected": [affected], **more}


BETWEEN = record(("introduced", "2.0"), ("fixed", "2.4"), ("introduced", "3.1"), ("last_affected", "3.2"))


@pytest.mark.parametrize("installed", ["2.0", "2.3.1", "3.1", "3.2"])
def test_a_release_between_the_events_of_a_record_has_the_fault(installed):
    assert known_faults({"some-package": installed}, [BETWEEN])


@pytest.mark.parametrize("installed", ["1.9", "2.4", "3.0", "3.3"])
def test_a_release_outside_the_events_of_a_record_has_it_not(installed):
    assert not known_faults({"some-package": installed}, [BETWEEN])


def test_a_fault_is_told_in_a_line():
    found = record(("introduced", "0"))
    assert known_faults({"some.package": "1.0", "other": "1.0"}, [found]) == ["some-package 1.0: X-1 reads too far."]


def test_what_is_withdrawn_or_of_another_index_is_no_fault():
    elsewhere = record(("introduced", "0"))
    elsewhere["affected"][0]["package"]["ecosystem"] = "npm"
    assert not known_faults({"some-package": "1"}, [elsewhere, record(("introduced", "0"), withdrawn="2020-01-01")])
    assert known_faults({"some-package": "1"}, [record(versions=["1"])])


def test_records_are_read_from_a_file_or_an_archive(tmp_path):
    one, many, packed = tmp_path / "one.json", tmp_path / "many.json", tmp_path / "all.zip"
    one.write_text(json.dumps(record()))
    many.write_text(json.dumps([record(), record()]))
    with zipfile.ZipFile(packed, "w") as archive:
        archive.write(one, "a.json")
        archive.write(many, "b.json")
    assert [len(read(path)) for path in (one, many, packed)] == [1, 2, 3]


@pytest.mark.parametrize("content", ["", "{}", "[1]", "nothing"])
def test_a_file_of_something_else_is_refused_in_a_sentence(tmp_path, content):
    (tmp_path / "x.json").write_text(content)
    with pytest.raises(ValueError, match=r"The advisories cannot be read from .*x\.json: .*\.$"):
        read(tmp_path / "x.json")


class Newest:
    """An environment with one distribution, whose tool reaches nobody."""

    is_new = False

    def __init__(self, *_: object) -> None:
        pass

    def printed(self, *_: str) -> str:
        return "some-package==1.0"

    def answered(self, *_: str) -> subprocess.CompletedProcess[str]:
        return subprocess.CompletedProcess([], 1, "", "ConnectionError")


@pytest.mark.parametrize(("fixed", "fine"), [("0.9", True), ("2.0", False)])
def test_an_audit_uses_the_advisories_that_it_is_given(tmp_path, monkeypatch, capsys, fixed, fine):
    monkeypatch.setattr(supply, "environment_of", Newest)
    path = tmp_path / "known.json"
    path.write_text(json.dumps(record(("introduced", "0"), ("fixed", fixed))))
    given = argparse.Namespace(folder=tmp_path, python="", advisories=path)
    assert supply.audited("audit", given) is fine
    assert ("some-package 1.0: X-1" in capsys.readouterr().out) is not fine


def test_an_audit_that_reaches_no_advisories_fails_and_says_what_to_do(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(supply, "environment_of", Newest)
    monkeypatch.setattr(supply, "Environment", Newest)
    assert not supply.audited("audit", argparse.Namespace(folder=tmp_path, python="", advisories=None))
    assert "cannot be reached: give a file of them with --advisories" in capsys.readouterr().out
