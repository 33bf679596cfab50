"""Command line: the table of all commands, each a module of this package. No window."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from textwrap import fill
from typing import NamedTuple

import argcomplete
from argcomplete.shell_integration import shellcode

from cpm_core.cli import batch, bench, compare, export, info, model, run, skeleton
from cpm_core.cli.inputs import expand_paths, find_only_image
from cpm_core.cli.output import STANDARD_STREAM, direct_output, print_message
from cpm_core.cli.parser import CliParser
from cpm_core.formats.common.provenance import VERSION
from cpm_core.numerics.types import Texts

EXIT_BAD_INPUT = 2
"""Exit status after invalid input."""

EXIT_INTERRUPTED = 130
"""Exit status after Ctrl+C, as shells report it."""

_WIDTH = 80
"""Width of the descriptions [characters]."""

EXIT_BROKEN_PIPE = 141
"""Exit status after writing to a closed pipe, as shells report it."""


class CliCommand(NamedTuple):
    """A command: its help in a few words and in a sentence, its arguments, its effect, example lines, usual options.

    Where there are no usual options, all are shown at once.
    """

    help: str
    description: str
    add_arguments: Callable[[argparse.ArgumentParser], object]
    run: Callable[[argparse.Namespace], int | None]
    examples: Texts
    usual: str = ""


CLI_COMMANDS = {
    "run": CliCommand(
        "find the contours of an image",
        "Let particles flow from a start to the contours of an image.",
        run.add_arguments,
        run.run_segmentation,
        (
            "cpm run cell.png --circle 120,80,30 --export cell.svg",
            "cpm run stack.tif --pages all --auto grid --export stack.csv",
            "cpm run cell.png --start cell.roi --save-session cell.cpm",
        ),
        "session circle stroke auto volume xy object not objects preset export save-session json quiet",
    ),
    "batch": CliCommand(
        "find the objects of many images",
        "Apply a session file to each image, and write the objects that the window finds there: its start, regions, "
        "charges and parameters, and of a file of several images the page, channel, point in time and series that the "
        "session shows. An image that fails is reported, and the others go on. What the summary in the folder says is "
        "done already is not done again.",
        batch.add_arguments,
        batch.run_batch,
        (
            "cpm batch images --session cell.cpm --output found",
            'cpm batch "images/*.png" --session cell.cpm --output found --export labelme csv masks',
        ),
        "session output export contours workers again dry-run json quiet",
    ),
    "export": CliCommand(
        "write a session or contours in other formats",
        "Write the contours or the surface that a session shows, or those of a file, in other formats. A session "
        "without a recorded run is run first.",
        export.add_arguments,
        export.run_export,
        (
            "cpm export cell.cpm --to cell.zip cell.geojson cell.figure.pdf",
            "cpm export cell.svg --image cell.png --to cell.coco.json",
            "cpm export tree.ply --image angio.nii --to tree.nii.gz",
        ),
    ),
    "skeleton": CliCommand(
        "find the skeletons of the objects in an image",
        "Find the middle lines of the objects in an image, with the distance to the boundary at every point. "
        "The smoothing is chosen from the image's noise unless it is given. In a volume the lines are written as SWC.",
        skeleton.add_arguments,
        skeleton.run_skeleton,
        (
            "cpm skeleton retina.png --of dark --export vessels.svg",
            "cpm skeleton angio.nii --volume --export tree.swc",
        ),
        "volume of within pruning export json quiet",
    ),
    "compare": CliCommand(
        "compare methods on the same image and start",
        "Run the charged particles and classical methods from the same start, one after the other.",
        compare.add_arguments,
        compare.run_comparison,
        (
            "cpm compare cell.png --circle 120,80,30 --truth cell_mask.png",
            "cpm compare cell.png --circle 120,80,30 --methods cpm gvf --export table.csv",
        ),
        "session circle polygon methods truth export json quiet",
    ),
    "model": CliCommand(
        "fetch a larger model that answers prompts",
        "List the larger models that answer --object in place of the network, or fetch one, once. They need the extra "
        "sam. Images stay on this computer.",
        model.add_arguments,
        model.show_models,
        ("cpm model", "cpm model sam2:tiny"),
    ),
    "info": CliCommand(
        "show the properties of an image or volume",
        "Show the size, gray levels, pixel size and place in space of an image or volume, and what reading it changed.",
        info.add_arguments,
        info.show_info,
        ("cpm info stack.tif", "cpm info images --json"),
    ),
    "bench": CliCommand(
        "measure how fast it is here",
        "Measure how long whole runs and their parts take on your machine, on a scene of disks. Each time is a median "
        "of several, without compilation.",
        bench.add_arguments,
        bench.run_benchmarks,
        ("cpm bench", "cpm bench --quick --json"),
    ),
    "completion": CliCommand(
        "complete commands in your shell",
        "Print a script for a shell, with which the tab key completes commands, options and files.",
        lambda parser: parser.add_argument("shell", choices=("bash", "zsh", "fish", "powershell"), help="The shell."),
        lambda arguments: print(shellcode(["cpm"], shell=arguments.shell)),
        ('eval "$(cpm completion bash)"', "cpm completion fish > ~/.config/fish/completions/cpm.fish"),
    ),
}
"""The commands by name, in the order of the help."""


def build_parser() -> CliParser:
    """Build the parser of the whole command line."""
    whole = CliParser(
        prog="cpm",
        description="Find contours in images with charged particles.",
        epilog="Without a command the window opens, on an image or a folder of images if one is named: cpm [IMAGE].",
    )
    whole.add_argument("--version", action="version", version=f"cpm {VERSION}", help="Show the version.")
    commands = whole.add_subparsers(metavar="COMMAND", dest="name", required=True)
    for name, command in CLI_COMMANDS.items():
        examples = "\n  ".join(["Examples:", *command.examples])
        made = commands.add_parser(
            name, help=command.help, description=fill(command.description, _WIDTH), epilog=examples, usual=command.usual
        )
        command.add_arguments(made)
        made.usage = f"{made.format_usage().removeprefix('usage: ').rstrip()} [OPTION ...]"
        if name != "completion":
            made.add_argument("--json", action="store_true", help="Print one JSON object.")
            made.add_argument("--quiet", action="store_true", help="Print errors only.")
    return whole


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments after the program's name; those of the process when left out.

    Returns
    -------
    int
        Exit status: 0 on success, 1 when only some of several images, pages or files were done, 2 on bad input (one
        line on standard error; nothing is written), 130 when interrupted, 141 when the output is no longer read.
    """
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")  # for terminals that cannot show every character
    try:
        return _run_command(sys.argv[1:] if argv is None else argv)
    except ValueError as error:
        print_message(str(error))
        return EXIT_BAD_INPUT
    except MemoryError:
        print_message("there is not enough memory for this: use a smaller image or fewer particles.")
        return EXIT_BAD_INPUT
    except KeyboardInterrupt as interrupt:
        print_message(f"interrupted; {interrupt}." if str(interrupt) else "interrupted.")
        return EXIT_INTERRUPTED
    except BrokenPipeError:
        _discard_output()
        return EXIT_BROKEN_PIPE
    except OSError as error:
        _discard_output()
        what = f"{error.filename} cannot be used" if error.filename else "standard output cannot be written"
        print_message(f"{what}: {error.strerror or error}.")
        return EXIT_BAD_INPUT


def _run_command(argv: Sequence[str]) -> int:
    """Parse arguments and run their command, until its output is written."""
    try:
        whole = build_parser()
        if "_ARGCOMPLETE" in os.environ:
            argcomplete.autocomplete(whole)
        arguments = whole.parse_command(argv)
        if getattr(arguments, "image", None) == STANDARD_STREAM and getattr(arguments, "save_session", None):
            raise ValueError("--save-session needs an image in a file, but this one is on standard input.")
        if getattr(arguments, "image", None) is not None:
            arguments.image = find_only_image(arguments.image)
        if hasattr(arguments, "images"):
            arguments.images = expand_paths(arguments.images)
        if arguments.name == "completion":
            return CLI_COMMANDS[arguments.name].run(arguments) or 0
        exports = arguments.to if arguments.name == "export" else getattr(arguments, "export", None) or []
        with direct_output(exports, quiet=arguments.quiet, as_json=arguments.json):
            return CLI_COMMANDS[arguments.name].run(arguments) or 0
    finally:
        if sys.stdout is not None:
            sys.stdout.flush()


def _discard_output() -> None:
    """Discard what standard output could not take; otherwise Python reports an error at exit."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
