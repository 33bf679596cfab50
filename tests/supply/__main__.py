"""Looks after what the program depends on: ``python -m tests.supply [oldest] [newest] [audit] [licenses]``.

Makes an environment with the oldest and one with the newest releases that ``pyproject.toml`` allows and runs tests in
each; asks whether faults of the installed releases are known (``pip-audit``); and lists their licenses. It needs the
package index, and is therefore no part of the ordinary suite.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from .environments import Environment, environment_of
from .requirements import licenses, under_gpl

TESTS = ("tests/core/formats", "tests/core/segmentation", "tests/core/cli", "tests/e2e/test_first_light.py")
"""What is run by default: files, runs, the command line, and the window."""


def tested(versions: str, arguments: argparse.Namespace) -> bool:
    """Run the tests with the oldest or the newest releases."""
    made = environment_of(versions, arguments.folder, arguments.python)
    print(
        f"{versions}: {made.printed('-V')}, {made.printed('-m', 'pip', 'freeze', '--exclude', 'cpm-particles').split()}"
    )
    made.run("-c", "from cpm_core.warm_up import warm_up; warm_up()")  # no test waits for the compiler
    # what old releases warn of can be mended by nobody; what the newest ones warn of is to be known early
    warnings = ("-W", "default" if versions == "oldest" else "error")
    return made.run("-m", "pytest", "-q", "--timeout", "300", *warnings, *arguments.tests) == 0


def audited(_: str, arguments: argparse.Namespace) -> bool:
    """Ask which faults of the newest allowed releases are known; one of which nothing can be learned is a failure."""
    newest = environment_of("newest", arguments.folder, arguments.python)
    frozen = newest.printed("-m", "pip", "freeze", "--exclude", "cpm-particles")
    listed = arguments.folder / "installed.txt"
    listed.write_text(frozen + "\n")
    tool = Environment(arguments.folder / "audit", arguments.python)
    if tool.is_new:
        tool.install("pip-audit")
    options = ("--strict", "--no-deps", "--disable-pip", "--progress-spinner", "off", "--requirement", str(listed))
    answer = tool.answered("-m", "pip_audit", *options, "--format", "json")
    try:
        asked = json.loads(answer.stdout)["dependencies"]
    except (ValueError, KeyError, TypeError):
        reason = (answer.stderr.strip().splitlines() or ["no answer"])[-1]
        print(f"The advisories cannot be reached ({reason}).")
        return False
    found = [(one["name"], fault["id"]) for one in asked for fault in one.get("vulns", ())]
    print(
        "\n".join(f"{name}: {fault}." for name, fault in found) or f"No fault of {len(asked)} distributions is known."
    )
    return answer.returncode == 0


def licensed(_: str, arguments: argparse.Namespace) -> bool:
    """List the licenses of all that the program needs at run time; none may be the GPL."""
    named = licenses(environment_of("newest", arguments.folder, arguments.python).folders())
    for name, license in named.items():
        print(f"{name}: {license}")
    refused = under_gpl(named)
    if refused:
        print(f"Not allowed: {', '.join(refused)}.")
    return not refused


PARTS: dict[str, Callable[[str, argparse.Namespace], bool]] = {
    "oldest": tested,
    "newest": tested,
    "audit": audited,
    "licenses": licensed,
}


def main() -> int:
    """Do the parts that are asked for; status 1 if one of them failed."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.supply", description="Look after what the program depends on."
    )
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"of {', '.join(PARTS)} (default: all)")
    parser.add_argument("--python", default=sys.executable, help="interpreter of the environments (default: this one)")
    parser.add_argument(
        "--folder", type=Path, help="folder in which the environments are made and kept, and found again"
    )
    parser.add_argument("--tests", nargs="+", default=list(TESTS), help="what pytest runs (default: %(default)s)")
    arguments = parser.parse_args()
    unknown = [part for part in arguments.parts if part not in PARTS]
    if unknown:
        parser.error(f"there is no part {unknown[0]}: choose of {', '.join(PARTS)}.")
    with tempfile.TemporaryDirectory(prefix="cpm-supply-") as scratch:
        arguments.folder = (arguments.folder or Path(scratch)).absolute()
        failed = []
        for part in arguments.parts or PARTS:
            try:
                fine = PARTS[part](part, arguments)
            except (subprocess.CalledProcessError, ValueError) as error:
                print(f"{part}: {error}")
                fine = False
            print(f"{part}: {'passed' if fine else 'FAILED'}", flush=True)
            failed += [] if fine else [part]
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
