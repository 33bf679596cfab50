"""Help: examples that the parser takes, words that were mistyped, and the form of what is printed as JSON."""

import argparse
import json
import shlex

import jsonschema
import numpy as np
import PIL.Image
import pytest

from app import __main__ as program
from cpm_core import cli
from cpm_core.cli.help import EXAMPLES
from cpm_core.cli.outcome import SCHEMA, SCHEMA_FILE
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


def commands():
    """The parsers of all commands by their names."""
    (found,) = (action for action in cli.parser()._actions if isinstance(action, argparse._SubParsersAction))
    return found.choices


def test_each_command_teaches_by_examples_that_it_takes():
    assert set(EXAMPLES) == set(commands()) == program._COMMANDS
    for name, examples in EXAMPLES.items():
        assert len(examples) >= 2
        for _, line in examples:
            words = shlex.split(line)
            if "eval" in words:
                continue
            taken = words[: words.index(">")] if ">" in words else words
            assert taken[:2] == ["cpm", name]
            assert cli.parser().parse_args(taken[1:]).name == name


def test_the_help_of_a_command_ends_with_its_examples(capsys):
    for name, parser in commands().items():
        parser.print_help()
        end = capsys.readouterr().out.split("Examples:\n")[1]
        assert [line.strip() for line in end.splitlines()] == [
            part for what, line in EXAMPLES[name] for part in (line, what)
        ]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["rnu", "x"], 'cpm: "rnu" is no command and no file: did you mean cpm run?'),
        (["missing.png"], 'cpm: "missing.png" does not exist: check its name and folder, or see cpm --help.'),
        (["*.nothing"], 'cpm: No file is named like "*.nothing": check the pattern and the folder.'),
    ],
)
def test_a_mistyped_command_or_file_opens_no_window(arguments, sentence, monkeypatch, capsys, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(program, "_open_window", lambda path: pytest.fail("a window was opened"))
    assert program.main(arguments) == 2
    assert capsys.readouterr().err == sentence + "\n"


def test_a_pattern_that_the_shell_has_left_alone_opens_its_only_image(monkeypatch, folder, capsys):
    opened = []
    monkeypatch.setattr(program, "_open_window", lambda path: opened.append(path) or 0)
    assert program.main([str(folder / "*k2.png")]) == 0
    assert opened == [str(folder / "disk2.png")]
    assert program.main([str(folder / "*.png")]) == 2
    assert "opens one image but 2 were given" in capsys.readouterr().err


def test_a_mistyped_option_is_told_with_the_one_that_was_meant(command, folder):
    status, _, err = command("run", folder / "disk2.png", "--cicle", "1,2,3")
    assert (status, err) == (2, "cpm: unrecognized arguments: --cicle 1,2,3; did you mean --circle? See cpm --help.\n")


def test_folders_and_patterns_stand_for_their_images_in_the_order_of_their_numbers(command, folder):
    for given in (folder, folder / "*.png"):
        status, out, _ = command("info", given, "--json")
        assert [image["source"] for image in json.loads(out)["images"]] == ["disk2.png", "disk10.png"]
    status, _, err = command("run", folder / "*.png", *RUN)
    assert status == 2
    assert "names 2 images, but one is taken here" in err


def test_an_image_that_cannot_be_read_does_not_keep_the_others_back(command, folder, tmp_path):
    (tmp_path / "bad.png").write_bytes(b"no picture")
    status, out, err = command("info", tmp_path / "bad.png", folder / "disk2.png", "--json")
    found = json.loads(out)
    assert status == 1
    assert "bad.png" in err
    assert "trouble" in found["images"][0]
    VALIDATOR.validate(found)


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
    yield "compare", ("compare", image, "--circle", "30,32,8", "--methods", "cpm", "snake", "--max-steps", 5)
    yield "compare", ("compare", image, "--start", image, "--methods", "gvf", "--max-steps", 5, "--truth", image)
    yield "compare", ("compare", volume, "--sphere", "9.5,9.5,9.5,3", "--methods", "morph_gac", "--max-steps", 5)
    yield "info", ("info", image)
    yield "export", ("export", session, "--to", tmp_path / "a.svg")
    yield "batch", ("batch", image, "--session", session, "--output", tmp_path / "out", "--workers", 1)


def test_the_json_of_each_command_has_the_documented_form(command, folder, tmp_path):
    jsonschema.Draft202012Validator.check_schema(VALIDATOR.schema)
    for name, arguments in outcomes(command, folder, tmp_path):
        status, out, err = command(*arguments, "--json")
        assert status == 0, err
        found = json.loads(out)
        assert list(found)[:3] == ["command", "schema", "version"]
        assert (found["command"], found["schema"], found["version"]) == (name, SCHEMA, VERSION)
        VALIDATOR.validate(found)


def test_the_first_compilation_is_announced(command, folder, monkeypatch, tmp_path):
    monkeypatch.setattr("cpm_core.cli.terminal.is_compiled", lambda: False)
    _, _, err = command("run", folder / "disk2.png", *RUN)
    assert err.startswith("cpm: the inner loops are compiled for this computer, once;")
