"""The source obeys the rules of its style; `.ci/run` checks its types as well."""

import json
import re
import subprocess
import sys
import tomllib
from fnmatch import fnmatch
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent


def run_ruff(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "ruff", *arguments]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, encoding="utf-8", check=False)


@pytest.mark.parametrize("arguments", [("check",), ("format", "--check")], ids=" ".join)
def test_source_is_clean(arguments: tuple[str, ...]) -> None:
    done = run_ruff(*arguments)
    assert done.returncode == 0, done.stdout + done.stderr


def expand_braces(pattern: str) -> list[str]:
    """Patterns that one with {alternatives} stands for."""
    found = re.search(r"\{([^{}]*)\}", pattern)
    if found is None:
        return [pattern]
    before, after = pattern[: found.start()], pattern[found.end() :]
    return [one for choice in found[1].split(",") for one in expand_braces(before + choice + after)]


def test_each_permission_permits_something() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["ruff"]["lint"]
    permitted = {"*": settings["ignore"], **settings["per-file-ignores"]}
    without = ("--extend-select", ",".join(settings["ignore"]), "--config", "lint.per-file-ignores = {}")
    done = run_ruff("check", "--exit-zero", "--output-format=json", *without)
    broken = {(Path(one["filename"]).relative_to(ROOT).as_posix(), one["code"]) for one in json.loads(done.stdout)}
    unused = [
        (pattern, rule)
        for given, rules in permitted.items()
        for pattern in expand_braces(given)
        for rule in rules
        if not any(fnmatch(path, pattern) and code.startswith(rule) for path, code in broken)
    ]
    assert unused == []
