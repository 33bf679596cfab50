"""Start-up: importing the core, and loading or compiling its loops, each in a process of its own."""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping

from tests.benchmarks.speed.measurement import Measurement, Patience

_IMPORT = "import cpm_core"
_LIBRARIES = "import numba, numpy, scipy.ndimage, scipy.spatial, skimage"
_WARM_UP = "warm_up()"
_GET_WARM_UP = "from cpm_core.warm_up import warm_up"


def starts(patience: Patience) -> Iterator[Measurement]:
    """Import and warm-up, and compilation as on the very first start."""
    times = 1 if patience.quick else 3
    ours, libraries = _seconds(_IMPORT, times=times), _seconds(_LIBRARIES, times=times)
    yield Measurement("start", "import of cpm_core", ours, "s", "its libraries alone", libraries)
    loaded = _seconds(_WARM_UP, before=_GET_WARM_UP, times=times)
    yield Measurement("start", "loops loaded and run once", loaded, "s")
    if not patience.quick:
        with tempfile.TemporaryDirectory() as empty:
            compiled = _seconds(_WARM_UP, before=_GET_WARM_UP, times=1, environment={"NUMBA_CACHE_DIR": empty})
        yield Measurement("start", "loops compiled, the first start ever", compiled, "s")


def _seconds(statement: str, *, before: str = "", times: int, environment: Mapping[str, str] | None = None) -> float:
    """Median time that a statement takes in a new process, without the start of the interpreter [s]."""
    program = f"import time\n{before}\nbegan = time.perf_counter()\n{statement}\nprint(time.perf_counter() - began)"
    printed = [
        subprocess.run(
            [sys.executable, "-c", program],
            capture_output=True,
            text=True,
            check=True,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path), **(environment or {})},
        ).stdout
        for _ in range(times)
    ]
    return statistics.median(map(float, printed))
