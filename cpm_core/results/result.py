"""The result of a run: particles, contours, and how it ended."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cpm_core.contours.contour import Bridge, Contour
from cpm_core.contours.faces import Face, find_faces
from cpm_core.contours.measurements import assign_labels, compute_centroid
from cpm_core.contours.rasterize import rasterize_labels
from cpm_core.contours.region_table import Table, measure_regions, measure_volume_objects
from cpm_core.contours.surface import label_voxels
from cpm_core.image import drawing
from cpm_core.image.geometry import Geometry
from cpm_core.image.image import Image
from cpm_core.image.surface import Surface
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.model.state import State
from cpm_core.numerics.types import NO_POINTS, Array, Arrays, Extent, Sides, record
from cpm_core.parameters import Parameters
from cpm_core.parameters.formatting import format_count, format_repr
from cpm_core.parameters.provenance import Provenance
from cpm_core.results.found_objects import FoundObjects, find_objects

_MAX_DRAWN_LABELS = 400
"""Largest number of labels written into a picture."""


@record
class Result(drawing.Pictured):
    """Outcome of a run.

    Attributes
    ----------
    particles : ndarray of float64, shape (N, D)
        Final positions in px of the image.
    contours : tuple of Contour
        The reconstructed contours, longest first.
    surface : Surface or None
        The reconstructed surface of objects in a volume; None for images.
    steps : int
        Number of steps over all scales.
    converged : bool
        Whether the particles came to rest.
    stop_reason : str
        Why the run ended, in words.
    shape : tuple of int
        Shape of the image.
    spacing : tuple of float
        Size of a pixel along each axis, in `unit`.
    unit : str or None
        Unit of `spacing`; None when the image gives none.
    source : str
        Name of the image for the user.
    bridges : tuple of Bridge
        Gaps that were bridged in the contours.
    links : tuple of ndarray, each of shape (K, 2)
        Pieces between two contours that are too short to be contours, but separate `faces` [px].
    image : Image or None
        The image in which the contours were found; None for contours that were not found in one.
    regions : Regions or VolumeRegions or None
        Regions of interest and barriers of the run.
    channel : str
        Channel of a color image in which the contours were found, one of `Parameters.channel`.
    seeds : ndarray, shape (M, D)
        Where the run began [px]; empty where nothing ran.
    provenance : Provenance
        Origin of the contours.

    Examples
    --------
    >>> result = cpm.segment(cpm.example("ring"), cpm.uniform_grid((64, 64)))
    >>> result
    <Result ring, 2 contours (2 closed), 133 particles, at rest after 68 steps>
    >>> result.labels.shape, int(result.labels[32, 12]), int(result.labels[32, 32])  # the ring, and the hole in it
    ((64, 64), 1, 2)
    >>> table = result.table(in_units=True)
    >>> table["area"].round(), table.units["area"]
    (array([374.,  77.]), 'µm²')
    >>> result.objects  # the best first
    (<Selection 1,485 px, 2 contours, 0 gaps, 96 % sure>,)
    >>> axes = result.plot(particles=True)
    >>> result.geometry is None  # nothing is known of its place in space
    True
    """

    particles: Array
    contours: tuple[Contour, ...]
    surface: Surface | None
    steps: int
    converged: bool
    stop_reason: str
    shape: Extent
    spacing: Sides
    unit: str | None
    source: str
    bridges: tuple[Bridge, ...] = ()
    links: Arrays = ()
    image: Image | None = None
    regions: AnyRegions | None = None
    channel: str = "luminance"
    seeds: Array = field(default_factory=lambda: NO_POINTS)
    provenance: Provenance = field(default_factory=Provenance)

    @cached_property
    def labels(self) -> NDArray[np.int32]:
        """Label of each pixel or voxel, an array in the shape of the image, read-only; 0 outside.

        Every closed contour fills its inside with its own label: the number of its object, or else counted from 1 in
        the order of `contours`. One inside another has its own, so that the hole of a ring differs from the ring. The
        holes of selected objects have the label 0. Open contours have none; see `faces`. In a volume each object inside
        a closed surface has a label, the largest 1; without such a surface all are 0. Files of labels hold the same
        array.
        """
        found = np.zeros(self.shape, np.int32)
        if self.surface is not None and self.surface.closed:
            found[:] = label_voxels(self.surface, self.shape)
        elif len(self.shape) == 2:
            found[:] = rasterize_labels(self.contours, self.shape)
        found.flags.writeable = False
        return found

    @cached_property
    def faces(self) -> tuple[Face, ...]:
        """What the contours enclose, alone or several that meet, the largest first; nothing in a volume.

        The faces of the net of contours: a closed contour is one, less what is in it, and so is each of the regions
        that meet at a T or an X, though no contour is closed there. A piece with a loose end inside leaves a face
        whole, and what the border of the image cuts is no face.

        Examples
        --------
        >>> rows, cols = np.mgrid[:64, :64]
        >>> inside = (abs(rows - 31.5) < 20) & (abs(cols - 31.5) < 20)
        >>> quarters = np.where(inside, 60 * (rows // 32) + 120 * (cols // 32), -60)
        >>> result = cpm.segment(cpm.Image(quarters), cpm.uniform_grid((64, 64)))
        >>> sum(contour.closed for contour in result.contours), [round(face.area, -1) for face in result.faces]
        (0, [400.0, 400.0, 400.0, 400.0])
        """
        return find_faces(self.contours, self.spacing, self.links) if len(self.shape) == 2 else ()

    @cached_property
    def objects(self) -> FoundObjects:
        """The objects that the run proposes, the best first.

        A run from everywhere, as from a grid, proposes all objects of the image, or all bodies inside the surface. One
        from drawn starts proposes the object of each of them. They are found at the first access, which takes some
        seconds in a large image. ValueError when the image is not known.
        """
        return find_objects(self)

    def table(self, *, in_units: bool = False) -> Table:
        """Measure what the closed contours enclose, or the objects in a volume: one row a label of `labels`.

        Parameters
        ----------
        in_units : bool
            Whether lengths are in `unit` rather than in px; in a volume, in voxels.

        Returns
        -------
        Table
            Columns by name, named as in ``skimage.measure.regionprops`` where they mean the same: ``area``
            without contours inside, ``area_filled`` with them, ``area_convex``, ``perimeter`` including holes,
            ``centroid-0`` (row) and ``centroid-1``, ``bbox-0`` to ``bbox-3`` (least row and column, largest row and
            column, of the contour), ``axis_major_length``, ``axis_minor_length``, ``eccentricity``, ``orientation``,
            ``equivalent_diameter_area``, ``solidity``, ``circularity`` (4π area_filled over the square of the outer
            perimeter), and of the gray levels inside ``intensity_mean``, ``intensity_std``, ``intensity_min`` and
            ``intensity_max``. Of a volume: ``volume`` of the voxels (that
            within the surface is `Surface.volume`), ``equivalent_diameter``, ``centroid``, ``bbox`` and gray levels.
        """
        sides, unit = (self.spacing, self.unit) if in_units else ((1.0,) * len(self.shape), None)
        gray = None if self.image is None else self.image.gray_levels(self.channel)
        if len(self.shape) == 3:
            return measure_volume_objects(self.labels, gray, sides, unit)
        return measure_regions(self.contours, self.labels, gray, sides, unit)

    def plot(
        self,
        ax: drawing.Axes | None = None,
        *,
        image: bool = True,
        contours: bool = True,
        particles: bool = False,
        labels: bool = False,
        scale_bar: bool = True,
    ) -> drawing.Axes:
        """Draw by matplotlib: the image with the contours; of a volume the surface.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where; by default in a new figure. For a surface, axes with ``projection="3d"``.
        image, contours, particles, labels, scale_bar : bool
            Parts of the drawing: the image itself, contours, particles, the name or label of each closed contour,
            and a scale bar, in px where the size of a pixel is not known.

        Returns
        -------
        matplotlib.axes.Axes
            The axes, in px of the image.

        Raises
        ------
        ValueError
            When `ax` are no axes of matplotlib.
        """
        if self.surface is not None:
            return self.surface.plot(ax)
        ax = drawing.axes_for(ax)
        if image and self.image is not None:
            self.image.plot(ax, scale_bar=False)
        else:
            drawing.frame_axes(ax, self.shape, self.spacing)
        if contours:
            drawing.show_curves(ax, self.contours)
        if particles and len(self.particles):
            drawing.show_particles(ax, self.particles)
        if labels:
            labeled = zip(self.contours, assign_labels(self.contours), strict=True)
            for contour, label in [one for one in labeled if one[1]][:_MAX_DRAWN_LABELS]:
                row, col = compute_centroid(contour)
                name = contour.name or str(label)
                ax.text(
                    col,
                    row,
                    name,
                    color="#ffffff",
                    ha="center",
                    va="center",
                    size=8,
                    bbox=drawing.TEXT_BOX_STYLE,
                    zorder=7,
                )
        if scale_bar:
            drawing.show_scale_bar(ax, self.shape, self.spacing, self.unit)
        return ax

    def __repr__(self) -> str:
        closed = sum(contour.closed for contour in self.contours)
        found = format_count(len(self.contours), "contour") + (f" ({closed} closed)" if closed else "")
        if self.surface is not None:
            found = f"a surface of {format_count(len(self.surface.faces), 'triangle')}"
        return format_repr(
            "Result",
            self.source,
            found,
            format_count(len(self.particles), "particle") if len(self.particles) else "",
            f"{self.stop_reason.partition(':')[0]} after {format_count(self.steps, 'step')}"
            if self.steps
            else self.stop_reason,
        )

    @property
    def geometry(self) -> Geometry | None:
        """Position of its image in space; None where it is not known."""
        return None if self.image is None else self.image.geometry


def build_result(state: State, image: Image, parameters: Parameters, **found: Any) -> Result:
    """Build the result of a run at a state, with the contours and bridges, or the surface, that were found."""
    return Result(
        particles=state.position,
        steps=state.step,
        converged=state.converged,
        stop_reason=state.stop_reason,
        shape=image.shape,
        spacing=image.spacing,
        unit=image.unit,
        source=image.source,
        image=image,
        regions=state.regions,
        channel=image.resolve_channel(parameters.channel),
        seeds=state.start,
        **found,
    )


def describe_origin(method: str, image: Image, state: State, parameters: Mapping[str, float | str]) -> Provenance:
    """Describe how the contours of a state of a run were found, with the values of the method's parameters."""
    return Provenance(
        method,
        parameters,
        len(state.start),
        tuple({"shape": "charge", **asdict(charge)} for charge in state.charges),
        state.scale,
        sha256=image.sha256,
        of_file=bool(image.file_sha256),
    )
