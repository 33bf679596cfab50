"""The scene: everything that the canvas shows, one frozen value that the session replaces as a whole.

A view keeps the scene that it has drawn last and redraws only the parts that are not the same objects in the next one.
Another canvas, such as an animation, draws another scene: ``dataclasses.replace(session.scene, snapshot=...)``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field, replace
from functools import cached_property

from cpm_app.model.display.channels import Channel
from cpm_app.model.display.differences import Difference, SurfaceDifference
from cpm_app.model.display.display_image import DisplayImage
from cpm_app.model.display.second_image import SecondImage
from cpm_app.model.document.document import Document
from cpm_app.model.document.objects import object_from_selection
from cpm_app.model.volume.slices import Slices
from cpm_app.session.exchange.messages import OverlayData, Reconstruction, Snapshot
from cpm_app.session.timeline.timeline import EMPTY_TIMELINE, TimelineState
from cpm_app.session.worker.requests import ForcesProbed, ImageShaded
from cpm_core import Image, Result, Selection, Skeleton, Truth, VolumeTruth
from cpm_core.contours.contour import Contours
from cpm_core.numerics import Array, Index
from cpm_core.numerics.types import record
from cpm_core.objects.segmented import SegmentedObject
from cpm_core.objects.segmented.segmented_object import Clicks
from cpm_core.shapes import NO_SEEDS, ImageSeeds


@record
class Proposal:
    """An object that is offered to the user.

    Attributes
    ----------
    selection : Selection
        The object.
    clicks : tuple of Click
        The clicks that selected it.
    number : int
        Number of the object that it would replace; 0 for a new one.
    key : int
        Key for selecting it, below 0, constant while it is offered; 0 for the object of the clicks.
    followed_object : SegmentedObject or None
        The object that it was followed from page to page as, whose name, class and color it gets.
    category : int
        The class of the object that it is like; 0 for another one.
    """

    selection: Selection
    clicks: Clicks
    number: int = 0
    key: int = 0
    followed_object: SegmentedObject | None = None
    category: int = 0

    @cached_property
    def proposed_object(self) -> SegmentedObject:
        """The object that accepting it would create, of the first class unless it was followed; needs a boundary."""
        made, known = object_from_selection(self.selection, self.clicks, self.number or 1, 1), self.followed_object
        return made if known is None else replace(made, name=known.name, color=known.color, category=known.category)


@record
class Preview:
    """The effect that a click under the pointer would have.

    Attributes
    ----------
    after : Selection
        The object after the click.
    before : Selection or None
        The present object; None when the click would begin one.
    adds : bool
        Whether the click adds to the object; otherwise it removes a part.
    """

    after: Selection
    before: Selection | None
    adds: bool


@record
class ShownObjects:
    """Proposals, the preview and the selection of objects, shown together with the objects of the document.

    Attributes
    ----------
    proposals : tuple of Proposal
        Offered objects: the object of the clicks, and those of the run.
    preview : Preview or None
        Effect that a click under the pointer would have.
    selected : frozenset of int
        Numbers of the selected objects, and keys of the selected proposals.
    hovered : int
        Number of the object, or key of the proposal, under the pointer; 0 for none.
    awaited : tuple of Click
        Clicks whose answer is not shown yet.
    """

    proposals: tuple[Proposal, ...] = ()
    preview: Preview | None = None
    selected: frozenset[int] = frozenset()
    hovered: int = 0
    awaited: Clicks = ()


@record
class NearParticles:
    """The particles of a volume that a slice shows.

    Attributes
    ----------
    index : ndarray of int, shape (M,)
        Indices among all particles.
    distance : ndarray, shape (M,)
        Distances from the slice: 0 in it, 1 where particles are no longer shown.
    """

    index: Index
    distance: Array


@record
class Scene:
    """Everything shown on the canvas.

    The image of a session's scene may be a volume. Each view then draws the scene of a slice, made by
    `cpm_app.session.features.slices`, whose image is the slice and whose `volume` and `near_particles` are set.

    Attributes
    ----------
    image : Image or None
        The image; None while none is open.
    display : DisplayImage or None
        The image with its full range of gray values.
    shaded : ImageShaded or None
        The image in the last requested intensity window.
    document : Document
        Shapes, parameters and objects.
    selected_shape : int or None
        Index of the selected shape.
    image_seeds : mapping of start to ndarray
        Seeds of the starts that depend on the image.
    snapshot : Snapshot or None
        The particles; None while there is no run.
    timeline : TimelineState
        The runs on the image, and their branches.
    reconstruction : Reconstruction or None
        Result of the run, by any method; this is what is exported.
    selected_contours : frozenset of int
        Indices of the selected contours.
    hovered_contour : int or None
        Index of the contour under the pointer.
    overlays : mapping of str to OverlayData
        The requested overlays by name; see `cpm_app.session.worker.prepared_methods`.
    probed : ForcesProbed or None
        Forces on a particle.
    truth : Truth, VolumeTruth or None
        Ground truth that results are compared with, unless the reference is the shown result.
    differences : tuple of Difference
        Places where the compared contours or surface differ from the reference.
    surface_differences : tuple of SurfaceDifference
        In a volume, the parts of the surfaces that differ.
    objects : ShownObjects
        The selection of objects.
    slices : Slices or None
        The slices of a volume that are shown; None for an image.
    volume : Image or None
        The volume whose slice `image` is; None for an image of its own, and for the volume itself.
    near_particles : NearParticles or None
        Particles of a volume that are shown in a slice.
    second : SecondImage or None
        The second image, which lies over the first.
    channels : tuple of Channel
        The channels of the file; none where there is only one, or where they are red, green and blue.
    whole : Scene or None
        The scene of the volume, in that of a slice.
    """

    image: Image | None = None
    display: DisplayImage | None = None
    shaded: ImageShaded | None = None
    document: Document = field(default_factory=Document)
    selected_shape: int | None = None
    image_seeds: ImageSeeds = field(default_factory=lambda: NO_SEEDS)
    snapshot: Snapshot | None = None
    timeline: TimelineState = EMPTY_TIMELINE
    reconstruction: Reconstruction | None = None
    selected_contours: frozenset[int] = frozenset()
    hovered_contour: int | None = None
    overlays: Mapping[str, OverlayData] = field(default_factory=dict)
    probed: ForcesProbed | None = None
    truth: Truth | VolumeTruth | None = None
    differences: tuple[Difference, ...] = ()
    surface_differences: tuple[SurfaceDifference, ...] = ()
    objects: ShownObjects = field(default_factory=ShownObjects)
    slices: Slices | None = None
    volume: Image | None = None
    near_particles: NearParticles | None = None
    second: SecondImage | None = None
    channels: tuple[Channel, ...] = ()
    whole: Scene | None = None

    @property
    def full_image(self) -> Image | None:
        """The image as it was opened: the volume if a slice is shown."""
        return self.image if self.volume is None else self.volume

    @property
    def view_source(self) -> tuple[Image | None, int | None]:
        """The image that a view shows a part of, and the axis of the slices if it is a volume."""
        return self.full_image, self.slices.axis if self.slices is not None else None

    @property
    def result(self) -> Result | None:
        """The contours or the surface that the run has found."""
        found = None if self.reconstruction is None else self.reconstruction.result
        return found if isinstance(found, Result) else None

    @property
    def contours(self) -> Contours:
        """The contours that the run has found, longest first."""
        return () if self.result is None else self.result.contours

    @property
    def skeleton(self) -> Skeleton | None:
        """The skeleton that the run has found."""
        found = None if self.reconstruction is None else self.reconstruction.result
        return found if isinstance(found, Skeleton) and found.contours else None

    @property
    def has_particles(self) -> bool:
        """Whether particles are shown; before the very first run the kernels may have to be compiled."""
        return self.snapshot is not None and (self.snapshot.state.step > 0 or len(self.snapshot.position) > 0)
