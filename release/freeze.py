"""Makes an application that needs no Python: a folder with the program, its libraries and licenses.

Run ``python release/freeze.py`` in an environment with the program and PyInstaller (see ``release/README.md``), on the
system that the application is for: Linux, Windows or macOS. The folder is ``dist/cpm``, or ``cpm`` in that of
``--output``; ``dist/cpm/cpm`` opens the window, and with arguments it is the command line.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
from collections.abc import Iterator, Sequence
from importlib import metadata
from pathlib import Path

from licenses import gathered

ROOT = Path(__file__).resolve().parents[1]

ASSETS = ("icons", "samples", "guide", "languages")
"""Files of the program's own that it reads, in the folder assets."""

NAMED = (
    *("numpy", "scipy", "scikit-image", "numba", "llvmlite", "pillow", "tifffile", "pyqtgraph", "PySide6-Essentials"),
    *("imagecodecs", "pydicom"),
)
"""Distributions whose versions the program tells, or that look for themselves."""

LEFT_OUT = (
    *("tkinter", "IPython", "pytest", "setuptools", "PyQt5", "PyQt6", "pandas", "numba.cuda", "numba.tests", "OpenGL"),
    *("PySide6.QtQml", "PySide6.QtQuick", "PySide6.QtSql", "PySide6.QtNetwork", "PySide6.QtTest"),
    *("matplotlib", "networkx", "pydoc_data"),
    *("PIL.AvifImagePlugin", "PIL._avif", "scipy.io", "skimage.data", "skimage.io", "skimage.filters.rank"),
)
"""What is installed here or named by a library, and not needed."""

CODECS = (
    *("imcd", "shared", "shared_cython", "zlib", "deflate", "lzma", "zstd", "lerc", "ccitt", "bitshuffle"),
    *("jpeg8", "jpegls", "jpegsof3", "ljpeg", "jpeg2k", "jpegxl", "jpegxr", "png", "webp"),
)
"""Modules of imagecodecs for what TIFF, DICOM and pictures contain; others are left out."""

UNSEEN = ("numba._devicearray", "numba.mviewbuf")
"""Modules that only compiled code loads."""

MEDICAL = {"nibabel": "nibabel", "pynrrd": "nrrd"}
"""Readers that are taken along where they are installed: distributions and their modules, which are loaded by name."""

LATE = ("cpm_core.cli", "cpm_app.views.features", "cpm_core.formats", "pydicom.pixels")
"""Packages of which modules are loaded by name, or late."""


def frozen(output: Path, work: Path) -> Path:
    """Freeze the program into a folder; what is made on the way stays in another, and is used again."""
    options = [
        *("--name", "cpm", "--noconfirm", "--clean", "--onedir", "--paths", f"{ROOT}{os.pathsep}{ROOT / 'app'}"),
        *("--distpath", str(output), "--workpath", str(work / "pyinstaller"), "--specpath", str(work)),
        *(part for name in ASSETS for part in ("--add-data", f"{ROOT / 'assets' / name}:cpm_app/assets/{name}")),
        *(part for name in NAMED if _is_there(name) for part in ("--copy-metadata", name)),
        *(part for name in LATE for part in ("--collect-submodules", name)),
        *(
            part
            for name in (*UNSEEN, *(f"imagecodecs._{codec}" for codec in CODECS))
            for part in ("--hidden-import", name)
        ),
        *(part for name, module in MEDICAL.items() if _is_there(name) for part in ("--hidden-import", module)),
        *(part for file in _data() for part in ("--add-data", f"{ROOT / file}:{file.parent}")),
        *(part for name in LEFT_OUT for part in ("--exclude-module", name)),
    ]
    if sys.platform in ("win32", "darwin"):
        options += ["--icon", str(_picture(work))]
    if sys.platform == "darwin":
        options += ["--windowed", "--osx-bundle-identifier", "org.cpm_particles.cpm"]
    environment = os.environ | {"PYTHONPATH": f"{ROOT}{os.pathsep}{ROOT / 'app'}"}
    start = str(Path(__file__).with_name("start.py"))
    subprocess.run([sys.executable, "-m", "PyInstaller", *options, start], check=True, cwd=work, env=environment)
    folder = output / "cpm"
    if sys.platform == "linux":
        # not those that auditwheel has changed, which would no longer be loaded, nor those of Qt, which have no symbols
        found = (path for path in folder.rglob("*.so*") if path.is_file() and not path.is_symlink())
        libraries = [path for path in found if not re.search(r"[.]libs/|PySide6/", path.as_posix())]
        subprocess.run(["strip", "--strip-unneeded", *map(str, libraries)], check=True)
    for texts in folder.glob("_internal/PySide6/**/translations/*.qm"):
        if not any(texts.stem.startswith(f"qtbase_{language}") for language in ("de", "es", "fr", "ja", "zh")):
            texts.unlink()
    (folder / "LICENSES.txt").write_text(gathered(), encoding="utf-8")
    return folder


def _data() -> Iterator[Path]:
    """Files of the core that are no modules, and not compiled for this computer."""
    for path in sorted((ROOT / "cpm_core").rglob("*.*")):
        if path.suffix in (".npz", ".json"):
            yield path.relative_to(ROOT)


def _picture(work: Path) -> Path:
    """The icon in pixels, which PyInstaller turns into that of the system."""
    from PySide6.QtGui import QImage, QPainter
    from PySide6.QtSvg import QSvgRenderer

    image = QImage(512, 512, QImage.Format.Format_ARGB32)
    image.fill(0)
    painter = QPainter(image)
    QSvgRenderer(str(ROOT / "assets" / "icons" / "cpm.svg")).render(painter)
    painter.end()
    path = work / "cpm.png"
    image.save(str(path))
    return path


def _is_there(name: str) -> bool:
    try:
        metadata.version(name)
    except metadata.PackageNotFoundError:
        return False
    return True


def size(folder: Path) -> int:
    """Bytes of all files in a folder; links count once."""
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file() and not path.is_symlink())


def main(argv: Sequence[str] | None = None) -> int:
    """Freeze, and tell where the application is and how large."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, default=ROOT / "dist", help="folder to write into (default: dist)")
    parser.add_argument("--work", type=Path, default=ROOT / "build", help="folder for what is made on the way")
    arguments = parser.parse_args(argv)
    arguments.work.mkdir(parents=True, exist_ok=True)
    folder = frozen(arguments.output.absolute(), arguments.work.absolute())
    sys.stdout.write(f"{folder}: {size(folder) / 1e6:.0f} MB\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
