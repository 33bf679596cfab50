"""What is handed out works by itself: the wheel and the archive of the source, outside the checkout."""

import os
import shutil
import subprocess
import sys
import tarfile
import zipfile

import pytest

from tests.packages.places import ROOT, hand_out

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def handed_out(tmp_path_factory):
    """The folder with the wheel and the archive of the source."""
    folder = tmp_path_factory.mktemp("handed out")
    hand_out(ROOT, folder)
    return folder


@pytest.fixture(scope="module")
def wheel(handed_out):
    (found,) = handed_out.glob("*.whl")
    return found


@pytest.fixture(scope="module")
def source(handed_out, tmp_path_factory):
    """The unpacked archive of the source."""
    (found,) = handed_out.glob("*.tar.gz")
    folder = tmp_path_factory.mktemp("source")
    with tarfile.open(found) as archive:
        archive.extraction_filter = getattr(tarfile, "data_filter", None)  # early releases of Python 3.11 have none
        archive.extractall(folder)
    return next(folder.iterdir())


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """The folder into which the wheel has been installed, without what it depends on."""
    folder = tmp_path_factory.mktemp("installed")
    command = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-index", "--target", folder, wheel]
    subprocess.run(command, check=True, env=os.environ | {"PIP_DISABLE_PIP_VERSION_CHECK": "1"})
    return folder


def printed(installed, place, *arguments):
    """What Python prints in another folder, where it finds the installed copy and no checkout."""
    environment = os.environ | {"PYTHONPATH": str(installed), "PYTHONUTF8": "1", "QT_QPA_PLATFORM": "offscreen"}
    command = [sys.executable, "-P", *map(str, arguments)]
    done = subprocess.run(
        command, cwd=place, capture_output=True, text=True, encoding="utf-8", env=environment, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_archive_holds_all_that_the_project_consists_of(source) -> None:
    if shutil.which("git") is None or not (ROOT / ".git").exists():
        pytest.skip("only git in a checkout knows what the project consists of")
    tracked = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True)
    names = {path.relative_to(source).as_posix() for path in source.rglob("*") if path.is_file()}
    left_out = {name for name in tracked.stdout.splitlines() if name not in names and (ROOT / name).exists()}
    assert {name for name in left_out if not name.startswith((".git", ".pre-commit"))} == set()


def test_the_same_bytes_are_built_elsewhere_at_another_time(source, handed_out, tmp_path) -> None:
    elsewhere = shutil.copytree(source, tmp_path / "elsewhere", ignore=shutil.ignore_patterns("PKG-INFO"))
    for path in elsewhere.rglob("*"):
        os.utime(path, (1e9, 1e9))
        path.chmod(path.stat().st_mode & 0o700)
    hand_out(elsewhere, tmp_path / "again")
    files = sorted(path.name for path in handed_out.iterdir())
    assert len(files) == 2
    for name in files:
        assert (tmp_path / "again" / name).read_bytes() == (handed_out / name).read_bytes()


def test_the_wheel_is_small(wheel) -> None:
    assert wheel.stat().st_size < 5e6


def test_the_wheel_holds_nothing_that_only_developers_need(wheel) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    assert {name.partition("/")[0].partition("-")[0] for name in names} == {"cpm_app", "cpm_core", "cpm_particles"}
    assert [name for name in names if "test" in name.split("/")[0] or name.endswith((".po", ".pyc"))] == []


def test_the_command_line_of_the_wheel_reads_its_samples(installed, tmp_path) -> None:
    sample = installed / "cpm_app" / "assets" / "samples" / "vessels.tif"
    assert "vessels.tif" in printed(installed, tmp_path, "-m", "cpm_app", "info", sample)
    where = printed(installed, tmp_path, "-c", "import cpm_app, cpm_core; print(cpm_app.__file__, cpm_core.__file__)")
    assert where.count(str(installed)) == 2


WINDOW = """
from cpm_app.model.document.samples import samples
from cpm_app.model.text.language import languages
from cpm_app.session.features.workspace import Workspace
from cpm_app.views.application import make_application
from cpm_app.views.main_window import make_window
application = make_application()
window = make_window(Workspace())
window.show()
application.processEvents()
assert all(sample.path.is_file() and sample.picture.is_file() for sample in samples())
print(len(samples()), len(languages()), window.isVisible())
window.close()
"""


def test_the_window_of_the_wheel_finds_its_pictures_samples_and_languages(installed, tmp_path) -> None:
    shown = printed(installed, tmp_path, "-c", WINDOW).split()
    assert int(shown[0]) >= 8
    assert int(shown[1]) >= 2
    assert shown[2] == "True"
