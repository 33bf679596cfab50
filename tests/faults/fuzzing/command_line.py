"""Command line: any arguments end with status 0, 1 or 2, in words of one line each, and leave no half of a file."""

from __future__ import annotations

import argparse
import contextlib
import io
import json
from pathlib import Path
from random import Random

import numpy as np
import tifffile

from cpm_core import to_bytes
from cpm_core.cli import build_parser, main
from cpm_core.formats import CONTOURS_WRITABLE
from cpm_core.formats.writers import VOLUMES_WRITABLE
from cpm_core.warm_up import warm_up
from tests.core.formats.drawn import RESULT

from .inputs.session_samples import IMAGE, sample, sample_in_space, sample_of_pages, write_images
from .inputs.session_samples import VOLUME as _VOLUME
from .limits import LONGEST_SENTENCE, in_time

prepare = warm_up

_AT_ONCE = 4
_SESSION, _POINTS, _CONTOURS, _TEXT, _STACK = "sound.cpm", "points.csv", "contours.geojson", "notes.txt", "small.tif"
_SOUND = {IMAGE, _SESSION, _POINTS, _CONTOURS, _TEXT, _VOLUME, _STACK}
_FILES = (
    *(IMAGE, _VOLUME, _STACK, "truth.npy", _SESSION, "space.cpm", "pages.cpm", _POINTS, _CONTOURS, _TEXT, "none.png"),
    *(".", "", "/dev/null", "a\nb.png", "é.png", "-"),
)
_NUMBERS = (
    *("0", "1", "-1", "2", "0.5", "3", "1e9", "nan", "inf", "-inf", "auto", "x", "", "1e400", "0x1", "1_0", "٣"),
    "9" * 400,
)
_PLACES = (
    *("20,20,6", "20,20", "4,4,4,30", "4,4,30,30,4,30", "1e9,1e9,1", "nan,1,2", ",", "20,20,-1", "20,20,1e9", "a,b"),
)
_SPHERES = (
    *("9,9,9,3", "9.5,9.5,9.5,1e9", "0,0,0,2", "9,9,9", "nan,9,9,3", "9,9,9,0", "1e300,9,9,3", "9,9,9,-1", ",,,", ""),
)
_TARGETS = (
    *(f"out{suffix}" for suffix in {**CONTOURS_WRITABLE, **VOLUMES_WRITABLE}),
    *("out.x", IMAGE, "no/out.csv", "", "svg", "csv"),
)
_VALUES: dict[str, tuple[str, ...]] = {
    "--sphere": _SPHERES,
    **dict.fromkeys(("--circle", "--stroke", "--region", "--barrier", "--polygon"), _PLACES),
    "--object": (*_PLACES, "9,9,9", "0,0,0", "nan,9,9"),
    "--not": (*_PLACES, "9,9,2"),
    "--methods": ("chan_vese", "gvf", "snake", "all", "x", ""),
    "--set": ("chan_vese.mu=0.3", "snake.alpha=nan", "gvf.iterations=9", "x.y=1", "snake", "=", "snake.alpha=1e999"),
    **dict.fromkeys(("--truth", "--start", "--points", "--session", "--within", "--image"), _FILES),
    "--pages": ("all", "1-2", "2,1", "3-1", "0", "9", "-1", "1-", "1,,2", "x", "", "1-99999999999"),
    "--pixel-size": ("0.25um", "1,2um", "0", "nan", "-1mm", "x", "1e-300", "2,2,2mm"),
    "--workers": ("1", "0", "x", "99999"),
    **dict.fromkeys(("--export", "--to"), _TARGETS),
    "--save-session": ("new.cpm", "new.x", IMAGE, "no/new.cpm", ""),
    "--output": ("there", "", IMAGE, "/dev/null/x"),
    "--scheduler": ("nowhere:1",),
    "--edges": ("vessels", "gray", "x"),
    "--channel": ("red", "1", "x"),
}
"""Values of options; those that are not named have their choices, or else numbers."""

_LONG = {"bench"}
"""Commands that take long whatever they are told."""


def _options() -> dict[str, tuple[str, ...]]:
    """All options of all commands with values to try; those without one have none."""
    options = dict.fromkeys(("--help", "--version"), ())
    (commands,) = (action for action in build_parser()._actions if isinstance(action, argparse._SubParsersAction))
    for name, command in commands.choices.items():
        for action in command._actions if name not in _LONG else ():
            values = (*map(str, action.choices), "x") if action.choices else _NUMBERS
            options |= {
                flag: () if action.nargs == 0 else _VALUES.get(flag, values)
                for flag in action.option_strings
                if flag.startswith("--")
            }
    return options


