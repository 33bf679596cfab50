"""Makes the distributions of the project, for tests."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def hand_out(project: Path, folder: Path, *kinds: str) -> None:
    """Build the distributions of a project into a folder, with what is installed here."""
    command = [sys.executable, "-m", "hatchling", "build", "-d", str(folder)]
    done = subprocess.run([*command, *(f"-t{kind}" for kind in kinds)], cwd=project, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr
