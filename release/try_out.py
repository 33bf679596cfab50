"""Tries what is handed out, as installed: ``python release/try_out.py COMMAND [--limit MB]``.

The command, ``cpm`` or the path of a frozen application, reports its version, runs on a sample, and opens its window on
that, which must still be there some seconds later. Of an application, the folder may not be larger than the limit.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from freeze import ROOT, size

SAMPLE = ROOT / "assets" / "samples" / "u_shape.png"
WINDOW = 30.0
"""Time for which the window must stay open [s]."""


def main(argv: Sequence[str] | None = None) -> int:
    """Try a command; status 1, and why, when something is not as it must be."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", help="what starts the program")
    parser.add_argument("--limit", type=float, help="how large the folder of an application may be [MB]")
    arguments = parser.parse_args(argv)
    command = shutil.which(arguments.command) or sys.exit(f"There is no command {arguments.command}.")
    if arguments.limit is not None:
        used = size(Path(command).parent) / 1e6
        sys.stdout.write(f"{used:.0f} MB\n")
        if used > arguments.limit:
            sys.exit(f"The application is larger than {arguments.limit:.0f} MB.")
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([command, "--version"], check=True, cwd=folder)
        began, file = time.monotonic(), Path(folder) / "u.geojson"
        run = [command, "run", str(SAMPLE), "--circle", "100,73,38", "--export", str(file), "--json"]
        found = json.loads(subprocess.run(run, check=True, cwd=folder, stdout=subprocess.PIPE).stdout)
        sys.stdout.write(f"the first run took {time.monotonic() - began:.1f} s\n")
        if not found["converged"] or not file.stat().st_size:
            sys.exit(f"The run found {found}.")
        window = subprocess.Popen([command, str(SAMPLE)], cwd=folder)
        try:
            ended = window.wait(WINDOW)
        except subprocess.TimeoutExpired:
            window.kill()
            window.wait()
        else:
            sys.exit(f"The window was closed with status {ended}.")
    return 0


if __name__ == "__main__":
    sys.exit(main())
