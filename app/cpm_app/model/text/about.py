"""Facts about the program: version, license, the paper, and the versions of its libraries."""

from __future__ import annotations

import platform

from cpm_app.model.text.language import tr
from cpm_core import __version__

PROGRAM_PURPOSE = tr("Finds objects and contours in images with charged particles.")

PAPER_CITATION = tr(
    "A. C. Jalba, M. H. F. Wilkinson and J. B. T. M. Roerdink, “CPM: A deformable model for shape recovery and "
    "segmentation based on charged particles”, IEEE Transactions on Pattern Analysis and Machine Intelligence 26 (10), "
    "2004."
)

LICENSE_SENTENCE = tr("Free software under the MIT license.")

_LIBRARY_NAMES = {
    "PySide6-Essentials": "Qt and PySide6",
    "pyqtgraph": "pyqtgraph",
    "numpy": "NumPy",
    "scipy": "SciPy",
    "scikit-image": "scikit-image",
    "numba": "Numba",
    "pillow": "Pillow",
    "tifffile": "tifffile",
}
"""Names of the libraries as users know them, by package."""


def list_versions() -> tuple[tuple[str, str], ...]:
    """Return names and versions of the program, of Python, of its libraries and of the system."""
    from importlib import metadata  # only here, because it takes long to import

    used = [("CPM", __version__), ("Python", platform.python_version())]
    for package, name in _LIBRARY_NAMES.items():
        try:
            used.append((name, metadata.version(package)))
        except metadata.PackageNotFoundError:  # as in a copy that was put together by hand
            used.append((name, tr("unknown")))
    return (*used, (tr("System"), platform.platform()))
