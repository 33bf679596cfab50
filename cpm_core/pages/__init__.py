"""Stacks whose pages are separate images: one run a page, objects followed from page to page as tracks."""

from cpm_core.pages.follow import ContourFollower as Follower
from cpm_core.pages.follow import limit_scales as fitting
from cpm_core.pages.follow import describe_error as trouble_of
from cpm_core.pages.objects import FollowedObject as FollowedObject
from cpm_core.pages.objects import ObjectFollower as ObjectFollower
from cpm_core.pages.objects import follow_objects as follow_objects
from cpm_core.pages.objects import pages_from_results as pages_of
from cpm_core.pages.page import StackResult as StackResult
from cpm_core.pages.page import Track as Track
from cpm_core.pages.page import strip_image as without_image
