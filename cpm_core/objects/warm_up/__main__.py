"""Fill a folder with compiled loops that a package for a system brings.

``python -m cpm_core.objects.warm_up FOLDER`` compiles them for every processor of this kind that is not very old. In
the package the folder is ``cpm_core/compiled``; the environment variable ``CPM_LOOPS`` names another place. The loops
belong to the versions of Numba and Python that have compiled them, and to the sources as they are: with others they
are not read.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from numba.core.registry import cpu_target

from cpm_core.numerics.loop_cache.folders import PLACE, SUFFIX
from cpm_core.numerics.loop_cache.shipped import FOLDER_VARIABLE, Target, describe, host
from cpm_core.objects.warm_up.aside import other_process
from cpm_core.objects.warm_up.parts import FIRST, LATER, VOLUMES

_FEATURES = {
    "x86_64": "64bit,cmov,cx8,fxsr,mmx,sse,sse2,cx16,sahf,popcnt,sse3,ssse3,sse4.1,sse4.2,avx,avx2,bmi,bmi2,f16c,fma,"
    "lzcnt,movbe,xsave"
}
"""By family of processors, those features that all have had since 2015; families that are missing need no others."""

_GENERIC = {"x86_64": "x86-64"}
"""LLVM's names of processors without more features, where they are not called generic."""


def common_target() -> Target:
    """What code is compiled for that runs on other computers with this system."""
    here = host()
    family = here.triple.partition("-")[0]
    has = here.features.split(",")
    features = [f"+{name}" for name in _FEATURES.get(family, "").split(",") if f"+{name}" in has]
    triple = cpu_target.target_context.codegen().magic_tuple()[0]
    return Target(triple, _GENERIC.get(family, "generic"), ",".join(features))


def fill(folder: Path, target: Target, parts: Sequence[str]) -> int:
    """Compile parts of the loops, which are named as module:function, into a folder; return the number of loops."""
    with tempfile.TemporaryDirectory() as made:
        environment = {
            "NUMBA_CACHE_DIR": made,
            "NUMBA_CPU_NAME": target.processor,
            "NUMBA_CPU_FEATURES": target.features,
            FOLDER_VARIABLE: "",
        }
        for part in parts:
            process = other_process(part, environment, telling=True)
            if process.wait():
                raise ValueError(f"{part} cannot be run.")
            process.communicate()
        return ship(Path(made) / PLACE, folder, target)


def ship(kept: Path, folder: Path, target: Target) -> int:
    """Copy loops that are kept, which are compiled for a target, into a folder; return their number."""
    shutil.rmtree(folder, ignore_errors=True)
    for of_module in kept.iterdir():
        shutil.copytree(of_module, folder / of_module.name.rpartition("-")[0])
    describe(folder, target)
    return sum(1 for _ in folder.rglob(f"*{SUFFIX}"))


def main(argv: Sequence[str] | None = None) -> int:
    """Fill a folder with compiled loops."""
    parser = argparse.ArgumentParser(prog="python -m cpm_core.objects.warm_up", description=__doc__)
    parser.add_argument("folder", type=Path, help="what is in it is replaced")
    parser.add_argument("parts", nargs="*", metavar="MODULE:FUNCTION", help="further functions that are run once")
    arguments = parser.parse_args(argv)
    count = fill(
        arguments.folder, common_target(), [*(part.name for part in (*FIRST, *LATER, *VOLUMES)), *arguments.parts]
    )
    sys.stdout.write(f"{arguments.folder}: {count} compiled loops\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
