"""The program works without any network, and never tries to reach one."""

import os
import subprocess
import sys
from dataclasses import replace

import numpy as np

from cpm_core.formats.sessions.session_file import ImageFile, SessionFile, save_session
from cpm_core.parameters import Parameters
from cpm_core.shapes import Circle

from .requirements import ROOT

TRAP = """
import os, socket, sys

NETWORK = (socket.AF_INET, socket.AF_INET6)

def refuse(event, arguments):
    named = event in ("socket.getaddrinfo", "socket.gethostbyname", "socket.gethostbyaddr")
    reached = event in ("socket.connect", "socket.bind", "socket.sendto", "socket.sendmsg")
    if named or (reached and arguments[0].family in NETWORK):
        with open(os.environ["CPM_NETWORK_LOG"], "a") as log:
            log.write(f"{event} {arguments}\\n")
        raise PermissionError(f"no network: {event}")

sys.addaudithook(refuse)
"""

PROGRAM = """
import os, socket, sys
from pathlib import Path
from PySide6.QtCore import QCoreApplication, QSettings, QThread
from cpm_core import cli
from cpm_app.model.export import ExportFile, ExportOrder
from cpm_app.views.application import make_application
from cpm_app.views.main_window import open_window

common = ["--session", "start.cpm", "--max-steps", "2"]
assert cli.main(["run", "0.npy", *common, "--export", "a.svg", "a.json"]) == 0
assert cli.main(["batch", "0.npy", *common, "--workers", "1", "--output", "out", "--export", "svg"]) == 0

def until(condition):
    while not condition():
        QCoreApplication.processEvents()
        QThread.msleep(2)

QSettings.setPath(QSettings.Format.IniFormat, QSettings.Scope.UserScope, "preferences")
make_application()
window = open_window("work.cpm")
session = window.session
until(lambda: session.document.image is not None and session.idle)
session.step()
until(lambda: session.status.step > 0 and session.idle)
session.export_files(ExportOrder((ExportFile(Path("window.svg"), "contours", ".svg"),)))
until(lambda: Path("window.svg").exists() and session.idle)
maps = Path("/proc/self/maps")
assert not (maps.exists() and "Qt6Network" in maps.read_text())
try:
    socket.create_connection(("127.0.0.1", 9), timeout=1)
except PermissionError:
    print("refused")
sys.stdout.flush()
os._exit(0)
"""


def test_nothing_reaches_for_the_network(tmp_path, compiled_loops):
    row, col = np.indices((48, 48))
    np.save(tmp_path / "0.npy", np.where(np.hypot(row - 24, col - 24) < 12, 200.0, 20.0))
    (tmp_path / "trap").mkdir()
    (tmp_path / "trap" / "sitecustomize.py").write_text(TRAP)
    start = SessionFile(shapes=(Circle((24.0, 24.0), 7.0),), parameters=Parameters(scales=1))
    save_session(start, tmp_path / "start.cpm")
    save_session(replace(start, image=ImageFile(str(tmp_path / "0.npy"))), tmp_path / "work.cpm")
    path = os.pathsep.join([str(tmp_path / "trap"), str(ROOT)])
    log = tmp_path / "network.log"
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM], cwd=tmp_path, capture_output=True, text=True, check=False, timeout=120,
        env={**os.environ, "PYTHONPATH": path, "CPM_NETWORK_LOG": str(log)},
    )  # fmt: skip
    assert (done.returncode, done.stdout.splitlines()[-1:]) == (0, ["refused"]), done.stderr
    assert log.read_text().splitlines() == ["socket.getaddrinfo ('127.0.0.1', 9, 0, 1, 0)"]
