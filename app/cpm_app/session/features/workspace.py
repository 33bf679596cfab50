"""The workspace: a session and its features, built in one place."""

from __future__ import annotations

from cpm_app.session.features.channel_images import ChannelImages
from cpm_app.session.features.comparison import ComparedResults
from cpm_app.session.features.contour_selection import ContourSelection
from cpm_app.session.features.followed_objects import FollowedObjects
from cpm_app.session.features.image_project import ImageProject
from cpm_app.session.features.object_brush import ObjectBrush
from cpm_app.session.features.object_commands import ObjectCommands
from cpm_app.session.features.object_list import ObjectList
from cpm_app.session.features.object_selection import ObjectSelection
from cpm_app.session.features.outline_editing import OutlineEditing
from cpm_app.session.features.second_images import SecondImages
from cpm_app.session.features.slices import SliceNavigation
from cpm_app.session.features.stack_pages import StackPages
from cpm_app.session.features.timeline_navigation import TimelineNavigation
from cpm_app.session.session import Session


class Workspace:
    """A session with its features; the session knows none of them."""

    def __init__(self) -> None:
        self.session = Session()
        self.contour_selection = ContourSelection(self.session)
        self.outline_editing = OutlineEditing(self.session, self.contour_selection)
        self.object_list = ObjectList(self.session, self.contour_selection)
        self.object_brush = ObjectBrush(self.session, self.object_list)
        self.object_commands = ObjectCommands(self.session, self.contour_selection, self.object_list)
        self.pages = StackPages(self.session, self.contour_selection)
        self.followed_objects = FollowedObjects(self.session, self.pages)
        self.object_selection = ObjectSelection(
            self.session, self.object_list, self.object_commands, self.pages, self.followed_objects
        )
        self.project = ImageProject(self.session, self.object_list, self.object_selection, self.pages)
        self.navigation = TimelineNavigation(self.session)
        self.slices = SliceNavigation(self.session)
        self.comparison = ComparedResults(self.session, self.navigation)
        self.second_images = SecondImages(self.session)
        self.channel_images = ChannelImages(self.session)
