"""``python -m docs.gallery --output DIR``: repeats the experiments of the gallery and writes their pictures."""

from __future__ import annotations

import argparse
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from docs.gallery.figures import FIGURES, Figure, write_figures


def main(argv: Sequence[str] | None = None) -> None:
    """Make figures, with a line for each that is finished."""
    parser = argparse.ArgumentParser(prog="python -m docs.gallery", description=__doc__)
    parser.add_argument("--output", metavar="DIR", type=Path, required=True, help="folder, made when it is missing")
    parser.add_argument("--only", metavar="NAME", nargs="+", default=[], help=f"only these ({', '.join(FIGURES)})")
    arguments = parser.parse_args(argv)
    began = time.perf_counter()

    def report(figure: Figure, entry: Mapping[str, Any]) -> None:
        print(f"{figure.name}  {time.perf_counter() - began:4.1f} s  {figure.title}: {entry['measured']}", flush=True)

    try:
        written = write_figures(arguments.output, arguments.only, report)
    except ValueError as error:
        parser.error(str(error))
    print(f"Wrote {len(written)} files to {arguments.output}")


if __name__ == "__main__":
    main()
