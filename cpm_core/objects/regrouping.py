"""Sets of faces after the cut: what hangs together is kept, holes are filled, what is far from a click stays."""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.objects.clicks import Clicked
from cpm_core.objects.faces.face_graph import FaceGraph


def connected(chosen: Mask, wanted: Mask, graph: FaceGraph) -> Mask:
    """Those of the chosen faces, shape (F,), that hang together with wanted ones."""
    group = _groups(chosen, graph)
    kept = np.zeros(graph.count, np.bool_)
    kept[group[chosen & wanted]] = True
    return np.asarray(chosen & kept[group])


def filled(chosen: Mask, outside: Mask, graph: FaceGraph) -> Mask:
    """Chosen faces, and the holes in them that nobody has said to be outside."""
    return ~connected(~chosen, outside | (graph.rim > 0.0), graph)


def kept_where_unconcerned(chosen: Mask, found: Clicked, before: Mask, places: Array) -> Mask:
    """Undo the changes of a selection that do not hang together with new places.

    Parameters
    ----------
    chosen : ndarray of bool, shape (F,)
        The new set of faces.
    found : Clicked
        The faces.
    before : ndarray of bool, shape (H, W)
        The pixels that were chosen before.
    places : ndarray, shape (N, 2)
        The new places [px].
    """
    labels, graph = found.faces.labels, found.faces.graph
    within = labels >= 0
    share = np.bincount(labels[within], before[within], graph.count) / graph.area
    former = share > 0.5
    limit = np.array(labels.shape) - 1
    pixel = np.rint(np.clip(places, 0, limit)).astype(np.int64)
    new = np.zeros(graph.count + 1, np.bool_)
    new[labels[pixel[:, 0], pixel[:, 1]]] = True
    # a face beside a change at the place hangs together with it as well
    changed = connected(chosen != former, new[:-1], graph)
    return np.asarray(np.where(changed | found.inside | found.outside, chosen, former))


def _groups(chosen: Mask, graph: FaceGraph) -> Index:
    """Number of the group of each face, shape (F,): chosen faces that are neighbors are in one group."""
    both = chosen[graph.first] & chosen[graph.second]
    count = graph.count
    ones = np.ones(int(both.sum()), np.int8)
    links = scipy.sparse.csr_array((ones, (graph.first[both], graph.second[both])), shape=(count, count))
    return np.asarray(scipy.sparse.csgraph.connected_components(links, directed=False)[1], dtype=np.int64)
