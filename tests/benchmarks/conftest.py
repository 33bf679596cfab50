"""Benchmarks of the parts, by pytest-benchmark: ``python -m pytest tests/benchmarks/bench_*.py``.

The ordinary tests do not collect them. With ``--benchmark-disable`` each is tried once, on something small.
"""

import pytest

from cpm_core.objects.warm_up import warm_up


@pytest.fixture(scope="session")
def timed(request):
    """Whether times are taken; else the inputs may be small."""
    return not request.config.getoption("benchmark_disable")


@pytest.fixture(autouse=True, scope="session")
def compiled():
    """Loops compiled before any time is taken."""
    warm_up()
