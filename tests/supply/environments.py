"""Virtual environments with the oldest or the newest releases that the program allows."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

from .requirements import ROOT, oldest, requirements


class Environment:
    """A virtual environment in a folder.

    Parameters
    ----------
    folder : Path
        Where to make it; one that is there already is used.
    python : str
        The interpreter that it is made with.
    """

    def __init__(self, folder: Path, python: str) -> None:
        self.folder = folder
        self.is_new = not folder.exists()
        if self.is_new:
            subprocess.run([python, "-m", "venv", str(folder)], check=True)
        self.python = str(folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python"))

    def install(self, *requested: str) -> None:
        """Install distributions; a new environment for which that fails is removed, so that it is made again."""
        command = ["-m", "pip", "install", "--quiet", "--upgrade", "--prefer-binary", *requested]
        try:
            subprocess.run([self.python, *command], check=True, cwd=ROOT)
        except subprocess.CalledProcessError:
            if self.is_new:
                shutil.rmtree(self.folder)
            raise

    def run(self, *arguments: str) -> int:
        """Run Python in it, on the sources of this folder, and give its exit status."""
        environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        return subprocess.run([self.python, *arguments], cwd=ROOT, env=environment, check=False).returncode

    def answered(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        """How Python ended in it, and what it printed."""
        return subprocess.run([self.python, *arguments], cwd=ROOT, check=False, capture_output=True, text=True)

    def printed(self, *arguments: str) -> str:
        """What Python prints in it."""
        done = subprocess.run([self.python, *arguments], cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True)
        return done.stdout.strip()

    def folders(self) -> list[str]:
        """Where its distributions are installed."""
        return [self.printed("-c", "import sysconfig; print(sysconfig.get_path('purelib'))")]


def environment_of(versions: str, folder: Path, python: str) -> Environment:
    """An environment with the oldest or the newest releases, and the newest tools for tests."""
    made = Environment(folder / versions, python)
    wanted = oldest if versions == "oldest" else str
    made.install(".[test]", "pytest-timeout", *map(wanted, requirements()))  # what is there may lack what is new
    return made
