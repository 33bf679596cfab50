"""Help: examples that the parser takes, words that were mistyped, and the form of what is printed as JSON."""

import json
import os
import shlex
import subprocess
import sys

import jsonschema
import numpy as np
import PIL.Image
import pytest
from cpm_app import __main__ as program

from cpm_core import cli
from cpm_core.cli import CLI_COMMANDS
from cpm_core.cli.output import SCHEMA_FILE, SCHEMA_VERSION
from cpm_core.formats.common.provenance import VERSION

VALIDATOR = jsonschema.Draft202012Validator(json.loads(SCHEMA_FILE.read_text("utf-8")))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with two images of a bright disk, and a session that starts inside it."""
    place = tmp_path_factory.mktemp("images")
    row, col = np.mgrid[:60, :64]
    disk = (200 * (np.hypot(row - 30, col - 32) < 14)).astype(np.uint8)
    for name in ("disk2.png", "disk10.png"):
        PIL.Image.fromarray(disk).save(place / name)
    return place


RUN = ("--circle", "30,32,8", "--max-steps", 30)


def test_a_pattern_that_the_shell_has_left_alone_opens_its_only_image(monkeypatch, folder, capsys):
    opened = []
    monkeypatch.setattr(program, "_open_window", lambda path: opened.append(path) or 0)
    assert program.main([str(folder / "*k2.png")]) == 0
    assert opened == [str(folder / "disk2.png")]
    assert program.main([str(folder / "*.png")]) == 2
    assert "opens one image but 2 were given" in capsys.readouterr().err


def test_folders_and_patterns_stand_for_their_images_in_the_order_of_their_numbers(command, folder):
    for given in (folder, folder / "*.png"):
        out = command("info", given, "--json")[1]
        assert [image["source"] for image in json.loads(out)["images"]] == ["disk2.png", "disk10.png"]
    assert "names 2 images, but only one can be used here" in command("run", folder / "*.png", *RUN)[2]


def test_an_image_that_cannot_be_read_does_not_keep_the_others_back(command, folder, tmp_path):
    (tmp_path / "bad.png").write_bytes(b"no picture")
    status, out, err = command("info", tmp_path / "bad.png", folder / "disk2.png", "--json")
    found = json.loads(out)
    assert status == 1
    assert "bad.png" in err
    assert "trouble" in found["images"][0]
    VALIDATOR.validate(found)


def test_the_parser_takes_the_examples_of_each_command():
    assert set(CLI_COMMANDS) == program._COMMAND_NAMES
    for name, command in CLI_COMMANDS.items():
        for line in command.examples if name != "completion" else ():
            assert cli.build_parser().parse_args(shlex.split(line)[1:]).name == name


def test_a_shell_is_told_what_may_follow(tmp_path):
    line = "cpm run --auto gr"
    asked = {
        "_ARGCOMPLETE": "1", "COMP_LINE": line, "COMP_POINT": str(len(line)), "_ARGCOMPLETE_SHELL": "bash",
        "_ARGCOMPLETE_IFS": "\n", "_ARGCOMPLETE_STDOUT_FILENAME": str(tmp_path / "found"), "COMP_TYPE": "9",
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
    }  # fmt: skip
    subprocess.run([sys.executable, "-m", "cpm_app"], env=os.environ | asked, check=True, timeout=60)
    assert set((tmp_path / "found").read_text("utf-8").split()) == {"grid", "gradient"}


def test_a_mistyped_word_opens_no_window(monkeypatch, capsys):
    monkeypatch.setattr(program, "_open_window", lambda path: pytest.fail("a window was opened"))
    assert program.main([__file__, "--objects"]) == 2
    assert f"--objects is for a command, which comes first: cpm run {__file__}" in capsys.readouterr().err
    assert program.main(["rnu", "x"]) == 2
    assert "“rnu” is no command and no file: did you mean run?" in capsys.readouterr().err


def outcomes(command, folder, tmp_path):
    """What each command prints as JSON."""
    image = folder / "disk2.png"
    stack = tmp_path / "stack.npy"
    np.save(stack, np.stack([np.asarray(PIL.Image.open(image))] * 2))
    volume = tmp_path / "volume.npy"
    ball = np.linalg.norm(np.mgrid[:20, :20, :20] - np.array(9.5)[None, None, None], axis=0) < 6
    np.save(volume, 100.0 * ball)
    session = tmp_path / "a.cpm"
    yield "run", ("run", image, *RUN, "--save-session", session, "--truth", image)
    yield "run", ("run", image, "--object", "30,32", "--max-steps", 30)
    yield "run", ("run", stack, "--pages", "all", *RUN)
    yield "run", ("run", volume, "--sphere", "9.5,9.5,9.5,3", "--max-steps", 5)
    yield "skeleton", ("skeleton", image, "--of", "light")
    yield "skeleton", ("skeleton", volume, "--volume", "--of", "light")
    yield "compare", ("compare", image, "--start", image, "--methods", "gvf", "--max-steps", 5, "--truth", image)
    yield "info", ("info", image)
    yield "bench", ("bench", "--quick")
    yield "export", ("export", session, "--to", tmp_path / "a.svg")
    batch = ("batch", image, "--session", session, "--output", tmp_path / "out", "--workers", 1)
    yield from (("batch", (*batch, "--dry-run")), ("batch", batch))


def test_the_json_of_each_command_has_the_documented_form(command, folder, tmp_path):
    jsonschema.Draft202012Validator.check_schema(VALIDATOR.schema)
    for name, arguments in outcomes(command, folder, tmp_path):
        status, out, err = command(*arguments, "--json")
        assert status == 0, err
        found = json.loads(out)
        assert list(found)[:3] == ["command", "schema", "version"]
        assert (found["command"], found["schema"], found["version"]) == (name, SCHEMA_VERSION, VERSION)
        VALIDATOR.validate(found)
