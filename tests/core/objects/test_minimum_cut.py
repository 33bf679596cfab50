"""The minimum cut, against all sets of small graphs and against the maximum flow of SciPy."""

from itertools import product

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import maximum_flow

from cpm_core.objects.faces.minimum_cut import FreePart, arcs, minimum_cut


@st.composite
def graphs(draw, most_nodes, most_price=9):
    """Links without loops, their prices, and the prices of the nodes; all whole numbers, many of them 0."""
    count = draw(st.integers(1, most_nodes))
    seed = draw(st.integers(0, 2**32 - 1))
    random = np.random.default_rng(seed)
    links = draw(st.integers(0, 3 * count))
    first, second = np.sort(random.integers(0, count, (2, links)), axis=0)
    first, second = first[first < second], second[first < second]
    price = random.integers(0, most_price + 1, len(first)).astype(float)
    leaving, entering = (
        random.integers(0, most_price + 1, count) * (random.random(count) < 0.4).astype(float) for _ in range(2)
    )
    return first, second, price, leaving, entering


def total(graph, inside):
    first, second, price, leaving, entering = graph
    return price[inside[first] != inside[second]].sum() + leaving[~inside].sum() + entering[inside].sum()


def cut(graph):
    first, second, price, leaving, entering = graph
    return minimum_cut(arcs(first, second, len(leaving)), price, leaving, entering)


@settings(deadline=None, max_examples=24)
@given(graphs(7))
def test_no_set_is_cheaper_and_none_as_cheap_is_smaller(graph):
    found = cut(graph)
    every = [np.array(inside) for inside in product((False, True), repeat=len(found))]
    least = min(total(graph, inside) for inside in every)
    assert total(graph, found) == least
    for inside in every:
        assert total(graph, inside) > least or not (found & ~inside).any()


@settings(deadline=None, max_examples=24)
@given(graphs(60, 1000))
def test_the_cut_costs_what_the_maximum_flow_carries(graph):
    first, second, price, leaving, entering = graph
    count = len(leaving)
    nodes, source, sink = np.arange(count), np.full(count, count), np.full(count, count + 1)
    rows, cols = np.concatenate([first, second, source, nodes]), np.concatenate([second, first, nodes, sink])
    capacity = np.concatenate([price, price, leaving, entering]).astype(np.int32)
    places = rows.astype(np.int32), cols.astype(np.int32)  # SciPy 1.13 takes no others
    network = csr_array((capacity, places), shape=(count + 2, count + 2))
    network.sum_duplicates()
    assert total(graph, cut(graph)) == maximum_flow(network, count, count + 1).flow_value


@settings(deadline=None, max_examples=24)
@given(graphs(30), st.integers(0, 2**32 - 1))
def test_a_cut_of_a_part_is_that_of_the_whole_with_the_others_tied(graph, seed):
    first, second, price, leaving, entering = graph
    free, inside = np.random.default_rng(seed).random((2, len(leaving))) < 0.5
    found = FreePart(first, second, price, free, inside).cut(leaving, entering)
    tied = np.where(~free & inside, np.inf, leaving), np.where(~free & ~inside, np.inf, entering)
    whole = np.where(~free & ~inside, 0.0, tied[0]), np.where(~free & inside, 0.0, tied[1])
    assert np.array_equal(found[~free], inside[~free])
    assert np.array_equal(found, minimum_cut(arcs(first, second, len(free)), price, *whole))
