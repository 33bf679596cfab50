"""Scenes of plain shapes: those of Fig. 5 to 10, 17 and 18."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from cpm_core.contours.contour import Contour
from cpm_core.model.starts import circle
from cpm_core.parameters import Parameters
from docs.gallery.outlines import (
    Rings,
    blended,
    curve,
    disk,
    ellipse,
    limb,
    polygon,
    rings,
    round_ring,
    stroke,
    union,
    without,
)
from docs.gallery.scenes import Scene, binary, closed, grain, paint

SIDE = 144
SIZE = (SIDE, SIDE)


def letter_u() -> Scene:
    """Draw the U of Fig. 5, with a circle over the lower right."""
    outer = union(stroke([(24, 72), (82, 72)], 96.0), disk((82, 72), 48.0))
    outline = without(outer, union(stroke([(-30, 72), (82, 72)], 44.0)))
    cut = rings(lambda points: np.maximum(outline(points), 22.3 - points[..., 0]), SIZE)  # without the rows above
    return binary(SIZE, cut, circle((104.0, 100.0), 17.0))


def flower() -> Scene:
    """Draw a shape with deep bays for Fig. 6, with a circle in its middle."""
    outline = curve((71.6, 72.3), lambda angle: 41.0 + 20.0 * np.cos(7.0 * angle + 0.5))
    return binary(SIZE, outline, circle((71.6, 72.3), 18.5))


def silhouettes() -> dict[str, Scene]:
    """Fig. 7: starts across, beside and around shapes, which are no initializations for a snake."""
    return {
        "fish, across": binary(SIZE, _fish(), circle((60.0, 60.0), 34.0)),
        "key, one side": binary(SIZE, _key(), circle((26.0, 26.0), 12.0)),
        "star, a corner": binary(SIZE, _star(), circle((108.0, 110.0), 26.0)),
        "gear, around": binary(SIZE, _gear(), circle((72.0, 72.0), 64.0)),
        "hand, inside": binary(SIZE, hand(), circle((104.0, 76.0), 9.0)),
    }


def _fish() -> Rings:
    body = blended(10.0, limb((72, 40), (72, 78), 25.0, 22.0), limb((72, 78), (72, 112), 20.0, 6.0))
    tail = union(limb((72, 108), (48, 128), 5.0, 8.0), limb((72, 108), (96, 128), 5.0, 8.0))
    fins = union(limb((54, 62), (34, 82), 7.0, 4.0), limb((92, 66), (110, 80), 6.0, 3.5))
    return rings(blended(8.0, body, tail, fins), SIZE)


def _key() -> Rings:
    bow = without(disk((44, 44), 29.0), disk((40, 40), 13.0))
    bits = union(limb((96, 96), (82, 110), 4.5), limb((110, 110), (96, 124), 4.5), limb((118, 118), (108, 128), 4.5))
    return rings(union(bow, limb((62, 62), (119, 119), 6.0), bits), SIZE)


def _star() -> Rings:
    angle = np.pi * np.arange(14) / 7.0 + 0.2
    radius = np.where(np.arange(14) % 2 == 0, 60.0, 27.0)
    return polygon(np.stack([72.2 + radius * np.sin(angle), 71.7 + radius * np.cos(angle)], axis=1))


def _gear() -> Rings:
    teeth = curve((72.0, 72.0), lambda angle: 46.0 + 7.0 * np.tanh(4.0 * np.sin(12.0 * angle)))
    return (*teeth, *round_ring((72.0, 72.0), 17.0))


def hand() -> Rings:
    """Draw an open hand."""
    fingers = [
        limb((104, 60), (52, 34), 8.5, 6.5),
        limb((96, 70), (26, 58), 8.5, 6.5),
        limb((96, 80), (20, 82), 8.5, 6.5),
        limb((102, 90), (34, 106), 8.0, 6.0),
        limb((116, 60), (92, 22), 9.0, 7.0),
    ]
    return rings(blended(6.0, limb((104, 74), (116, 76), 24.0), *fingers), SIZE)


def concavities() -> dict[str, Scene]:
    """Fig. 8: a spiral corridor and a comb."""
    return {"a spiral": spiral(), "a comb": comb()}


def spiral() -> Scene:
    """Draw a corridor that winds inwards, started from a circle on its outer side."""
    angle = np.linspace(0.0, 5.2 * np.pi, 150)
    radius = 9.0 + 9.6 * angle / np.pi
    path = np.stack([76.0 + radius * np.sin(angle), 72.0 + radius * np.cos(angle)], axis=1)
    return binary(SIZE, rings(stroke(path, 11.0), SIZE), circle((112.0, 30.0), 12.0))


def comb() -> Scene:
    """Slits 7 px wide and 92 px deep, started at the far ends of the teeth."""
    teeth = [(18.0 + 18.0 * k, 18.0 + 18.0 * k + 11.0) for k in range(6)]
    corners = [(126.3, 18.2), (20.3, 18.2)]
    for (_, right), (left, _) in pairwise(teeth):
        corners += [(20.3, right + 0.2), (112.3, right + 0.2), (112.3, left + 0.2), (20.3, left + 0.2)]
    corners += [(20.3, teeth[-1][1] + 0.2), (126.3, teeth[-1][1] + 0.2)]
    return binary(SIZE, polygon(corners), circle((26.0, 72.0), 20.0))


def embedded() -> dict[str, Scene]:
    """Fig. 9: junctions, objects in objects, and several starts."""
    return {
        "three parts of a disk": _parts(),
        "objects in objects": _face(),
        "rings in rings": _target(),
        "several starts": _scattered(),
    }


def _parts() -> Scene:
    """Draw a disk in three parts of different gray: lines that meet in junctions."""
    center, radius = (72.0, 72.0), 50.0
    bounds = np.array([0.3, 2.5, 4.6, 0.3 + 2.0 * np.pi])
    layers, truth = [], []
    for low, high, contrast in zip(bounds[:-1], bounds[1:], (200.0, 60.0, 130.0), strict=True):
        angle = np.linspace(low, high, 220)
        arc = np.stack([center[0] + radius * np.sin(angle), center[1] + radius * np.cos(angle)], axis=1)
        layers.append((polygon([center, *arc]), contrast))
        truth += [Contour(arc, closed=False), Contour(np.array([center, arc[0]]), closed=False)]
    return Scene(paint(SIZE, 20.0, *layers), tuple(truth), circle((72.0, 118.0), 12.0))


def _face() -> Scene:
    parts = (
        (ellipse((72, 72), 56.0, 48.0), 110.0),
        (round_ring((56, 53), 10.0), 90.0),
        (round_ring((56, 91), 10.0), 90.0),
        (rings(stroke([(94, 52), (102, 62), (104, 72), (102, 82), (94, 92)], 10.0), SIZE), -80.0),
    )
    return Scene(paint(SIZE, 30.0, *parts), closed(*(outline for outline, _ in parts)), circle((72.0, 26.0), 14.0))


def _target() -> Scene:
    circles = [round_ring((70.3 + 2.0 * k, 73.2 - 1.5 * k), 58.0 - 13.0 * k) for k in range(4)]
    layers = tuple(zip(circles, (200.0, -110.0, 90.0, -130.0), strict=True))
    return Scene(paint(SIZE, 20.0, *layers), closed(*circles), circle((72.0, 122.0), 13.0))


def _scattered() -> Scene:
    parts = (
        (ellipse((38, 42), 17.0, 25.0, 0.5), 120.0),
        (polygon([(24, 92), (22, 128), (62, 122), (50, 96)]), 200.0),
        (curve((104, 102), lambda angle: 24.0 + 5.0 * np.cos(3.0 * angle)), 160.0),
        (rings(stroke([(84, 22), (104, 30), (112, 48), (126, 54)], 14.0), SIZE), 90.0),
    )
    seeds = [circle(at, 6.0) for at in ((38.0, 42.0), (44.0, 110.0), (104.0, 102.0), (108.0, 40.0))]
    return Scene(paint(SIZE, 30.0, *parts), closed(*(outline for outline, _ in parts)), np.concatenate(seeds))


ACROSS = ("ellipse", "border", "circle")
"""Objects of the damping experiment, in the order in which particles can reach them."""


def across(contrast: float = 40.0) -> Scene:
    """Fig. 10: an ellipse, a border between two regions that differ by `contrast`, and a circle beyond it.

    The start lies beside the ellipse. The truth lists the objects in the order of `ACROSS`.
    """
    size, column = (128, 160), 85.8
    right = polygon([(-0.5, column), (-0.5, 159.5), (127.5, 159.5), (127.5, column)])
    near, far = ellipse((70, 40), 14.0, 20.0, 0.3), round_ring((60, 122), 17.0)
    border = Contour(np.array([(0.0, column), (127.0, column)]), closed=False)
    return Scene(
        paint(size, 40.0, (right, contrast), (near, 60.0), (far, 90.0)),
        (*closed(near), border, *closed(far)),
        circle((28.0, 30.0), 10.0),
        Parameters(scales=1),
    )


def for_noise() -> Scene:
    """Fig. 18: a binary object with convex and concave parts, and a circle across its boundary."""
    body = blended(14.0, limb((88, 52), (92, 98), 30.0, 24.0), limb((70, 60), (36, 46), 14.0, 12.0))
    return binary(SIZE, rings(body, SIZE), circle((88.0, 96.0), 20.0))


def for_sensitivity() -> Scene:
    """Fig. 17: a shape with narrow bays, started from a circle over one of its arms."""
    outline = curve((72.0, 72.0), lambda angle: 42.0 + 16.0 * np.cos(4.0 * angle + 0.4))
    return binary(SIZE, outline, circle((60.0, 40.0), 14.0))


def out_of_reach() -> Scene:
    """Fig. 17: two shapes in noise, of which the start touches only one: particles must travel to the other."""
    near, far = curve((62.0, 60.0), lambda angle: 36.0 + 16.0 * np.cos(4.0 * angle + 0.4)), round_ring((116, 112), 16)
    values = paint(SIZE, 60.0, (near, 120.0), (far, 120.0)) + grain(SIZE, 30.0, 171)
    return Scene(values, closed(near, far), circle((50.0, 34.0), 13.0), Parameters(smoothing=1.5))
