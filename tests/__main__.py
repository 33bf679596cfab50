"""The second tier of tests, which takes hours and the package index: ``python -m tests [PART ...]``.

All parts are run by default; each is a command of its own that takes further options.
"""

import argparse
import os
import subprocess
import sys

PARTS = {
    "long": ("pytest", "-m", "long"),
    "chance": ("pytest",),
    "faults": ("tests.faults",),
    "releases": ("tests.supply",),
    "network": ("pytest", "-n0", "tests/supply"),
    "indices": ("pytest", "tests/core"),
    "claims": ("tests.benchmarks.claims",),
}
"""Long tests; examples never tried before; broken input; releases and licenses; no network; checked indices; the
claims of the paper."""


def main() -> int:
    """Run the parts that are asked for; status 1 if one of them failed."""
    parser = argparse.ArgumentParser(prog="python -m tests", description="Run the second tier of the tests.")
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"of {', '.join(PARTS)} (default: all)")
    failed = []
    for part in parser.parse_args().parts or PARTS:
        if part not in PARTS:
            parser.error(f"there is no part {part}: choose of {', '.join(PARTS)}.")
        environment = {"indices": {"NUMBA_BOUNDSCHECK": "1"}, "chance": {"CPM_EXAMPLES": "chance"}}.get(part, {})
        if subprocess.run(
            [sys.executable, "-m", *PARTS[part]], env={**os.environ, **environment}, check=False
        ).returncode:
            failed.append(part)
    print(f"failed: {', '.join(failed)}" if failed else "passed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
