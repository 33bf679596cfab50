"""The skeleton of the objects in an image, or the center lines of those in a volume, in one call."""

from __future__ import annotations

from dataclasses import replace

from numpy.typing import ArrayLike

from cpm_core.image.image import Image, as_image
from cpm_core.medial_axis.skeleton import Skeleton
from cpm_core.medial_axis.skeleton_method import Within, plane_skeleton
from cpm_core.medial_axis.space.centerlines import Centerlines
from cpm_core.medial_axis.space.volume_skeleton import volume_skeleton
from cpm_core.parameters import PRESETS, Parameters
from cpm_core.parameters.quotation import shown

_POLARITIES = {"dark": -1.0, "light": 1.0, "auto": 0.0}


def skeleton(
    values: ArrayLike | Image,
    params: Parameters | None = None,
    *,
    of: str | None = None,
    max_width: float | None = None,
    pruning: float | None = None,
    within: Within | None = None,
    outside: bool = False,
) -> Skeleton | Centerlines:
    """Find the skeleton of the objects in a binary or gray image, or the center lines of those in a volume.

    They run midway between the edges, in a volume inside the surface through these, and are shortened from their tips.

    Parameters
    ----------
    values : array_like, shape (H, W) or (P, H, W), or Image
        Image, whose border is no edge: an object continues beyond it. Or volume; one of two gray levels is a mask.
    params : Parameters, optional
        For the edges, and what the following do not say; by default the preset "noisy", or "volume".
    of : {"dark", "light", "auto"}, optional
        What is darker, or lighter, than its surroundings on both sides; "auto" is what most of the image shares, or, if
        outlines are closed and nothing is shared, regions unlike the image border; in a volume what is lighter.
    max_width : float, optional
        Width above which a part has no skeleton [px]; what remains are strips between two edges, three widths long or
        more. At 0 any width counts if outlines are closed, else one that the strips themselves tell. Images only.
    pruning : float, optional
        How far a part of the shape may extend beyond the disks of the rest for its branch to be left out [px]. At one
        pixel neither the steps of a binary image nor moderate noise cause short branches (at 0.25 they do). In a
        volume the length of what is left out, in radii at its junction, by default 1; see `centerlines`.
    within : sequence of Contour, or array_like of bool, shape of the image, optional
        Closed outlines of objects and holes, or a mask: the skeleton is theirs, and `of` has no effect.
    outside : bool, optional
        Whether to include the skeleton of the background, whatever `of` is. Images only.

    Returns
    -------
    Skeleton or Centerlines
        Branches in `contours` with `radii`; without any branch if no edge encloses anything.

    Raises
    ------
    ValueError
        For an unusable image or value; the message says what to do.

    Examples
    --------
    >>> bones = cpm.skeleton(cpm.example("ring"))
    >>> len(bones.contours), bones.contours[0].closed, round(float(np.median(bones.radii[0])))
    (1, True, 7)
    """
    image = as_image(values)
    chosen = _chosen(params or PRESETS["noisy" if image.ndim == 2 else "volume"], of, max_width, pruning)
    if image.ndim == 2:
        return plane_skeleton(image, chosen, within=within, outside=outside)
    return volume_skeleton(image, chosen, within, outside=outside)


def _chosen(params: Parameters, of: str | None, max_width: float | None, pruning: float | None) -> Parameters:
    """Parameters with what is given in place of their values."""
    if of is not None and not (isinstance(of, str) and of in _POLARITIES):
        raise ValueError(f"of is {shown(of)} but must be one of {', '.join(_POLARITIES)}.")
    return replace(
        params,
        polarity=params.polarity if of is None else _POLARITIES[of],
        max_width=params.max_width if max_width is None else max_width,
        pruning=params.pruning if pruning is None else pruning,
    )
