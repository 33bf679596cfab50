"""A complete run in one call."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from numpy.typing import ArrayLike

from cpm_core.contours.hand_edits import HandEdit
from cpm_core.contours.result import Result
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.image.image import Image
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.model.image_fields import ImageFields
from cpm_core.model.state import State
from cpm_core.parameters import Parameters
from cpm_core.reconstruction.by_hand.operations import carried_out
from cpm_core.segmentation.evolve import evolve


def segment(
    values: ArrayLike | Image,
    seeds: ArrayLike,
    parameters: Parameters | None = None,
    max_steps: int | None = None,
    progress: Callable[[State], object] | None = None,
    regions: AnyRegions | None = None,
    charges: Sequence[PlacedCharge] = (),
) -> Result:
    """Find the contours of objects by particles that flow from seeds to edges and along them, until equilibrium.

    Parameters
    ----------
    values : array_like, shape (H, W), or Image
        Image.
    seeds : array_like, shape (N, 2)
        Where particles start (row, col) [px]: `circle`, `uniform_grid`, `gradient_threshold`, or any points.
    parameters : Parameters, optional
        The paper's defaults unless given.
    max_steps : int, optional
        Greatest number of steps.
    progress : callable, optional
        Called with every `State`.
    regions : Regions or VolumeRegions, optional
        Regions of interest, which particles stay in, and barriers, which they do not cross.
    charges : sequence of PlacedCharge
        Charges that attract or repel particles, in addition to the fixed charges of the edges.

    Returns
    -------
    Result
        Particles, contours through them, and the reason why the run ended.

    Raises
    ------
    ValueError
        For an unusable image, seeds or parameters; the message says what to do.

    Examples
    --------
    >>> result = cpm.segment(cpm.example("disk"), cpm.circle((32, 32), 8))
    >>> result
    <Result disk, 1 contour (1 closed), 82 particles, at rest after 101 steps>
    >>> round(result.contours[0].area), result.converged
    (1251, True)
    >>> cpm.segment(cpm.example("disk"), cpm.circle((32, 32), 8), cpm.Parameters(beta=0.6), max_steps=3).stop_reason
    'stopped after 3 steps, as asked'
    """
    run = evolve(values, seeds, parameters, max_steps, regions, charges)
    next(run)
    for moment in run:
        if progress is not None:
            progress(moment.state)
    return run.result


def with_hand_edits(
    result: Result, values: ArrayLike | Image, parameters: Parameters, edits: Sequence[HandEdit]
) -> Result:
    """The result of a run with edits of its contours by hand, such as those of a session.

    `values` is the image, shape (H, W), `parameters` those of the run. The pieces of edits whose contours are not there
    are contours of their own.
    """
    if not edits:
        return result
    return carried_out(result, edits, ImageFields(values, parameters).scale_field(parameters))[0]
