"""Runs: the engine that takes steps, an iterator over them, their results, and the interface of all methods."""

from cpm_core.segmentation.large_images import LargeImageSettings as LargeImageSettings
from cpm_core.segmentation.large_images import large_image_settings as large_image_settings
from cpm_core.segmentation.method import MethodState as MethodState
from cpm_core.segmentation.method import Steerable as Steerable
