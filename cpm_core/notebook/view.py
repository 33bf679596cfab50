"""An image in a notebook in which clicks select objects, by anywidget where that is installed."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import PIL.Image
from numpy.typing import ArrayLike

from cpm_core.contours.contour import Contour
from cpm_core.contours.surface import slice_surface
from cpm_core.image import drawing
from cpm_core.image.image import Image, as_image
from cpm_core.numerics.packages import has_package
from cpm_core.numerics.types import JsonDict
from cpm_core.objects.partition import Partition, partition_without_run
from cpm_core.objects.selection import Selection
from cpm_core.objects.volume_partition import VolumePartition
from cpm_core.parameters.formatting import format_count, format_repr
from cpm_core.results.result import Result
from cpm_core.segmentation.select import partition

_MAX_PICTURE_SIDE = 2048
"""Longer side of the picture that is sent to a notebook [px]."""

_SELECTED_OBJECT_COLOR = "#f5793a"
"""Color of the selected object."""

_HELP_TEXT = "Click an object; Shift-click corrects it, Backspace removes it; Ctrl and the wheel zoom, a drag moves."


def notebook_view(values: ArrayLike | Image | Result, result: Result | None = None, *, model: str = "") -> NotebookView:
    """Show an image with what a run found, or the slices of a volume, and select objects in it by clicks.

    Parameters
    ----------
    values : array_like, or Image, or Result
        An image of shape (H, W), a volume of shape (P, H, W), or what was found in one.
    result : Result, optional
        What was found in the image, if `values` is the image itself.
    model : str, optional
        The larger model that answers clicks in place of the network, as for `partition`.

    Returns
    -------
    View
        In a notebook, an image to click where anywidget is installed, else a picture.

    Raises
    ------
    ValueError
        For an unusable image, or a result that does not know its image.

    Examples
    --------
    >>> cpm.notebook_view(cpm.example("disks"))
    <NotebookView disks, 0 objects>
    """
    found = values if result is None else replace(result, image=as_image(values))  # type: ignore[arg-type]
    if isinstance(found, Result):
        return NotebookView(partition(found, model=model), found)
    return NotebookView(partition_without_run(as_image(found), model=model))


class NotebookView(drawing.Pictured):
    """An image, or a slice of a volume, in which clicks select objects.

    In a notebook, a click on an object adds it and selects it; Shift-click adds to the selected object or removes from
    it, and Backspace removes the object. The same can be done in Python.

    Parameters
    ----------
    partition : Partition or VolumePartition
        What objects are selected from.
    result : Result, optional
        Its contours, or its surface, are shown, and its objects are the first ones.

    Attributes
    ----------
    partition : Partition or VolumePartition
        What objects are selected from.
    objects : list of Selection
        Those that the run proposes, and those clicked so far, the last click last.
    selection : Selection or None
        The object that was clicked last, which can be corrected.
    plane : int or None
        The plane of a volume that is shown; None for an image.

    Examples
    --------
    >>> view = cpm.notebook_view(cpm.example("disks"))
    >>> view.click((32, 18))
    >>> view.click((32, 46))
    >>> len(view.objects), view.selection is view.objects[1], bool(view.objects[0].mask[32, 18]), view.plane
    (2, True, True, None)
    >>> view.click((30, 46), correct=True)  # takes away what lies there
    >>> bool(view.selection.mask[30, 46])
    False
    >>> view.remove()
    >>> view.selection, int(cpm.objects_result(view.objects).labels.max())
    (None, 1)
    >>> axes = view.plot()
    >>> cpm.notebook_view(cpm.segment(cpm.example("disks"), cpm.uniform_grid((64, 64))))
    <NotebookView disks, 2 objects>
    >>> slices = cpm.notebook_view(cpm.example("ball"))
    >>> slices.show_plane(12)
    >>> slices.plane
    12
    """

    def __init__(self, partition: Partition | VolumePartition, result: Result | None = None) -> None:
        self.partition = partition
        self.objects: list[Selection] = [] if result is None else list(result.objects)
        self.selection: Selection | None = None
        self.plane = partition.shape[0] // 2 if len(partition.shape) == 3 else None
        self._results, self._message = [result] if result is not None else [], _HELP_TEXT
        self._limits = drawing.gray_limits(self._image.values)

    def click(self, place: Sequence[float], correct: bool = False) -> None:
        """Select the object at a place (row, col) or (plane, row, col), or `correct` the selected one there."""
        partition: Any = self.partition  # each kind corrects selections of its own kind
        at, former = np.array([place], dtype=float), self.selection
        found: Selection
        if correct and former is not None:
            places = [former.inside, former.outside]
            side = int(former.contains(at)[0])
            places[side] = np.concatenate([places[side], at])
            found = partition.select(*places, previous=former)
        else:
            former = next((one for one in self.objects if one.contains(at)[0]), None)
            found = partition.select(at) if former is None else former
        self._message = found.remark
        if found.has_boundary and not found.has_only_points:
            self.objects = [*(one for one in self.objects if one is not former), found]
            self.selection = found
            self._message = f"{repr(found).strip('<>')}. {found.remark}".strip()
        self._send_state()

    def remove(self) -> None:
        """Remove the selected object."""
        self.objects = [one for one in self.objects if one is not self.selection]
        self.selection, self._message = None, _HELP_TEXT
        self._send_state()

    def show_plane(self, plane: int) -> None:
        """Show a plane of a volume."""
        self.plane = plane
        self._send_state(ground=True)

    def plot(self, ax: drawing.Axes | None = None) -> drawing.Axes:
        """Draw the image, or the slice, with contours and objects by matplotlib."""
        ax = self._image.plot(ax, scale_bar=False)
        drawing.show_curves(ax, self._find_contours(self._results))
        drawing.show_curves(
            ax, [replace(line, color=_SELECTED_OBJECT_COLOR) for line in self._find_contours(self.objects)]
        )
        return ax

    @property
    def _image(self) -> Image:
        image = self.partition.image
        return image if self.plane is None else image.slice_across(0, self.plane)

    def _find_contours(self, found: Sequence[Result | Selection]) -> list[Contour]:
        """Find the contours of results or objects, or where the plane cuts their surfaces."""
        lines: list[Contour] = []
        for one in found:
            lines += one.contours
            if self.plane is not None and one.surface is not None:
                lines += slice_surface(one.surface, 0, self.plane)
        return lines

    def __repr__(self) -> str:
        return format_repr("NotebookView", self.partition.image.source, format_count(len(self.objects), "object"))

    def _repr_mimebundle_(self, **options: Any) -> Any:
        return self._widget._repr_mimebundle_(**options) if has_package("anywidget") else {}

    @cached_property
    def _widget(self) -> Any:
        from anywidget import AnyWidget
        from traitlets import Dict

        class Widget(AnyWidget):  # type: ignore[misc]
            _esm = Path(__file__).with_name("view.js").read_text(encoding="utf-8")
            ground = Dict(self._encode_picture()).tag(sync=True)
            chosen = Dict(self._describe_objects()).tag(sync=True)

        made = Widget()
        asked: dict[str, Callable[..., None]] = {"click": self.click, "remove": self.remove, "turn_to": self.show_plane}
        made.on_msg(lambda _, message, buffers: asked[message["do"]](*message["given"]))
        return made

    def _send_state(self, *, ground: bool = False) -> None:
        if "_widget" in vars(self):
            self._widget.chosen = self._describe_objects()
            self._widget.ground = self._encode_picture() if ground else self._widget.ground

    def _describe_objects(self) -> JsonDict:
        """Describe the objects, with a message on the last one."""
        objects = [
            (one is self.selection, "".join(map(_format_svg_path, self._find_contours([one])))) for one in self.objects
        ]
        return {"objects": objects, "said": self._message}

    def _encode_picture(self) -> JsonDict:
        """Encode the picture of the image, and its contours."""
        image, stream = self._image, io.BytesIO()
        black, white = self._limits
        gray = (np.clip((image.values - black) / (white - black), 0.0, 1.0) * 255.0).astype(np.uint8)
        picture = PIL.Image.fromarray(gray if image.colors is None else image.colors.samples)
        picture.reduce(-(-max(image.shape) // _MAX_PICTURE_SIDE)).save(stream, "png")
        return {
            "picture": stream.getvalue(),
            "lines": [
                (drawing.curve_color(line), _format_svg_path(line)) for line in self._find_contours(self._results)
            ],
            "shape": image.shape,
            "aspect": image.spacing[0] / image.spacing[1],
            "planes": 0 if self.plane is None else self.partition.shape[0],
            "plane": self.plane,
        }


def _format_svg_path(line: Contour) -> str:
    """Format a contour as a path of SVG, x being the column."""
    return "M" + "L".join(f"{col:.2f},{row:.2f}" for row, col in line.points.tolist()) + "Z" * line.closed
