"""The table of the figures of the gallery; writing of their pictures, the index and the measured values."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from cpm_core.formats.common.atomic import write_together
from docs.gallery import pictures, recovery, silhouettes, skeletons, studies
from docs.gallery.pages import Page
from docs.gallery.plotting import draw
from docs.gallery.recovery import from_start_to_result

INDEX, MEASURED = "README.md", "figures.json"

_TOLERANCE = 1.5
"""Distance up to which contours agree with the truth in scenes like photographs [px]."""


@dataclass(frozen=True)
class Figure:
    """An experiment of the gallery: name of its file without the suffix, heading, description, and its function."""

    name: str
    title: str
    about: str
    build: Callable[[], Page]


_TABLE = (
    Figure(
        "fig05", "Convergence", "From a circle over one corner the particles reach the edge and creep all along it.",
        recovery.convergence,
    ),
    Figure(
        "fig06", "Insertion and deletion",
        "58 particles alone are too few for the shape; with insertion and deletion even five of them become enough.",
        recovery.population,
    ),
    Figure(
        "fig07", "Initialization", "The start may lie inside, outside, across the boundary or at one corner.",
        partial(from_start_to_result, silhouettes.silhouettes),
    ),
    Figure(
        "fig08", "Boundary concavities", "Particles push one another along the edges to the end of narrow bays.",
        partial(from_start_to_result, silhouettes.concavities),
    ),
    Figure(
        "fig09", "Embedded objects and topology",
        "Junctions, objects in objects and rings in rings from one circle; separate objects from several.",
        partial(from_start_to_result, silhouettes.embedded),
    ),
    Figure(
        "fig10", "Damping decides how many objects are found",
        "Particles start next to the ellipse. With little damping they coast on to the border and across it, with more "
        "they stay at the first edges. At which values depends on the strength of the edges, which the publication "
        "does not give: at its 0.6, 1.0 and 1.2 the same is found here, and a weak border not monotonically.",
        recovery.damping,
    ),
    Figure(
        "fig11", "Vessels and textures", "Drawn images with noise, uneven light, and texture around or on the object.",
        partial(from_start_to_result, pictures.textures, _TOLERANCE),
    ),
    Figure(
        "fig12", "Automatic segmentation",
        "Starts that need no drawing: on strong gradients (cells, chromosomes) and all over the image (hand, head).",
        partial(from_start_to_result, pictures.medical, _TOLERANCE),
    ),
    Figure(
        "fig13", "Automatic segmentation of natural scenes", "Drawn scenes with shading and texture, started on strong "
        "gradients.",
        partial(from_start_to_result, pictures.natural, _TOLERANCE),
    ),
    Figure(
        "fig14", "Skeletons",
        "Middle lines of black and white and of grey shapes, and the shapes rebuilt from them and their radii.",
        skeletons.skeletons,
    ),
    Figure(
        "fig17", "Sensitivity to parameters",
        "A shape under five weight ratios and five annealing factors, the extremes included; then both weights and "
        "damping with a second shape that particles must travel to. Little repulsion leaves bays unfilled; at the "
        "weights of the publication no annealing fails, since it counts for each particle.",
        studies.sensitivity,
    ),
    Figure(
        "fig18", "Noise", "One object and one start under three kinds of noise, smoothing chosen from the image.",
        studies.noise,
    ),
)  # fmt: skip

FIGURES: dict[str, Figure] = {figure.name: figure for figure in _TABLE}
"""All figures by name, in their order."""


def write_figures(
    folder: Path,
    names: Sequence[str] = (),
    progress: Callable[[Figure, Mapping[str, Any]], object] | None = None,
) -> list[Path]:
    """Repeat experiments and write their pictures, the index of the folder and the measured values.

    All figures unless `names` are given. The folder is made when it is missing; its entries for other figures are kept.
    `progress` is called with each finished figure and its entry, which holds heading and results. Returns the files
    written. ValueError, before anything is written, when a name is unknown, matplotlib is missing, or the folder is
    not writable.
    """
    unknown = [name for name in names if name not in FIGURES]
    if unknown:
        raise ValueError(f"there is no figure {unknown[0]}: choose among {', '.join(FIGURES)}.")
    _check_folder(folder)
    entries = _entries(folder)
    files = []
    for name, figure in FIGURES.items():
        if names and name not in names:
            continue
        page = figure.build()
        title = f"{figure.title}, in the manner of Fig. {int(name[3:])}"
        files.append((folder / f"{name}.png", draw(page, title)))
        entries[name] = _entry(figure, title, page)
        if progress is not None:
            progress(figure, entries[name])
    ordered = {name: entries[name] for name in FIGURES if name in entries}
    files.append((folder / MEASURED, (json.dumps(ordered, indent=1, ensure_ascii=False) + "\n").encode()))
    files.append((folder / INDEX, _index(ordered).encode()))
    folder.mkdir(parents=True, exist_ok=True)
    write_together(files)
    return [path for path, _ in files]


def _check_folder(folder: Path) -> None:
    """Raise ValueError unless a folder exists or can be made."""
    there = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    if not there.is_dir():
        raise ValueError(f"{there} is a file, so {folder} cannot be a folder: name another one.")
    if not os.access(there, os.W_OK | os.X_OK):
        raise ValueError(f"{there} is not writable: name another folder.")


def _entries(folder: Path) -> dict[str, Any]:
    """Entries of the figures that are in a folder already."""
    path = folder / MEASURED
    if not path.exists():
        return {}
    try:
        entries = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        entries = None
    if not isinstance(entries, dict):
        raise ValueError(f"{path} cannot be read: remove it or name another folder.")
    return entries


def _entry(figure: Figure, title: str, page: Page) -> dict[str, Any]:
    panels = [{"panel": panel.title, **panel.facts} for panel in page.panels if panel.facts]
    results = [panel for panel in panels if "recall" in panel and "snapshot" not in panel] if page.alike else []
    measured = "; ".join(filter(None, (page.note, summary(results))))
    return {"title": title, "about": figure.about, "measured": measured, "panels": panels}


def summary(results: Sequence[Mapping[str, Any]]) -> str:
    """Sentence on several results: ranges of their values, and sums of closed contours."""

    def span(key: str, places: int) -> str:
        values = [result[key] for result in results if result[key] is not None]
        low, high = f"{min(values):.{places}f}", f"{max(values):.{places}f}"
        return low if low == high else f"{low} to {high}"

    if not results:
        return ""
    wanted = sum(result["closed_true"] for result in results)
    closed = f"{sum(result['closed'] for result in results)} of {wanted} closed contours, " if wanted else ""
    return (
        f"recall {span('recall', 3)} and precision {span('precision', 3)} within {span('tolerance_px', 1)} px, "
        f"mean distance {span('mean_distance_px', 3)} px, {closed}{span('steps', 0)} steps, "
        f"{span('particles', 0)} particles"
    )


def _index(entries: Mapping[str, Any]) -> str:
    """Text of the index: description, measured values and picture of each entry."""
    lines = [
        "# Gallery",
        "",
        "Results of CPM on synthetic images, after the experiments of the paper. All boundaries are known exactly, so "
        "that the error of the contours can be measured: *recall* is the share of the true boundary that has a contour "
        "within the tolerance, *precision* the share of the contours that has the true boundary within the tolerance, "
        "*mean distance* the average symmetric distance of both; *closed contours* counts the true closed contours "
        "that were recovered as one closed contour.",
        "",
        f"`python -m docs.gallery --output DIR` repeats all of it; `{MEASURED}` holds every number.",
    ]
    for name, entry in entries.items():
        lines += ["", f"## {entry['title']}", "", f"{entry['about']} Measured: {entry['measured']}.", ""]
        lines.append(f"![{entry['title']}]({name}.png)")
    return "\n".join(lines) + "\n"
