"""CPM: contours by charged particles.

The charged-particle model of Jalba, Wilkinson and Roerdink (2004): arrays in, arrays out, no user interface.

The model on one page
---------------------
1. The image is smoothed by a Gaussian of width sigma; the magnitude of its gradient is the **edge map** f. Every pixel
   carries a **fixed charge** -f (`field.edge_map`). Automatic smoothing derives sigma from the noise, and removes heavy
   noise first (`image.denoising`); the edge of a dark or bright image border can be left out (`image.border`).
2. The fixed charges make an **electric field**, E(r) = sum_k -f_k (r - R_k) / |r - R_k|^3, eq. (8), which pulls
   positive charges to edges (`field.convolution`). Its direction is the **Lorentz force** F_l, which passes linearly
   through zero across an edge (`field.scale_field`).
3. The **particles** all have the same positive charge and repel each other: the **Coulomb force** F_c, eq. (9)
   (`model.coulomb`), scaled by the local spacing and clipped at one. With many particles, close pairs are summed at
   every step, and the rest is interpolated from a mesh that is updated every few steps (`model.plane.repulsion`).
4. They move by F = w1 F_c + w2 F_l - beta v, eq. (12), where the last term is the **damping**; one **step** advances
   them by eq. (14)-(15) (`model.equations`, `model.plane.motion`). Particles that leave the image are removed.
5. A particle has **edge contact** where the Lorentz force is weak and the edge strong enough (`model.plane.motion`).
   **Insertion**: between two neighbors with edge contact, d_min < d <= d_min + d_max apart, a particle is inserted if
   the **ridge** of the edge is free there, and ahead of a particle whose edge continues without other particles.
   **Deletion**: of two closer than d_min / 2, one is deleted. **Annealing**: every step multiplies d_max by a
   (`model.plane.births`, `model.plane.step`).
6. **Coverage** records the cells in which particles have had edge contact (`model.coverage`). Where no new cells are
   covered, repulsion fades and damping grows, more slowly for particles that still move far from all covered cells;
   a particle at rest there is skipped until that changes. A run is in **equilibrium** when eq. (23) holds and hardly
   any particle has moved, been inserted or been deleted for twenty steps (`model.equations`). **Completion**: before a
   run ends, **reseeding** places particles next to boundaries without any, if the enclosed region was reached on
   another boundary: the outline around a hole, or a hole in an object (`model.plane.enclosed_regions`). Particles at
   rest off the edges are then removed.
7. This is repeated at each **scale** of the image, from coarse to fine (`image.pyramid`, `field.scale_space`,
   `model.plane.step`). Each scale begins with the particles of the coarser one and with the **initialization**: the
   seeds, drawn or automatic (`model.starts`).
8. The **reconstruction** moves points to the ridge of the edge and joins them along the ridge into closed and open
   **contours** with **junctions**. It leaves out contours that are weak or have the same gray levels on both sides
   (`field.region_contrast`), and **bridges** gaps up to `max_gap` (`reconstruction.curve`).
9. Particles stay inside the **regions of interest** and on their side of the **barriers**; at each
   scale no move, insertion, contour or bridge crosses a barrier (`image.regions`).
10. **Placed charges** attract or repel the particles around them, one to four times as strongly as the edges; their
    force is added to the Lorentz force (`field.placed_charges`). An **intervention** changes charges, parameters,
    regions or barriers, or adds or erases particles, at any step; particles at rest that it affects are reactivated
    (`model.interventions`).
11. The terms of a step can be inspected: the **forces** on each particle, by name, the **potential** of the charges,
    and the kinetic and potential **energy**, which damping dissipates until the run is at rest (`model.measures`).

`Engine` composes them step by step (`segmentation.engine`); `segment` is a whole run in one call, `run` that of a saved
session, `evolve` an iterator over its steps, and `follow_pages` runs on each page of a stack, starting from the
contours of the previous page (`pages`). `contours.measurements` measures each contour and finds its nesting;
`Result.labels` and `Result.table` are
the enclosed pixels and their measurements. Given a **ground truth**, as a mask or as contours, `compare` measures the
agreement with it (`contours.agreement`, `contours.ground_truth`), and in a volume `compare_surface` that of the
surface. `formats` reads and writes files: `export` selects the format of contours by the suffix, `to_bytes` returns the
same as bytes; `load_contours`, `load_surface`, `load_centerlines` and `load_points` read them. `write_animation` shows
a run frame by frame; `write_figure` draws image and contours for a publication, as does ``plot`` of images and results
on axes of matplotlib.

The **skeleton** is the medial line of an object with the distance to its boundary, from which the object can be
reconstructed (`medial_axis`). It needs no seeds. In a volume it consists of the center lines of vessels
(`medial_axis.centerlines`). Contours and skeletons both come from a `Method`, which the same loop runs step by step.

**Objects** are selected by points, scribbles and boxes, with `select` and `select_all`: an object is the region that a
closed contour encloses unambiguously, elsewhere the one predicted by a network trained on outlined images
(`objects`). `Result.objects` are those that a run proposes, wherever it was made. In a notebook they are clicked in a
`notebook_view`.

The **classical methods** to which the publication compares its own, snakes and level sets, are listed with the charged
particles in `CONTOUR_METHODS`: from the same image and the same drawn `Start`, each yields the states of a run one by
one (`methods`). `METHODS` has all methods by name; `register_method` adds one.

Words
-----
Positions are (row, col) in pixels, pixel centers at integers. *Idle* counts steps without newly covered cells. A
`State` is one step of a run and determines the next one without any other memory; a `Result` is the outcome of a run; a
`ScaleField` holds the fields of one scale.
"""

