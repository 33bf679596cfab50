"""Drawn images of the publication's Fig. 1 to 3, each with a start that all methods share."""

import numpy as np
import scipy

from cpm_core.contours.ground_truth import truth_from_contours, truth_from_mask
from cpm_core.image.image import Image
from cpm_core.methods import Start
from docs.gallery.outlines import polygon
from docs.gallery.scenes import closed, paint

SIZE = (96, 96)
MIDDLE = (48.0, 48.0)
ROW, COL = np.indices(SIZE)


def ring(center, radius, count=80):
    angle = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    return np.stack([center[0] + radius * np.sin(angle), center[1] + radius * np.cos(angle)], axis=1)


AROUND = Start((ring(MIDDLE, 46.5),), around=True)

BAY_MOUTH, BAY_END, BAY_WIDTH = 16.2, 66.0, 6.0


def long_bay():
    """Fig. 1: a square with a bay 50 px deep and 6 px wide, and its truth."""
    left, right = 48.0 - BAY_WIDTH / 2, 48.0 + BAY_WIDTH / 2
    corners = [(16.2, 16.2), (16.2, left), (BAY_END, left), (BAY_END, right), (16.2, right)]
    outline = polygon([*corners, (16.2, 79.8), (79.8, 79.8), (79.8, 16.2)])
    return Image(paint(SIZE, 20.0, (outline, 200.0))), truth_from_contours(closed(outline), SIZE)


def depth_in_bay(contours):
    """How far contours reach into the bay of `long_bay` [px]; 0 without contours."""
    points = np.concatenate([contour.points for contour in contours])
    inside = (np.abs(points[:, 1] - 48.0) < BAY_WIDTH / 2 + 1.0) & (points[:, 0] < BAY_END + 5.0)
    return max(float(points[inside, 0].max(initial=BAY_MOUTH)) - BAY_MOUTH, 0.0)


def two_objects():
    """Fig. 2a: two rectangles beside each other, and their truth."""
    left = polygon([(25.2, 12.2), (25.2, 40.2), (70.8, 40.2), (70.8, 12.2)])
    right = polygon([(25.2, 55.2), (25.2, 83.2), (70.8, 83.2), (70.8, 55.2)])
    return Image(paint(SIZE, 20.0, (left, 200.0), (right, 200.0))), truth_from_contours(closed(left, right), SIZE)


def drawing_with_gap(gap=24.0):
    """Fig. 2b: a square drawn as a line with a gap in its upper side; with the distance of pixels from the line."""
    square = np.maximum(np.abs(ROW - 48.0), np.abs(COL - 48.0))
    line = np.abs(square - 28.0)
    line[(ROW < 48) & (np.abs(COL - 48.0) < gap / 2)] = 99.0
    away = scipy.ndimage.distance_transform_edt(line > 1.0)
    return Image(20.0 + 200.0 * np.clip(2.0 - line, 0.0, 1.0)), away


def fading_disk():
    """Fig. 3: a disk in noise on a background that comes near its own gray level on one side; start and truth."""
    inside = np.hypot(ROW - 48.0, COL - 48.0) < 30.0
    background = 40.0 + 120.0 * np.clip((COL - 30.0) / 40.0, 0.0, 1.0)
    values = scipy.ndimage.gaussian_filter(np.where(inside, 200.0, background), 1.0)
    noise = np.random.default_rng(3).normal(0.0, 12.0, SIZE)
    return Image(values + noise), Start((ring((48.0, 36.0), 10.0),)), truth_from_mask(inside)
