"""The cache of compiled loops of a program that is killed while it compiles: no later start reads half of anything."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import cpm_core

_LOOPS = """
from cpm_core.numerics.jit import compiled

@compiled
def inner(x):
    return x + 1.0

@compiled
def outer(x):
    return 2.0 * inner(x)

print(outer(10.0), sum(outer.stats.cache_hits.values()))
"""

_PATIENCE = 300.0


class Loops:
    """A small program of the same name, with the real modules that keep loops."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        made = folder / "cpm_core"
        (made / "numerics").mkdir(parents=True)
        (made / "__init__.py").touch()
        real = Path(cpm_core.__file__).parent / "numerics"
        for name in ("__init__.py", "jit.py"):
            shutil.copy(real / name, made / "numerics")
        shutil.copytree(real / "loop_cache", made / "numerics" / "loop_cache")
        (made / "loops.py").write_text(_LOOPS)
        began = time.perf_counter()
        assert self._printed() == "22.0 0"
        self.seconds = time.perf_counter() - began

    def trial(self, fraction: float) -> None:
        """Kill the program after a fraction of the time that it needs to compile, and start it twice."""
        shutil.rmtree(self._folder / "cache")
        with self._started() as process:
            time.sleep(fraction * self.seconds)
            process.kill()
        assert self._printed().startswith("22.0 "), "the start after it gives something else"
        assert self._printed() == "22.0 1", "the loops are not kept"

    def _printed(self) -> str:
        with self._started() as process:
            out, err = process.communicate(timeout=_PATIENCE)
        assert (process.returncode, err) == (0, ""), err.strip().rpartition("\n")[2]
        return out.strip()

    def _started(self) -> subprocess.Popen[str]:
        cache = str(self._folder / "cache")
        chosen = {"NUMBA_CACHE_DIR": "", "XDG_CACHE_HOME": cache, "LOCALAPPDATA": cache, "HOME": cache}
        return subprocess.Popen(
            [sys.executable, "-m", "cpm_core.loops"],
            cwd=self._folder, env={**os.environ, "PYTHONPATH": str(self._folder), **chosen},
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
