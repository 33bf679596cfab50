"""Workers and runs that are killed while an image is run chunk by chunk."""

import os
import signal
import subprocess
import sys
import time
from importlib.util import find_spec

import numpy as np
import pytest

from cpm_core.cli.workers import connect_to_dask, map_until_finished
from cpm_core.formats.images.ome_zarr import create_multiscale, open_multiscale, write_window

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(find_spec("distributed") is None, reason="the extra `scale` is not installed"),
]


def test_a_killed_worker_costs_what_it_was_doing_and_no_more(tmp_path):
    def work(job):
        with (tmp_path / f"{job}.txt").open("a") as begun:
            begun.write("x")
        if job == 3 and (tmp_path / "3.txt").read_text() == "x":
            os._exit(1)
        time.sleep(0.3)
        return 2 * job

    with connect_to_dask(None, 2) as client:
        results = {at: future.result() for at, future in map_until_finished(client, work, range(8))}
    assert results == {job: 2 * job for job in range(8)}
    begun = [len((tmp_path / f"{job}.txt").read_text()) for job in range(8)]
    assert begun[3] == 2
    assert sum(begun) <= 10  # what has been done and not been fetched yet may be done again


@pytest.mark.parametrize(("shape", "pitch", "count"), [((1100, 1100), 110, 100), ((264, 264, 48), 48, 36)])
def test_a_killed_run_is_continued_by_the_same_command(tmp_path, shape, pitch, count):
    away = np.sqrt(((np.indices(shape) % pitch - pitch // 2) ** 2).sum(axis=0))
    image = (120 * (away < 0.2 * pitch) + 20).astype(np.uint8)
    create_multiscale(tmp_path / "cells.zarr", image.shape, image.dtype, 1024 if len(shape) == 2 else 256)
    write_window(tmp_path / "cells.zarr", tuple(slice(n) for n in shape), image)
    command = [sys.executable, "-m", "cpm_app", "run", "cells.zarr", "--auto", "gradient", "--workers", "2"]
    command += ["--scales", "1", "--smoothing", "1.5", "--export", "labels.zarr", "cells.csv"]
    chunks, name = tmp_path / "labels.zarr.cpm-chunks", "contours_*" if len(shape) == 2 else "particles_*"
    with subprocess.Popen(command, cwd=tmp_path, start_new_session=True) as begun:
        while not list(chunks.glob(name)):
            assert begun.poll() is None
            time.sleep(0.05)
        os.killpg(begun.pid, signal.SIGKILL)
    assert not (tmp_path / "labels.zarr").exists()
    kept = {path.name for path in chunks.glob(name)}
    subprocess.run(command, cwd=tmp_path, check=True)
    assert 1 <= len(kept) <= 4
    labels = np.asarray(open_multiscale(tmp_path / "labels.zarr").arrays[0])
    assert len(np.unique(labels)) == count + 1
    assert len((tmp_path / "cells.csv").read_text().splitlines()) == count + 1
    assert {path.name for path in tmp_path.iterdir()} == {"cells.zarr", "labels.zarr", "cells.csv"}
