"""CPM: contours by charged particles.

The charged-particle model of Jalba, Wilkinson and Roerdink (2004): arrays in, arrays out, nothing of a window.

The model on one page
---------------------
1. The image is smoothed by a Gaussian of width sigma; the length of its gradient is the **edge map** f. Every pixel
   carries a **fixed charge** -f (`edge_map`). Automatic smoothing chooses sigma by the noise, and takes heavy noise out
   beforehand (`noise`); the edge of a dark or bright rim can be left out (`frame`).
2. The fixed charges make an **electric field**, E(r) = sum_k -f_k (r - R_k) / |r - R_k|^3, eq. (8), which pulls
   positive charges to edges (`electric_field`). Its direction is the **Lorentz force** F_l; on an edge it falls
   linearly through zero (`level`).
3. The **particles**, all of one positive charge, repel one another: the **Coulomb force** F_c, eq. (9)
   (`coulomb_force`), scaled by the local spacing and cut at one. Where a run has many of them, near pairs are summed at
   every step, and a mesh, made anew every few steps, carries what comes from afar (`far_force`).
4. They move by F = w1 F_c + w2 F_l - beta v, eq. (12), the last term being the **damping**; one **step** advances
   them by eq. (14)-(15) (`dynamics`, `motion`). Who leaves the image is removed.
5. **Insertion**: two neighbours at rest on an edge, d_min < d <= d_min + d_max apart, get a particle between them if
   the crest of the edge is free there, and a particle that sees its edge go on without anybody on it gets one ahead.
   **Deletion**: of two nearer than d_min / 2 one goes. **Annealing**: d_max is multiplied by a at every step
   (`insertion`, `deletion`, `contact`).
6. Where no new ground is gained, repulsion fades and friction grows, more slowly for those that are still under way far
   from all ground; who has come to rest where nothing is new sleeps, passed over until something is (`ground`,
   `motion`). A run is in **equilibrium** when eq. (23) holds and hardly anything has moved, appeared or vanished for
   twenty steps (`equilibrium`). Before a run ends, particles are launched beside boundaries that nobody has reached of
   whatever is enclosed and has been reached on another boundary: the outline around a hole, or a hole in an object
   (`enclosure`). Who is at rest on no edge then is removed.
7. All this happens on one **scale** after the other, from coarse to fine; each begins with what the coarser one found
   and with the **initialization**, the particles that were drawn (`multiscale`, `initialization`).
8. The **reconstruction** moves points to the crest of the edge, joins them by walking along the crest, leaves out what
   is weak or has the same on both sides (`contrast`), builds **bridges** across gaps when asked to, and walks along the
   edges to closed and open **contours** with **junctions** (`reconstruction`).
9. All of it happens inside the **regions of interest** and on this side of the **barriers**, if there are any
   (`regions`); at each scale they are the walls that no move, birth, contour or bridge crosses (`barrier_map`).
10. **Placed charges** attract or repel the particles around them, as strongly as the edges or up to four times so;
    their force is added to the Lorentz force (`charges`). They, the parameters, regions and barriers may be changed at
    any step, and particles added or erased (`steering`): what has come to rest and is concerned is set going again.
11. What a step adds up can be looked at: the **forces** on each particle, by name (`forces`), the **potential** of the
    charges, and the kinetic and potential **energy**, which the damping takes out of a run until it is at rest
    (`energies`).

`Engine` composes 1 to 7 and 9 to 11, step by step; `segment` is all of it in one call. What is known about each
contour, and which lies in which, is a row of `measure`'s table (`contour_table`). Where the **truth** is known, as a
mask or as contours, `compare` tells how well they agree with it and where they do not (`truth`, `comparison`). Files of
all of this are the business of `formats`: `export` writes contours by suffix, `encoded` makes the same without a file,
`load_contours` reads them back; `write_animation` and `strip` show a run that was drawn frame by frame.

Between the contours lies the **skeleton**: the middle line of an object with the distance to its boundary, from which
the object can be rebuilt (`skeleton`, `medial_axis`). It needs no start. Both ways are a `Method`, which is run step by
step without knowing which it is; `METHODS` has them by name.

Words
-----
Positions are (row, col) in pixels, pixel centres at integers. A *seated* particle sits on an edge. *Idle* counts steps
without new ground. A `State` is a moment of a run, from which the next follows without any other memory; a `Result` is
what a run has found; a `ScaleField` is what particles feel at one scale.
"""

from cpm_core.contours.agreement import Comparison, compare
from cpm_core.contours.contour import Bridge, Contour
from cpm_core.contours.ground_truth import Truth
from cpm_core.contours.measurements import containment, measure
from cpm_core.contours.result import Result
from cpm_core.dynamics.energies import Energies
from cpm_core.dynamics.forces import Forces
from cpm_core.field.edge_map import edge_map
from cpm_core.field.electric_field import electric_field
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.formats import encoded, export, load_contours, load_image
from cpm_core.formats.animations.animation import write_animation
from cpm_core.formats.animations.snapshot_strip import strip
from cpm_core.formats.ground_truth_file import load_truth
from cpm_core.image.image import Image
from cpm_core.image.regions import Regions
from cpm_core.medial_axis.skeleton import Skeleton, skeleton
from cpm_core.parameters import PARAMETERS, PRESETS, Parameters
from cpm_core.particles.coulomb.coulomb_force import coulomb_force
from cpm_core.particles.initialization import circle, divergence_centers, gradient_threshold, stroke, uniform_grid
from cpm_core.particles.state import Particles, State
from cpm_core.reconstruction import reconstruct_curve
from cpm_core.segmentation.engine import Engine
from cpm_core.segmentation.method import METHODS, Method
from cpm_core.segmentation.segment import segment

__all__ = [
    "METHODS",
    "PARAMETERS",
    "PRESETS",
    "Bridge",
    "Comparison",
    "Contour",
    "Energies",
    "Engine",
    "Forces",
    "Image",
    "Method",
    "Parameters",
    "Particles",
    "PlacedCharge",
    "Regions",
    "Result",
    "Skeleton",
    "State",
    "Truth",
    "circle",
    "compare",
    "containment",
    "coulomb_force",
    "divergence_centers",
    "edge_map",
    "electric_field",
    "encoded",
    "export",
    "gradient_threshold",
    "load_contours",
    "load_image",
    "load_truth",
    "measure",
    "reconstruct_curve",
    "segment",
    "skeleton",
    "strip",
    "stroke",
    "uniform_grid",
    "write_animation",
]