from cpm_core.contours.agreement import Comparison, compare
from cpm_core.contours.contour import Bridge, Contour
from cpm_core.contours.faces import Face
from cpm_core.contours.ground_truth import Truth, VolumeTruth
from cpm_core.contours.measurements import containment, measure
from cpm_core.contours.region_table import Table
from cpm_core.contours.surface_agreement import SurfaceComparison, compare_surface
from cpm_core.field.edge_map import edge_map
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.formats import (
    export,
    load_centerlines,
    load_contours,
    load_image,
    load_pages,
    load_points,
    load_surface,
    load_volume,
    to_bytes,
)
from cpm_core.formats.animation import write_animation
from cpm_core.formats.common.provenance import VERSION
from cpm_core.formats.contours.figure import write_figure
from cpm_core.formats.ground_truth_file import load_truth, load_volume_truth
from cpm_core.formats.images.examples import example
from cpm_core.formats.sessions.session_run import run
from cpm_core.image.geometry import Geometry
from cpm_core.image.image import Image
from cpm_core.image.regions import Regions
from cpm_core.image.surface import Surface
from cpm_core.image.volume_regions import Extrusion, VolumeRegions
from cpm_core.medial_axis.centerlines import Centerlines, centerlines
from cpm_core.medial_axis.skeleton import Skeleton
from cpm_core.medial_axis.skeleton_method import skeleton
from cpm_core.methods import (
    CONTOUR_METHODS,
    METHODS,
    ContourMethod,
    ContourState,
    RunReport,
    Start,
    iterate_method,
    register_method,
    report_run,
    run_method,
)
from cpm_core.model.coulomb import coulomb_force
from cpm_core.model.measures import Energies, Forces
from cpm_core.model.starts import circle, divergence_centers, gradient_threshold, stroke, uniform_grid
from cpm_core.model.state import Particles, State
from cpm_core.model.volume.starts import (
    seeds_at_centers,
    seeds_everywhere,
    seeds_in_slice,
    seeds_on_box,
    seeds_on_strong_edges,
    sphere,
)
from cpm_core.notebook import NotebookView, notebook_view
from cpm_core.objects import Partition, Selection, VolumePartition
from cpm_core.objects.prior.larger_models import MODELS, fetch_model
from cpm_core.pages.follow import follow_pages
from cpm_core.pages.page import Page
from cpm_core.pages.tracks import TrackEvent
from cpm_core.parameters import PARAMETERS, PRESETS, Parameters
from cpm_core.published.crust import reconstruct_curve
from cpm_core.published.electric_field import electric_field
from cpm_core.published.surface_from_points import reconstruct_surface
from cpm_core.results import objects_result
from cpm_core.results.result import Result
from cpm_core.segmentation.engine import Engine
from cpm_core.segmentation.evolve import Evolution, RunState, evolve, segment
from cpm_core.segmentation.method import RUN_METHODS as RUN_METHODS
from cpm_core.segmentation.method import Method
from cpm_core.segmentation.select import partition, select, select_all

__version__ = VERSION

__all__ = [
    "CONTOUR_METHODS",
    "METHODS",
    "MODELS",
    "PARAMETERS",
    "PRESETS",
    "Bridge",
    "Centerlines",
    "Comparison",
    "Contour",
    "ContourMethod",
    "ContourState",
    "Energies",
    "Engine",
    "Evolution",
    "Extrusion",
    "Face",
    "Forces",
    "Geometry",
    "Image",
    "Method",
    "NotebookView",
    "Page",
    "Parameters",
    "Particles",
    "Partition",
    "PlacedCharge",
    "Regions",
    "Result",
    "RunReport",
    "RunState",
    "Selection",
    "Skeleton",
    "Start",
    "State",
    "Surface",
    "SurfaceComparison",
    "Table",
    "TrackEvent",
    "Truth",
    "VolumePartition",
    "VolumeRegions",
    "VolumeTruth",
    "centerlines",
    "circle",
    "compare",
    "compare_surface",
    "containment",
    "coulomb_force",
    "divergence_centers",
    "edge_map",
    "electric_field",
    "evolve",
    "example",
    "export",
    "fetch_model",
    "follow_pages",
    "gradient_threshold",
    "iterate_method",
    "load_centerlines",
    "load_contours",
    "load_image",
    "load_pages",
    "load_points",
    "load_surface",
    "load_truth",
    "load_volume",
    "load_volume_truth",
    "measure",
    "notebook_view",
    "objects_result",
    "partition",
    "reconstruct_curve",
    "reconstruct_surface",
    "register_method",
    "report_run",
    "run",
    "run_method",
    "seeds_at_centers",
    "seeds_everywhere",
    "seeds_in_slice",
    "seeds_on_box",
    "seeds_on_strong_edges",
    "segment",
    "select",
    "select_all",
    "skeleton",
    "sphere",
    "stroke",
    "to_bytes",
    "uniform_grid",
    "write_animation",
    "write_figure",
]
