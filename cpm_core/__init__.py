"""CPM: contours by charged particles.

The charged-particle model of Jalba, Wilkinson and Roerdink (2004): arrays in, arrays out, without any window.

The model on one page
---------------------
1. The image is smoothed by a Gaussian of width sigma; the length of its gradient is the **edge map** f. Every pixel
   carries a **fixed charge** -f (`field.edge_map`). Automatic smoothing chooses sigma by the noise, and removes heavy
   noise first (`image.denoising`); the edge of a dark or bright image border can be left out (`image.border`).
2. The fixed charges make an **electric field**, E(r) = sum_k -f_k (r - R_k) / |r - R_k|^3, eq. (8), which pulls
   positive charges to edges (`field.electric_field`). Its direction is the **Lorentz force** F_l; across an edge it
   falls linearly through zero (`field.scale_field`).
3. The **particles** all have the same positive charge and repel each other: the **Coulomb force** F_c, eq. (9)
   (`model.coulomb`), scaled by the local spacing and cut at one. In a run with many particles, near pairs are
   summed at every step, and a mesh, computed every few steps, carries the rest (`model.plane.repulsion`).
4. They move by F = w1 F_c + w2 F_l - beta v, eq. (12), the last term being the **damping**; one **step** advances
   them by eq. (14)-(15) (`model.equations`, `model.plane.motion`). Particles that leave the image are removed.
5. A particle has **edge contact** where the Lorentz force is weak and the edge strong enough (`model.plane.motion`).
   **Insertion**: two neighbors with edge contact, d_min < d <= d_min + d_max apart, get a particle between them if the
   **ridge** of the edge is free there; a particle whose edge continues without other particles gets one ahead.
   **Deletion**: of two nearer than d_min / 2 one is deleted. **Annealing**: every step multiplies d_max by a
   (`model.plane.births`, `model.plane.step`).
6. **Coverage** records the cells in which particles have had edge contact (`model.coverage`). Where no cells are
   newly covered, repulsion fades and damping grows, more slowly for particles that still move far from all covered
   cells; a particle that is at rest there is skipped until that changes. A run is in **equilibrium** when eq. (23)
   holds and hardly any particle has moved, been inserted or been deleted for twenty steps (`model.equations`).
   **Completion**: before a run ends, **reseeding** puts particles next to the boundaries that have none, of enclosed
   regions that have been reached on another boundary: the outline around a hole, or a hole in an object
   (`model.plane.enclosed_regions`). Particles at rest off the edges are then removed.
7. All this happens on one **scale** of the image after the other, from coarse to fine (`image.pyramid`,
   `field.scale_space`, `model.plane.step`). Each scale begins with the particles of the coarser one and with
   the **initialization**: the seeds, drawn or automatic (`model.starts`).
8. The **reconstruction** moves points to the ridge of the edge and joins them by following the ridge to closed and open
   **contours** with **junctions**. It leaves out what is weak or has the same gray levels on both sides
   (`field.region_contrast`), and builds **bridges** across gaps if `max_gap` allows them (`reconstruction.curve`).
9. Particles stay inside the **regions of interest** and on their side of the **barriers** (`image.regions`); at each
   scale no move, insertion, contour or bridge crosses a barrier (`image.barriers`).
10. **Placed charges** attract or repel the particles around them, as strongly as the edges or up to four times so;
    their force is added to the Lorentz force (`field.placed_charges`). An **intervention** changes charges, parameters,
    regions or barriers, or adds or erases particles, at any step; particles at rest that it concerns are reactivated
    (`model.interventions`).
11. The terms of a step can be examined: the **forces** on each particle, by name (`model.measures`), the **potential**
    of the charges, and the kinetic and potential **energy**, which the damping takes out of a run until it is at rest
    (`model.measures`).

`Engine` composes all of them, step by step (`segmentation.engine`); `segment` is a whole run in one call, `evolve` the
same as an iterator over its steps, and `follow` one on each page of a stack, from the contours of the page before
(`pages`). `contours.measurements` measures each contour and finds which lies in which; `Result.labels` and
`Result.table` are the pixels inside and their measurements. Where the **ground truth** is known, as a mask or as
contours, `compare` measures the agreement with it (`contours.agreement`, `contours.ground_truth`), and in a volume
`compare_surface` that of the surface.
`formats` reads and writes files: `export` chooses the format of contours by the suffix, `encoded` returns the same
without a file; `load_contours`, `load_surface`, `load_centerlines` and `load_points` read them. `write_animation`
shows a run frame by frame; `write_figure` draws image and contours for a publication, and so does ``plot`` of images
and results, on axes of matplotlib.

The **skeleton** is the middle line of an object with the distance to its boundary, from which the object can be
reconstructed (`medial_axis`). It needs no seeds. In a volume it is the center lines
of vessels (`medial_axis.centerlines`). Contours and skeletons both come from a `Method`, which the same loop
runs step by step.

**Objects** are chosen by places, strokes and boxes, with `select` and `select_all`: they are what a closed contour
encloses beyond doubt, elsewhere what a prior expects that was learned from outlined images (`objects`). In a
notebook they are clicked in a `view`.

The **classical methods** that the publication argues against, snakes and level sets, stand beside the charged particles
in `CONTOUR_METHODS`: from the same image and the same drawn `Start` each gives the states of a run, one after the other
(`objects.methods`). `METHODS` has all methods by name.

Words
-----
Positions are (row, col) in pixels, pixel centers at integers. *Idle* counts steps without newly covered cells. A
`State` is a moment of a run, from which the next one follows without any other memory; a `Result` is what a run has
found; a `ScaleField` holds the fields of one scale.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from cpm_core.contours.agreement import Comparison, compare
from cpm_core.contours.contour import Bridge, Contour
from cpm_core.contours.ground_truth import Truth, VolumeTruth
from cpm_core.contours.measurements import containment, measure
from cpm_core.contours.region_table import Table
from cpm_core.contours.result import Result
from cpm_core.contours.surface import Surface
from cpm_core.contours.surface_agreement import SurfaceComparison, compare_surface
from cpm_core.field.edge_map import edge_map
from cpm_core.field.electric_field import electric_field
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.formats import (
    encoded,
    export,
    load_centerlines,
    load_contours,
    load_image,
    load_pages,
    load_points,
    load_surface,
    load_volume,
)
from cpm_core.formats.animation import write_animation
from cpm_core.formats.common.provenance import VERSION
from cpm_core.formats.contours.figure import write_figure
from cpm_core.formats.ground_truth_file import load_truth, load_volume_truth
from cpm_core.formats.images.examples import example
from cpm_core.image.geometry import Geometry
from cpm_core.image.image import Image
from cpm_core.image.regions import Regions
from cpm_core.image.volume_regions import Extrusion, VolumeRegions
from cpm_core.medial_axis.centerlines import Centerlines, centerlines
from cpm_core.medial_axis.skeleton import Skeleton
from cpm_core.medial_axis.skeleton_method import skeleton
from cpm_core.model.coulomb import coulomb_force
from cpm_core.model.measures import Energies, Forces
from cpm_core.model.starts import circle, divergence_centers, gradient_threshold, stroke, uniform_grid
from cpm_core.model.state import Particles, State
from cpm_core.model.volume.starts import at_centers, box, everywhere, in_slice, on_strong_edges, sphere
from cpm_core.objects import (
    Partition,
    Selection,
    View,
    VolumePartition,
    VolumeSelection,
    objects_result,
    partition,
    select,
    select_all,
    view,
)
from cpm_core.objects.methods import (
    CONTOUR_METHODS,
    ContourMethod,
    ContourState,
    Facts,
    Start,
    facts_of,
    moments,
    run_method,
)
from cpm_core.pages.follow import follow
from cpm_core.pages.page import Page
from cpm_core.pages.tracks import TrackEvent
from cpm_core.parameters import PARAMETERS, PRESETS, Parameters
from cpm_core.reconstruction import reconstruct_curve, reconstruct_surface
from cpm_core.segmentation.engine import Engine
from cpm_core.segmentation.evolve import Evolution, Evolved, evolve, segment
from cpm_core.segmentation.method import METHODS as RUN_METHODS
from cpm_core.segmentation.method import Method

__version__ = VERSION

METHODS: Mapping[str, Any] = MappingProxyType({**CONTOUR_METHODS, **RUN_METHODS})
"""All methods by name: classes that run step by step, each a `Method`, and the others, to compare with them."""

__all__ = [
    "CONTOUR_METHODS",
    "METHODS",
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
    "Evolved",
    "Extrusion",
    "Facts",
    "Forces",
    "Geometry",
    "Image",
    "Method",
    "Page",
    "Parameters",
    "Particles",
    "Partition",
    "PlacedCharge",
    "Regions",
    "Result",
    "Selection",
    "Skeleton",
    "Start",
    "State",
    "Surface",
    "SurfaceComparison",
    "Table",
    "TrackEvent",
    "Truth",
    "View",
    "VolumePartition",
    "VolumeRegions",
    "VolumeSelection",
    "VolumeTruth",
    "at_centers",
    "box",
    "centerlines",
    "circle",
    "compare",
    "compare_surface",
    "containment",
    "coulomb_force",
    "divergence_centers",
    "edge_map",
    "electric_field",
    "encoded",
    "everywhere",
    "evolve",
    "example",
    "export",
    "facts_of",
    "follow",
    "gradient_threshold",
    "in_slice",
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
    "moments",
    "objects_result",
    "on_strong_edges",
    "partition",
    "reconstruct_curve",
    "reconstruct_surface",
    "run_method",
    "segment",
    "select",
    "select_all",
    "skeleton",
    "sphere",
    "stroke",
    "uniform_grid",
    "view",
    "write_animation",
    "write_figure",
]
