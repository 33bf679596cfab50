"""A method that is added is a module and a line: everything else that compares methods knows it then."""

import json
import os
import subprocess
import sys

import numpy as np
import PIL.Image

from cpm_core.objects.methods import registry

MODULE = '''
"""A level set that grows by one pixel a step."""
from dataclasses import dataclass

import scipy

from cpm_core.objects.methods.method import ContourMethod
from cpm_core.objects.methods.settings import Settings, number
from cpm_core.objects.methods.states import LevelSetState


@dataclass(frozen=True)
class GrowingSettings(Settings):
    size: int = number(3, "n", "Size", "Pixels that are added.", "More of it adds more.", (0, 99), (0, 9), 1)


def evolve(image, start, settings):
    inside = start.mask(image.shape)
    for step in range(settings.size + 1):
        yield LevelSetState(step, "it is large enough" if step == settings.size else "", True, inside, 0.5)
        inside = scipy.ndimage.binary_dilation(inside)


GROWING = ContourMethod("growing", "Growing", "It grows.", "nobody", GrowingSettings, evolve, 99)
'''

PROGRAM = '''
import importlib.util, sys

NAME = "cpm_core.objects.methods.registry"
LINE = "    GRAB_CUT,\\n)"


class WithOneLineMore:
    """Finds the registry, whose text has one line more, and the import of what it names."""

    def find_spec(self, name, path, target=None):
        if name != NAME:
            return None
        spec = importlib.util.spec_from_loader(name, self)
        return spec

    def create_module(self, spec):
        return None

    def exec_module(self, module):
        with open(REGISTRY, encoding="utf-8") as file:
            text = file.read()
        assert LINE in text
        text = text.replace(LINE, "    GRAB_CUT,\\n    GROWING,\\n)")
        future = "from __future__ import annotations\\n"
        exec(text.replace(future, future + "from growing import GROWING\\n"), module.__dict__)


REGISTRY, folder = sys.argv[1:]
sys.meta_path.insert(0, WithOneLineMore())
sys.path.insert(0, folder)

from dataclasses import replace
from itertools import islice
from pathlib import Path

from PySide6.QtWidgets import QApplication

from app.session.session import Session
from app.views.comparison.choices import MethodChoice
from cpm_core import cli
from tests.benchmarks.claims.claims import scores
from tests.benchmarks.claims.trials import trials
from cpm_core.formats.sessions.session_file import SessionFile, load_session, save_session
from cpm_core.objects.methods import CONTOUR_METHODS, Compared

folder = Path(folder)
options = ["--methods", "growing", "--set", "growing.size=5", "--truth", str(folder / "disk.png"), "--json"]
paths = [str(folder / name) for name in ("a.csv", "a.png", "a.svg")]
assert cli.main(["compare", str(folder / "disk.png"), "--circle", "20,22,6", *options, "--export", *paths]) == 0
compared = Compared(("growing",)).with_settings("growing", CONTOUR_METHODS["growing"].settings(7))
save_session(SessionFile(comparison=compared), folder / "a.cpm")
assert load_session(folder / "a.cpm").comparison == compared
assert [score.method for score in scores(("growing",), list(islice(trials(), 1)))] == ["growing"]
application = QApplication([])
session = Session()
choice = MethodChoice(session)
assert choice.list.item(len(CONTOUR_METHODS) - 1).text() == "Growing"
session.edit("compare", lambda document: replace(document, comparison=compared))
choice.mark("growing")
assert choice.fields["size"].value() == 7 and choice.about.text() == "It grows.\\nnobody"
session.close()
'''


def test_a_module_and_a_line_make_a_method_that_is_known_everywhere(tmp_path):
    disk = np.hypot(*(np.indices((40, 44)) - np.array([20, 22])[:, None, None])) < 12
    PIL.Image.fromarray((255 * disk).astype(np.uint8)).save(tmp_path / "disk.png")
    (tmp_path / "growing.py").write_text(MODULE, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, registry.__file__, str(tmp_path)],
        capture_output=True, text=True, check=False, env=os.environ | {"QT_QPA_PLATFORM": "offscreen"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    (row,) = json.loads(done.stdout)["methods"]
    assert (row["method"], row["steps"], row["stop_reason"]) == ("growing", 5, "it is large enough")
    assert row["dice"] > 0.8
    assert {path.name for path in tmp_path.glob("a.*")} == {"a.csv", "a.png", "a.svg", "a.cpm"}
