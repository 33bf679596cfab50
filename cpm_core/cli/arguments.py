"""Arguments of several commands: the image, the session, the parameters, files to write, JSON."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import fields, replace
from pathlib import Path

from cpm_core.cli.inputs import CHANNEL_HELP, as_number, check_kept
from cpm_core.formats import READABLE, WRITABLE, check_export
from cpm_core.formats.sessions.session_file import SUFFIX
from cpm_core.image.colors import LUMINANCE_NOTE
from cpm_core.image.geometry import CONVENTIONS
from cpm_core.image.image import Image
from cpm_core.image.pyramid import most_scales
from cpm_core.parameters import DEFAULTS, PARAMETERS, Parameters
from cpm_core.parameters.choices import CHOICES, ChoiceInfo


def add_image(parser: argparse.ArgumentParser, optional: bool = False) -> None:
    """Add the path of an image, as `image`."""
    parser.add_argument(
        "image", metavar="IMAGE", nargs="?" if optional else None, help=f"image ({', '.join(READABLE)})"
    )


def add_session(parser: argparse._ActionsContainer, required: bool = False) -> None:
    """Add a session file, as `session`."""
    parser.add_argument(
        "--session",
        metavar="FILE",
        required=required,
        help=f"session file ({SUFFIX}) with image, start, regions, parameters and review of contours",
    )


def add_parameters(parser: argparse._ActionsContainer, names: Sequence[str] = (*PARAMETERS, *CHOICES)) -> None:
    """Add parameters, each as a flag of its name; see `parameters_of`."""
    for name in names:
        if name in CHOICES:
            _add_choice(parser, CHOICES[name])
            continue
        info = PARAMETERS[name]
        parser.add_argument(
            "--" + name.replace("_", "-"),
            metavar=name.upper(),
            type=as_number,
            dest=name,
            help=f"{info.meaning} {info.more} (default: {DEFAULTS[name]})".replace("%", "%%"),
        )


def _add_choice(parser: argparse._ActionsContainer, info: ChoiceInfo) -> None:
    """Add a parameter whose values are names."""
    more = f"{CHANNEL_HELP} " if info.name == "channel" else ""
    effects = " ".join(f"{name}: {effect}" for name, effect in info.choices.items())
    parser.add_argument(
        f"--{info.name}",
        metavar=info.name.upper(),
        dest=info.name,
        help=f"{info.meaning} {effects} {more}(default: {DEFAULTS[info.name]})",
    )


def add_export(parser: argparse._ActionsContainer, what: str) -> None:
    """Add the paths to write, as `export`; see `check_exports`."""
    parser.add_argument(
        "--export",
        metavar="PATH",
        nargs="+",
        action="extend",
        default=[],
        help=f"write the {what} ({', '.join(WRITABLE)})",
    )


def add_close(parser: argparse._ActionsContainer) -> None:
    """Add whether open contours are closed before they are written, as `close`: None, "edges" or "straight"."""
    parser.add_argument(
        "--close",
        nargs="?",
        choices=("edges", "straight"),
        const="edges",
        help="close open contours whose ends are near each other, along the edges of the image or straight",
    )


def add_space(parser: argparse._ActionsContainer) -> None:
    """Add where coordinates in files of a volume point, as `space`."""
    parser.add_argument(
        "--space",
        choices=CONVENTIONS,
        help="coordinates in files of a surface or of center lines: to the left, back and head of a patient, or to the "
        "right, front and head (default: LPS)",
    )


def add_json(parser: argparse._ActionsContainer) -> None:
    """Add a flag for JSON instead of sentences, as `json`."""
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def parameters_of(arguments: argparse.Namespace, base: Parameters) -> Parameters:
    """The parameters `base`, replaced by those given as flags; ValueError on a bad value."""
    given = {field.name: getattr(arguments, field.name, None) for field in fields(Parameters)}
    return replace(base, **{name: value for name, value in given.items() if value is not None})


def with_room(parameters: Parameters, image: Image) -> tuple[Parameters, tuple[str, ...]]:
    """Parameters with as many scales as an image has room for, and a note where that changes them."""
    most = most_scales(image.shape)
    if parameters.scales <= most:
        return parameters, ()
    return replace(parameters, scales=most), (f"The image is small: scales is set to {most}.",)


def notes_on(image: Image, parameters: Parameters) -> tuple[str, ...]:
    """What was changed between the file of an image and the gray levels that a run with these parameters takes."""
    wanted = parameters.channel
    if wanted == "luminance":
        return image.notes
    if image.colors is None:
        return (*image.notes, f"The image is gray: it has no channel {wanted}.")
    taken = f"The channel {wanted} of its colors was taken."
    return tuple(taken if note == LUMINANCE_NOTE else note for note in image.notes)


def check_exports(
    paths: Sequence[str], arguments: argparse.Namespace, image: str | Path | None = None, flag: str = "--export"
) -> None:
    """Raise ValueError unless each path can be written and none is a file that is read; see `check_kept`."""
    for path in paths:
        check_export(path)
    check_kept(paths, arguments, image, flag)


def as_steps(given: int | float | str | None) -> int | None:
    """The given number of steps; ValueError unless it is a positive whole number."""
    if given is None or (isinstance(given, int) and given > 0):
        return given
    raise ValueError(f"--max-steps is {given} but must be a whole number above 0.")