_FLAGS = _options()
_COMMANDS = (*["run"] * 4, "compare", "skeleton", "info", "batch", "export", "export", "completion", "x", "")
_STEPS = {"run": ["--max-steps", "3"], "compare": ["--max-steps", "3"], "batch": ["--workers", "1", "--max-steps", "3"]}


def arguments_of(random: Random) -> list[str]:
    """A list of arguments, more often than not one that can be carried out."""
    command = random.choice(_COMMANDS)
    given = [command]
    in_space, pages = command == "run" and random.random() < 0.3, command == "run" and random.random() < 0.2
    if in_space:
        given += [_VOLUME, "--sphere", random.choice(_SPHERES[:2])]
    elif pages:
        given += [_STACK, "--pages", random.choice(("all", "1-2", "2,1"))]
    elif command == "completion":
        given.append(random.choice(("bash", "zsh", "fish", "powershell", "x")))
    elif command == "export":
        given += [random.choice((_SESSION, "space.cpm", "pages.cpm", _CONTOURS, "truth.npy", *_FILES))]
        given += ["--to", random.choice(_TARGETS)]
    elif random.random() < 0.8:
        given += [IMAGE] if random.random() < 0.8 else [random.choice(_FILES)]
    if command == "batch" and random.random() < 0.8:
        given += ["--session", _SESSION, "--output", "there"]
    if command in ("run", "compare") and not in_space and random.random() < 0.6:
        given += ["--circle", "20,20,6"]
    for _ in range(random.randrange(5)):
        flag = random.choice(list(_FLAGS))
        given.append(flag)
        if _FLAGS[flag] and random.random() < 0.95:
            given.append(random.choice(_FLAGS[flag]))
    given += _STEPS.get(command, [])
    if random.random() < 0.1:
        random.shuffle(given)
    return given


def attempt(arguments: list[str]) -> None:
    """Carry out one command in this folder; fails unless its status, its words and its files agree."""
    before = _contents()
    said, printed = io.StringIO(), io.StringIO()
    with in_time(60.0), contextlib.redirect_stderr(said), contextlib.redirect_stdout(printed):
        try:
            status = main(arguments)
        except SystemExit as end:  # of --help and --version
            status = int(end.code or 0)
    lines = said.getvalue().splitlines()
    assert status in (0, 1, 2), f"status {status}: {lines}"
    assert all(line.startswith("cpm: ") for line in lines), f"said {lines}"
    assert all(len(line) <= LONGEST_SENTENCE for line in lines), f"a line of {max(map(len, lines))} characters"
    assert status == 0 or lines or "batch" in arguments, "refused without a word"
    after = _contents()
    changed = {name for name in after if before.get(name) != after[name]}
    assert before.keys() <= after.keys(), f"lost {before.keys() - after.keys()}"
    assert status != 2 or not changed, f"refused with {lines[-1:]}, but wrote {changed}"
    assert not changed & _SOUND, f"overwrote {changed}"
    assert all(after[name] for name in changed), f"an empty file among {changed}"
    if "--json" in arguments and status == 0 and "--help" not in arguments and "--version" not in arguments:
        json.loads(printed.getvalue(), parse_constant=_refuse)
    for name in changed:
        Path(name).unlink()


def _refuse(constant: str) -> None:
    raise AssertionError(f"JSON holds {constant}")


def _contents() -> dict[str, bytes]:
    return {str(path): path.read_bytes() for path in Path().rglob("*") if path.is_file()}


def trial(random: Random, folder: Path) -> int:
    """Carry out some commands in a folder with sound files."""
    write_images(folder)
    for name, made in ((_SESSION, sample), ("space.cpm", sample_in_space), ("pages.cpm", sample_of_pages)):
        (folder / name).write_text(json.dumps(made(folder)))
    (folder / _CONTOURS).write_bytes(to_bytes(RESULT, ".geojson"))
    (folder / _POINTS).write_text("row,col\n20,14\n20,26\n")
    (folder / _TEXT).write_text("nothing\n")
    row, col = np.indices((32, 34))
    disks = [np.where(np.hypot(row - 15.0 - page, col - 16.0) < 8.0, 200, 20) for page in range(3)]
    tifffile.imwrite(folder / _STACK, np.array(disks, np.uint8), photometric="minisblack")
    np.save(folder / "é.png.npy", np.zeros((9, 9)))
    with contextlib.chdir(folder):
        for _ in range(_AT_ONCE):
            arguments = arguments_of(random)
            try:
                attempt(arguments)
            except BaseException as error:
                error.args = (f"{error} by {arguments}"[:600],)
                raise
    return _AT_ONCE
