"""Makes an application that needs no Python: a folder with the program, its libraries and licenses.

Run ``python release/freeze.py`` in an environment with the program and PyInstaller (see ``release/README.md``), on the
system that the application is for: Linux, Windows or macOS. The folder is ``dist/cpm``, or ``cpm`` in that of
``--output``; ``dist/cpm/cpm`` opens the window, and with arguments it is the command line.
"""

from __future__ import annotations

import argparse
import os
import re
import struct
import subprocess
import sys
from collections.abc import Iterator, Sequence
from functools import partial
from importlib import metadata
from importlib.util import find_spec
from itertools import accumulate, pairwise
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
    *("PySide6.QtQml", "PySide6.QtQuick", "PySide6.QtSql", "PySide6.QtNetwork", "PySide6.QtTest", "PySide6.QtOpenGL"),
    *("matplotlib", "networkx", "pydoc_data", "readline", "numba.np.ufunc.omppool", "numba.np.ufunc.tbbpool"),
    *("PIL.AvifImagePlugin", "PIL._avif", "skimage.data", "skimage.io", "skimage.filters.rank"),
    *("scipy.io", "scipy.integrate", "scipy.stats", "scipy.special.cython_special"),
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

UNUSED = (
    *("cpm_app/assets/languages/**/*.po", "*.dist-info/RECORD", "pyqtgraph/icons/peegee/*"),
    *("skimage/feature/*.so", "skimage/restoration/*.so", "skimage/util/_remap*.so", "skimage/transform/_[hr]*.so"),
    *("PySide6/Qt/plugins/egldeviceintegrations/*", "PySide6/Qt/plugins/generic/*", "PySide6/Qt/lib/libQt6Egl*"),
    *("PySide6/Qt/plugins/platforms/libq[elv]*", "PySide6/Qt/plugins/platforms/libqminimalegl*"),
    *("PySide6/Qt/lib/libQt6Network*", "PySide6/Qt/plugins/imageformats/libq[itw]*"),
)
"""Files that come with others and are not needed, such as those of Qt for screens without a window system."""

PYTHONS = re.compile(r"lib(python|crypto|ssl|z|bz2|lzma|ffi|uuid|expat|sqlite3|mpdec)[-.\d]")
"""Libraries of the system that Python needs; those of windows are not taken along, as in the packages of pip."""


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
            for name in (*UNSEEN, *lazy(), *(f"imagecodecs._{codec}" for codec in CODECS))
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
    for unused in (path for pattern in UNUSED for path in (folder / "_internal").glob(pattern)):
        unused.unlink()
    if sys.platform == "linux":
        _without_the_system(folder / "_internal", work)
    for texts in folder.glob("_internal/PySide6/**/translations/*.qm"):
        if not any(texts.stem.startswith(f"qtbase_{language}") for language in ("de", "es", "fr", "ja", "zh")):
            texts.unlink()
    (folder / "LICENSES.txt").write_text(gathered(), encoding="utf-8")
    return folder


def lazy() -> list[str]:
    """Modules of SciPy and scikit-image that the program names; these libraries load them on first use."""
    sources = (path for folder in ("cpm_core", "app/cpm_app") for path in (ROOT / folder).rglob("*.py"))
    named = (re.findall(r"\b(?:scipy|skimage)[.][a-z_]+(?:[.][a-z_]+)?", path.read_text("utf-8")) for path in sources)
    names = {part for found in named for name in found for part in (name, name.rpartition(".")[0])}
    return sorted(name for name in names if find_spec(name))


def _without_the_system(folder: Path, work: Path) -> None:
    """Leave out what Linux has itself, what is there twice, symbols for debuggers, and most of ICU."""
    for library in folder.glob("lib*.so*"):
        if not (library.exists() if library.is_symlink() else PYTHONS.match(library.name)):
            library.unlink()
    for twice in (folder / "scipy.libs").iterdir():
        if (folder / "numpy.libs" / twice.name).is_file():  # in memory under this name before SciPy is loaded
            twice.unlink()
    # not those that auditwheel has changed, which would no longer be loaded, nor those of Qt, which have no symbols
    found = (path for path in folder.rglob("*.so*") if path.is_file() and not path.is_symlink())
    libraries = [path for path in found if not re.search(r"[.]libs/|PySide6/", path.as_posix())]
    subprocess.run(["strip", "--strip-unneeded", *map(str, libraries)], check=True)
    for library in folder.glob("PySide6/Qt/lib/libicudata.so.*"):
        (work / "icu").write_bytes(_collations(library.read_bytes()))
        symbol = f"icudt{library.name.rpartition('.')[2]}_dat=_binary_icu_start"
        subprocess.run(["ld", "-r", "-z", "noexecstack", "-b", "binary", "icu", "-o", "icu.o"], check=True, cwd=work)
        linked = ["ld", "-shared", "-z", "noexecstack", "-soname", library.name, "--defsym", symbol, "icu.o"]
        subprocess.run([*linked, "-o", str(library)], check=True, cwd=work)


def _collations(data: bytes) -> bytes:
    """Of the data of ICU in a library those by which Qt sorts the names of files; all else Qt has in its own way.

    A header begins with its length; then follow the number of items, where the name and the content of each begin,
    the names, and the contents.
    """
    begin = data.index(b"CmnD") - 12
    start = begin + struct.unpack_from("<H", data, begin)[0]
    (count,) = struct.unpack_from("<I", data, start)
    places = list(struct.iter_unpack("<II", data[start + 4 : start + 4 + 8 * count]))
    items = [
        (data[start + name : data.index(b"\0", start + name) + 1], data[start + first : start + end])
        for (name, first), (_, end) in pairwise(places)
    ]
    kept = [(name, content) for name, content in items if b"/coll/" in name]
    names = [4 + 8 * len(kept), *(len(name) for name, _ in kept)]
    contents = [-(-sum(names) // 16) * 16, *(len(content) for _, content in kept)]
    table = b"".join(map(partial(struct.pack, "<II"), accumulate(names[:-1]), accumulate(contents[:-1])))
    head = struct.pack("<I", len(kept)) + table + b"".join(name for name, _ in kept)
    return data[begin:start] + head.ljust(contents[0], b"\0") + b"".join(content for _, content in kept)


def _data() -> Iterator[Path]:
    """Files of the core that are no modules, and not compiled for this computer."""
    for path in sorted((ROOT / "cpm_core").rglob("*.*")):
        if path.suffix in (".npz", ".json"):
            yield path.relative_to(ROOT)


def _picture(work: Path) -> Path:
    """Draw the icon in pixels, which PyInstaller turns into that of the system."""
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
