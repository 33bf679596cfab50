"""Figures of objects, measured on another thread."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

from PySide6.QtCore import QObject, Signal

from cpm_app.model.text.language import tr
from cpm_app.session.features.background import LatestOnlyWorker
from cpm_app.session.session import Session
from cpm_core import Image, Surface
from cpm_core.numerics.grids import window_at
from cpm_core.objects.segmented import SegmentedObject


@dataclass(frozen=True)
class ObjectFigures:
    """Figures of an object.

    Attributes
    ----------
    gray : float
        Mean gray value; NaN if it has no pixel.
    volume, area : float
        Volume of the voxels of an object in a volume, and area of its surface, in the unit of the image; 0 in an image,
        as are the rest.
    parts, euler : int
        Number of connected parts of its surface, and its Euler characteristic.
    body : Surface or None
        Its surface in a volume [voxels].
    """

    gray: float
    volume: float = 0.0
    area: float = 0.0
    parts: int = 0
    euler: int = 0
    body: Surface | None = None


class ObjectMeasurer(QObject):
    """Measures objects on another thread, because large ones have many pixels."""

    measured = Signal()
    """Objects have been measured."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self.figures: dict[int, tuple[Image, object, ObjectFigures]] = {}
        """Figures in an image by the identity of the boundary, which is the same once a proposal becomes an object."""
        self.bodies: Mapping[int, Surface] = {}
        """The surfaces of the objects of a volume by number, as last measured."""
        self._latest = LatestOnlyWorker(session, "cpm-object-measures", tr("measuring objects"))
        session.image_changed.connect(self._on_image_changed)

    def figures_of(self, item: SegmentedObject) -> ObjectFigures | None:
        """Return the figures of an object; None while unknown for its boundary in the present image."""
        image, _, figures = self.figures.get(id(_region_or_line(item)), (None, None, None))
        return figures if image is self._session.image else None

    def measure_objects(self, items: Collection[SegmentedObject]) -> None:
        """Measure those of the objects that have no figures, and then forget the figures of all others."""
        image = self._session.image
        missing = [item for item in items if self.figures_of(item) is None]
        if image is None or not missing:
            return
        there = {id(_region_or_line(item)) for item in items}

        def keep_figures(measured: list[tuple[SegmentedObject, ObjectFigures]]) -> None:
            self.figures = {key: kept for key, kept in self.figures.items() if key in there}
            for item, figures in measured:
                self.figures[id(_region_or_line(item))] = image, _region_or_line(item), figures
            bodies = {item.number: figures.body for item, figures in measured if figures.body is not None}
            self.bodies = {**self.bodies, **bodies}
            self.measured.emit()

        self._latest.submit(lambda: [(item, _measure_object(item, image)) for item in missing], keep_figures)

    def _on_image_changed(self) -> None:
        """Remove the figures, because another image has been opened."""
        self.figures, self.bodies = {}, {}


def _region_or_line(item: SegmentedObject) -> object:
    return item.line or item.region


def _measure_object(item: SegmentedObject, image: Image) -> ObjectFigures:
    first, mask = item.region.cut_to((0,) * image.ndim, image.shape)
    values = image.stored[window_at(first, mask.shape)][mask]
    gray = float(values.mean(dtype=float)) if len(values) else math.nan
    if image.ndim == 2:
        return ObjectFigures(gray)
    body = item.region.find_surface()
    # cached here, because limits and painting need it on the window's thread, which must not wait
    _ = item.region.shell
    surface = replace(body, spacing=image.spacing, unit=image.unit)
    volume = len(values) * math.prod(image.spacing)  # as in tables and masks
    return ObjectFigures(gray, volume, surface.area, surface.components, surface.euler, body)
