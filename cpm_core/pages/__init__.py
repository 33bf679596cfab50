"""Stacks whose pages are separate images: one run a page, objects followed from page to page as tracks."""

from cpm_core.pages.follow import PageFollower as PageFollower
from cpm_core.pages.follow import describe_error as describe_error
from cpm_core.pages.follow import limit_scales as limit_scales
from cpm_core.pages.objects import FollowedObject as FollowedObject
from cpm_core.pages.objects import ObjectFollower as ObjectFollower
from cpm_core.pages.objects import follow_objects as follow_objects
from cpm_core.pages.page import StackResult as StackResult
from cpm_core.pages.page import Track as Track
from cpm_core.pages.page import strip_image as strip_image
