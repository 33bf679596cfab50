"""The plugin in the real napari, in a process of its own: napari warns, and has its own application of Qt."""

import importlib.util
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture
def display():
    """A screen in memory, as images of napari take OpenGL."""
    listen, tell = os.pipe()
    command = ["Xvfb", "-displayfd", str(tell), "-screen", "0", "1280x800x24", "-nolisten", "tcp"]
    with subprocess.Popen(command, pass_fds=[tell], stderr=subprocess.DEVNULL) as screen:
        os.close(tell)
        with os.fdopen(listen) as number:
            yield f":{number.readline().strip()}"
        screen.terminate()


@pytest.mark.long
@pytest.mark.skipif(importlib.util.find_spec("napari") is None, reason="napari is not installed")
@pytest.mark.skipif(shutil.which("Xvfb") is None, reason="Xvfb is not installed")
def test_napari_reads_writes_and_finds_by_the_plugin_without_the_window(display, tmp_path):
    environment = {**os.environ, "DISPLAY": display, "QT_QPA_PLATFORM": "xcb", "QT_API": "pyside6", "NAPARI_CONFIG": ""}
    environment["PYTHONPATH"] = os.pathsep.join([str(ROOT), environment.get("PYTHONPATH", "")])
    command = [sys.executable, str(ROOT / "tests/e2e/napari_session.py"), str(tmp_path)]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False, timeout=580)
    assert done.returncode == 0, done.stderr[-3000:]
    told = json.loads(done.stdout.splitlines()[-1])
    assert [name for name in told["ours"] if not name.startswith("cpm_app.napari")] == []
    assert "ball.stl" in told["files"]


def test_the_plugin_is_found_by_its_entry_point():
    text = (ROOT / "pyproject.toml").read_text("utf-8")
    assert '[project.entry-points."napari.manifest"]\ncpm-particles = "cpm_app.napari:napari.yaml"' in text
