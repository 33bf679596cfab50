"""The slices of a volume: the shown ones, the scene of each, and hits of the pointer."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import cast

import numpy as np

from cpm_app.model.display.channels import Channel
from cpm_app.model.display.differences import cut_differences, cut_truth
from cpm_app.model.display.display_image import DisplayImage, DisplayVolume, IntensityWindow, apply_window
from cpm_app.model.display.second_image import SecondImage
from cpm_app.model.document.document import Document
from cpm_app.model.document.edits import ShapeHit, find_shape_at
from cpm_app.model.volume.shape_sections import Section, cut_shape
from cpm_app.model.volume.slices import SampledForce, Slice, Slices
from cpm_app.model.volume.surface_section import cut_objects, cut_selection, cut_skeleton, select_near_clicks
from cpm_app.model.volume.surface_section import cut_surface as lines_of
from cpm_app.session.exchange.messages import Reconstruction, Snapshot
from cpm_app.session.features.background import AsyncCache, IdentityCache
from cpm_app.session.scene import NearParticles, Scene, ShownObjects
from cpm_app.session.session import Session
from cpm_app.session.worker.requests import ForcesProbed
from cpm_core import Image, Skeleton
from cpm_core.numerics import Array, Index, Place
from cpm_core.numerics.types import JsonObject, copy_with
from cpm_core.objects.segmented import SegmentedObjects
from cpm_core.shapes import ImageSeeds, ImageStart, Shape, relative_sides

MAX_SYNC_PIXELS = 1 << 21
"""Largest number of pixels of a slice that is made at once: three of these take a third of a frame of 50 ms."""

MAX_SYNC_FACES = 20_000
"""Largest number of faces of a surface that is cut at once: 200,000 take 25 ms in each of three views."""

SliceOverlay = DisplayImage | Array
"""Overlay of a slice: an image, or arrows of a field."""


class Sections:
    """Makes the scenes of one view; parts are made again only when what they depend on is another object.

    Parameters
    ----------
    axis : int, optional
        The axis across which the view shows its slices; by default the axis in use.
    later : AsyncCache, optional
        Makes slow parts on other threads; without it they are made at once, as needed for a film.
    """

    def __init__(self, axis: int | None = None, later: AsyncCache | None = None) -> None:
        self.axis = axis
        self.later = later
        self._parts = IdentityCache()
        self._shown: tuple[Slice, Reconstruction | None] | None = None

    def from_scene(self, scene: Scene) -> Scene:
        """Make the scene of a slice from the scene of a volume; any other scene is returned as it is."""
        volume, slices = scene.image, scene.slices
        if volume is None or slices is None or scene.volume is not None:
            return scene
        slices = slices if self.axis is None else slices.with_axis(self.axis)
        here, part, reach = slices.current, self._parts.get, scene.document.parameters.d_min
        image = part(_slice_image, volume, here)
        cut = part(cut_objects, scene.document.objects, here)
        document, places = part(_slice_document, scene.document, here, volume, cut)
        near = part(_find_near_particles, scene.snapshot, here, volume, reach)
        seeds = scene.image_seeds
        return Scene(
            image,
            self._display_slice("display", image, IntensityWindow(*volume.shown_range)),
            scene.shaded,
            document,
            places.get(scene.selected_shape),
            self._parts.get_named("seeds", lambda: _slice_seeds(seeds, here, volume, reach), seeds, here, reach),
            snapshot=part(_slice_snapshot, scene.snapshot, near, here),
            reconstruction=self._slice_lines(scene.reconstruction, here),
            overlays=self._slice_overlays(scene, here, image),
            probed=part(_slice_forces, scene.probed, here, volume, reach),
            truth=part(cut_truth, scene.truth, here),
            differences=part(cut_differences, scene.surface_differences, here),
            objects=part(_slice_objects, scene.objects, here),
            slices=slices,
            volume=volume,
            near_particles=near,
            second=part(_slice_second, scene.second, here),
            channels=tuple(self._slice_channel(*each, here) for each in enumerate(scene.channels)),
            whole=scene,
        )

    def _slice_lines(self, found: Reconstruction | None, here: Slice) -> Reconstruction | None:
        """Cut a result by a slice; a large surface is cut later, and its last cut is shown meanwhile."""
        before, surface = self._shown, found.result.surface if found else None
        small = surface is None or len(surface.faces) <= MAX_SYNC_FACES
        if self.later is None or small or before is None or before[0] != here:
            lines = self._parts.get(_slice_result, found, here)
        else:
            lines = self.later.get_named("lines", partial(_slice_result, found, here), lambda: before[1], found, here)
        self._shown = here, lines
        return lines

    def _slice_channel(self, index: int, channel: Channel, here: Slice) -> Channel:
        volume = channel.image
        if volume is None:
            return channel
        name, cut = f"channel {index}", self._parts.get_named
        image = cut(("image", index), lambda: _slice_image(volume, here), volume, here)
        display = self._display_slice(name, image, IntensityWindow(*volume.shown_range))
        return cut(("cut", index), lambda: replace(channel, image=image, display=display), channel, image, display)

    def _display_slice(self, name: str, image: Image, window: IntensityWindow) -> DisplayImage:
        """Display a slice in the intensity window of the volume, so that brightness is the same in all slices."""

        def make_display() -> DisplayImage:
            return DisplayImage.from_shades(apply_window(image.values, window))

        if image.values.size > MAX_SYNC_PIXELS and self.later is not None:
            return self.later.get_named(
                name, make_display, lambda: DisplayImage.from_subsample(image.values, window), image
            )
        return self._parts.get_named(name, make_display, image)

    def _slice_overlays(self, scene: Scene, here: Slice, image: Image) -> Mapping[str, SliceOverlay]:
        """Cut the overlays by a slice."""
        found: dict[str, SliceOverlay] = {}
        for name, drawn in scene.overlays.items():
            if isinstance(drawn, DisplayVolume):
                found[name] = self._parts.get_named(
                    name, partial(DisplayImage.from_shades, here.slice_array(drawn.shades)), drawn, here
                )
            elif isinstance(drawn, SampledForce):
                found[name] = self._parts.get_named(
                    name, partial(drawn.interpolate_slice, here, image.shape), drawn, here
                )
        return self._parts.get_named("overlays", lambda: found, *found, *found.values())


def _slice_image(volume: Image, here: Slice) -> Image:
    image = volume.slice_across(here.axis, here.index)
    return copy_with(image, stored=image.stored.T, spacing=image.spacing[::-1]) if here.transposed else image


def _slice_second(second: SecondImage | None, here: Slice) -> SecondImage | None:
    return None if second is None else replace(second, shades=here.slice_array(second.shades))


def _slice_seeds(seeds: ImageSeeds, here: Slice, volume: Image, reach: float) -> ImageSeeds:
    """Return the seeds near the slice of the starts all over the volume."""
    sides = relative_sides(volume.spacing)
    return {
        cut: here.project_points(at[_select_near_slice(at, here, volume, reach)[0]])
        for start, at in seeds.items()
        for cut in cut_shape(start, here, sides)
        if isinstance(cut, ImageStart)
    }


def _slice_forces(probed: ForcesProbed | None, here: Slice, volume: Image, reach: float) -> ForcesProbed | None:
    """Return the components along the slice of the forces on a particle, if the particle is near it."""
    if probed is None or len(probed.position) != len(volume.shape):
        return probed
    if not len(_select_near_slice(np.array([probed.position]), here, volume, reach)[0]):
        return replace(probed, identity=-1)
    sides = np.array(here.drop_axis(relative_sides(volume.spacing)))
    along = {name: here.project_points(force[None])[0] / sides for name, force in probed.forces.items()}
    return replace(probed, position=here.drop_axis(probed.position), forces=along)


def iterate_sections(shapes: Iterable[Shape], here: Slice, volume: Image) -> Iterator[tuple[int, Section]]:
    """Iterate over the sections of shapes by a slice, each with the index of its shape."""
    sides = relative_sides(volume.spacing)
    for index, shape in enumerate(shapes):
        for cut in cut_shape(shape, here, sides):
            yield index, cut


def _slice_document(
    document: Document, here: Slice, volume: Image, objects: SegmentedObjects
) -> tuple[Document, dict[int | None, int]]:
    """Return the document with sections of its shapes, and the index of the first section of each shape."""
    places: dict[int | None, int] = {}
    shapes: list[Section] = []
    for index, cut in iterate_sections(document.shapes, here, volume):
        places.setdefault(index, len(shapes))
        shapes.append(cut)
    # layers draw sections as they draw the shapes of an image
    return replace(document, shapes=cast("tuple[Shape, ...]", tuple(shapes)), objects=objects), places


def _slice_objects(shown: ShownObjects, here: Slice) -> ShownObjects:
    """Cut the proposals, the preview and the awaited clicks by a slice."""
    offered = tuple(replace(each, selection=cut_selection(each.selection, here)) for each in shown.proposals)
    preview = shown.preview
    if preview is not None:
        before = None if preview.before is None else cut_selection(preview.before, here)
        preview = replace(preview, after=cut_selection(preview.after, here), before=before)
    awaited = select_near_clicks(shown.awaited, here)
    return replace(shown, proposals=offered, preview=preview, awaited=awaited)


def _find_near_particles(snapshot: Snapshot | None, here: Slice, volume: Image, reach: float) -> NearParticles | None:
    """Find the particles within `reach` of the slice, in sides of the smallest voxel."""
    if snapshot is None:
        return None
    return NearParticles(*_select_near_slice(snapshot.position, here, volume, reach))


def _select_near_slice(position: Array, here: Slice, volume: Image, reach: float) -> tuple[Index, Array]:
    """Find positions, shape (N, 3), near a slice: their indices, shape (M,), and distances in units of `reach`."""
    side = relative_sides(volume.spacing)[here.axis]
    away = np.abs(position[:, here.axis] - here.index) * (side / reach)
    index = np.flatnonzero(away < 1.0)
    return index, away[index]


def _slice_snapshot(snapshot: Snapshot | None, near: NearParticles | None, here: Slice) -> Snapshot | None:
    if snapshot is None or near is None:
        return None
    position = here.project_points(snapshot.position[near.index])
    return replace(snapshot, position=position, resting=snapshot.resting[near.index])


def _slice_result(reconstruction: Reconstruction | None, here: Slice) -> Reconstruction | None:
    """Return the center lines in the slice, or else the lines in which it cuts the surface."""
    if reconstruction is None:
        return None
    found = reconstruction.result
    if isinstance(found, Skeleton):
        return replace(reconstruction, result=cut_skeleton(found, here))
    lines = () if found.surface is None else tuple(lines_of(found.surface, here))
    return replace(reconstruction, result=replace(found, contours=lines, surface=None))


def hit_shape(scene: Scene, place: Place, tolerance: float, here: Slice | None) -> ShapeHit | None:
    """Find the shape of a scene under a place; in a volume only sections in a slice can be hit.

    None stands for the slice in use.
    """
    shapes, selected = scene.document.shapes, scene.selected_shape
    if scene.slices is None or scene.full_image is None:
        return find_shape_at(shapes, place, tolerance, selected)
    here = scene.slices.current if here is None else here
    seen = list(iterate_sections(shapes, here, scene.full_image))
    candidates: list[int | None] = [number for number, (index, _) in enumerate(seen) if index == selected]
    cuts = cast("tuple[Shape, ...]", tuple(section for _, section in seen))
    found = None
    for number in candidates or [None]:  # a shape may have several sections, each with handles
        found = find_shape_at(cuts, here.drop_axis(place), tolerance, number)
        if found is not None and found.part == "handle":
            break
    if found is None:
        return None
    at = None if found.handle is None else here.lift_position(found.handle)
    return replace(found, index=seen[found.index][0], handle=at)


_MAX_FILE_INDEX = 10**6
"""Largest index that is accepted from a file [voxels]."""


class SliceNavigation:
    """Navigates the slices of the open volume; without a volume there are none, and nothing happens."""

    def __init__(self, session: Session) -> None:
        self._session = session

    @property
    def current(self) -> Slices | None:
        """The shown slices; None while no volume is open."""
        return self._session.scene.slices

    def go_by(self, by: int) -> None:
        """Show the slice `by` slices further along its axis."""
        self._change_slices(lambda now: now.with_index(now.current.index + by))

    def go_to(self, index: int) -> None:
        """Show the slice at an index along its axis."""
        self._change_slices(lambda now: now.with_index(index))

    def step_along(self, axis: int, by: int) -> None:
        """Show the slice `by` slices further along an axis, even if another one is in use."""
        self._change_slices(lambda now: now.with_axis(axis).with_index(now.voxel[axis] + by).with_axis(now.axis))

    def set_axis(self, axis: int) -> None:
        """Use the slice across another axis."""
        self._change_slices(lambda now: now.with_axis(axis))

    def go_through(self, place: Place) -> None:
        """Show the slices through a place of the volume."""
        self._change_slices(lambda now: now.with_voxel(place))

    def view_state(self) -> dict[str, object]:
        """Return the positions of the slices as plain JSON for a session file; empty for an image."""
        now = self.current
        return {} if now is None else {"slices": {"voxel": list(now.voxel), "axis": now.axis}}

    def use_view_state(self, state: JsonObject) -> None:
        """Restore the slices from a session file; missing or invalid entries change nothing."""
        kept = state.get("slices")
        if self.current is None or not isinstance(kept, Mapping):
            return
        axis, voxel = kept.get("axis"), kept.get("voxel")
        if axis in (0, 1, 2) and not isinstance(axis, bool):
            self.set_axis(int(axis))
        known = voxel if isinstance(voxel, list) and len(voxel) == len(self.current.voxel) else []
        if known and all(isinstance(at, int) and abs(at) <= _MAX_FILE_INDEX for at in known):
            self.go_through(tuple(known))

    def _change_slices(self, change: Callable[[Slices], Slices]) -> None:
        if self.current is not None and (slices := change(self.current)) != self.current:
            self._session.store.set_scene(replace(self._session.scene, slices=slices))
