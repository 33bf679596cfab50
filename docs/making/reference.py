"""The reference: a page for each group of public names, from their docstrings."""

from __future__ import annotations

import inspect

import cpm_core

GROUPS: dict[str, tuple[str, tuple[str, ...]]] = {
    "runs": (
        "Runs",
        ("segment", "run", "evolve", "Evolution", "RunState", "Engine", "State", "Particles", "Forces", "Energies",
         "Parameters", "PARAMETERS", "PRESETS", "Method", "METHODS"),
    ),
    "images": (
        "Images",
        ("Image", "Geometry", "load_image", "load_volume", "load_pages", "example", "edge_map", "electric_field"),
    ),
    "starts": (
        "Where particles start, and what limits and steers them",
        ("circle", "stroke", "uniform_grid", "gradient_threshold", "divergence_centers", "sphere",
         "seeds_on_box", "seeds_in_slice", "seeds_everywhere", "seeds_on_strong_edges", "seeds_at_centers", "Regions",
         "VolumeRegions", "Extrusion", "PlacedCharge", "coulomb_force"),
    ),
    "results": (
        "What is found, and how it is measured",
        ("Result", "Contour", "Bridge", "Face", "Surface", "Table", "measure", "containment", "reconstruct_curve",
         "reconstruct_surface", "compare", "Comparison", "Truth", "load_truth", "compare_surface",
         "SurfaceComparison", "VolumeTruth", "load_volume_truth"),
    ),
    "objects": (
        "Objects selected by prompts",
        ("select", "select_all", "partition", "Partition", "Selection", "VolumePartition",
         "objects_result", "MODELS", "fetch_model", "notebook_view", "NotebookView"),
    ),
    "skeletons": ("Skeletons", ("skeleton", "Skeleton", "centerlines", "Centerlines")),
    "files": (
        "Files and pictures",
        ("export", "to_bytes", "load_contours", "load_surface", "load_centerlines", "load_points", "write_figure",
          "write_animation"),
    ),
    "stacks": ("Stacks and time series", ("follow_pages", "Page", "TrackEvent")),
    "methods": (
        "Classical methods",
        ("CONTOUR_METHODS", "ContourMethod", "ContourState", "Start", "run_method", "iterate_method", "report_run",
         "RunReport", "register_method"),
    ),
}  # fmt: skip
"""File -> title and public names."""


def pages() -> dict[str, str]:
    """Name of each page -> its text; ValueError unless every public name is on one of them."""
    listed = [name for _, names in GROUPS.values() for name in names]
    lacking = set(cpm_core.__all__) - set(listed)
    if lacking or len(set(listed)) != len(listed):
        raise ValueError(f"docs/making/reference.py lacks {sorted(lacking)}, or lists a name twice.")
    made = {f"reference/{file}.rst": _page(title, names) for file, (title, names) in GROUPS.items()}
    entries = "\n".join(f"   {file}" for file in GROUPS)
    intro = (
        "Everything is in ``cpm_core``, which the examples import as ``cpm``, and NumPy as ``np``. "
        "The tests run them.\n\n"
    )
    made["reference/index.rst"] = f"{_title('Reference')}{intro}.. toctree::\n\n{entries}\n"
    return made


def _page(title: str, names: tuple[str, ...]) -> str:
    """Write a page of some names."""
    return _title(title) + "\n".join(map(_entry, names))


def _title(text: str) -> str:
    return f"{text}\n{'=' * len(text)}\n\n"


def _entry(name: str) -> str:
    """Return the directive for one name."""
    given = getattr(cpm_core, name)
    if inspect.isclass(given):
        return f".. autoclass:: cpm_core.{name}\n"
    if callable(given):
        return f".. autofunction:: cpm_core.{name}\n"
    about, example = TABLES[name]
    keys = ", ".join(f"``{key}``" for key in given)
    shown = "\n".join(f"      {line}" for line in example.splitlines())
    return f".. py:data:: cpm_core.{name}\n\n   {about}: {keys}.\n\n   .. code-block:: pycon\n\n{shown}\n\n"


TABLES = {
    "PARAMETERS": (
        "Description of every parameter that is a number, by name",
        ">>> cpm.PARAMETERS['beta'].title, cpm.PARAMETERS['beta'].equation\n('Damping', 'eq. (12)')\n",
    ),
    "PRESETS": (
        "Named parameters",
        ">>> result = cpm.segment(cpm.example('disk'), cpm.circle((32, 32), 8), cpm.PRESETS['shape'])\n"
        ">>> len(result.contours)\n1\n",
    ),
    "MODELS": ("Larger models that can be fetched, by name", ">>> cpm.MODELS['sam2:tiny'].megabytes\n150\n"),
    "METHODS": ("All methods, by name", ">>> cpm.METHODS['cpm'].title\n'Charged particles'\n"),
    "CONTOUR_METHODS": (
        "Methods that can be compared, by name",
        ">>> cpm.CONTOUR_METHODS['gvf'].title\n'GVF snake'\n",
    ),
}
"""What each public table is, and an example, which the tests run."""
