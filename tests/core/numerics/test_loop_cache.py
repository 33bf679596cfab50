"""A damaged or full cache of compiled loops costs time, one sentence and nothing else."""

import importlib.util

import pytest
from numba.core.caching import CompileResultCacheImpl

from cpm_core.numerics import jit, loop_cache

TWO_LOOPS = """
from cpm_core.numerics import compiled

@compiled
def double(x):
    return 2 * x

@compiled
def triple(x):
    return 3 * x
"""


@pytest.fixture
def start_anew(tmp_path):
    """Return what starts a program of two loops: it gives how many of them came from the cache."""
    path = tmp_path / "loops.py"
    path.write_text(TWO_LOOPS, encoding="utf-8")
    loop_cache._warn_once.cache_clear()

    def start():
        spec = importlib.util.spec_from_file_location("loops", path)
        loops = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(loops)
        assert (loops.double(4), loops.triple(4)) == (8, 12)
        return sum(sum(kernel.stats.cache_hits.values()) for kernel in (loops.double, loops.triple))

    yield start
    loop_cache._warn_once.cache_clear()


@pytest.mark.parametrize("suffix", [".nbi", ".nbc"])
@pytest.mark.parametrize("damage", [lambda _: b"", lambda held: held[: len(held) // 2], lambda held: bytes(len(held))])
def test_what_a_power_cut_left_is_compiled_again(start_anew, tmp_path, caplog, suffix, damage):
    start_anew()
    for path in tmp_path.rglob(f"*{suffix}"):
        path.write_bytes(damage(path.read_bytes()))
    assert start_anew() == 0
    assert [record.message for record in caplog.records] == [
        "The cache of compiled loops is damaged: they are compiled again."
    ]
    assert start_anew() == 2


def test_a_full_disk_keeps_nothing_and_what_was_older_is_not_taken_for_new(start_anew, tmp_path, caplog):
    resource = pytest.importorskip("resource")  # not on Windows
    start_anew()
    for path in tmp_path.rglob("*.nbi"):
        path.unlink()
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (2000, limits[1]))  # the index fits, the loop does not
    try:
        assert start_anew() == 0
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert [record.message.partition(":")[0] for record in caplog.records] == [
        "Compiled loops cannot be kept (File too large)"
    ]
    assert start_anew() == 0
    assert start_anew() == 2


def test_where_no_folder_can_be_written_loops_are_compiled_at_each_start(start_anew, monkeypatch, caplog):
    monkeypatch.setattr(CompileResultCacheImpl, "_locator_classes", [])
    assert [start_anew(), start_anew()] == [0, 0]
    assert len(caplog.records) == 1
    assert "NUMBA_CACHE_DIR" in caplog.records[0].message


def test_that_loops_are_compiled_is_logged_once(start_anew, caplog):
    jit._announce.cache_clear()
    with caplog.at_level("INFO", "cpm_core"):
        start_anew()
    assert [record.levelname for record in caplog.records] == ["INFO"]
