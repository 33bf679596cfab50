"""Review: a mark finds its contour after every reconstruction, and rejected contours are not exported."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import Parameters, circle, segment
from cpm_core.contours.contour import Bridge, Contour
from cpm_core.contours.review import Mark, assign_anchors, find_anchors, pair_with_marks
from cpm_core.results.result import Result
from cpm_core.results.review import apply_marks


def ring(row: float, col: float, radius: float, count: int = 60, turn: float = 0.0) -> Contour:
    angle = turn + np.arange(count) * 2 * np.pi / count
    return Contour(np.column_stack([row + radius * np.sin(angle), col + radius * np.cos(angle)]), True, 5.0)


def line(*points: tuple[float, float]) -> Contour:
    return Contour(np.array(points, dtype=float), False, 3.0)


def result_of(*contours: Contour, bridges: tuple[Bridge, ...] = ()) -> Result:
    return Result(np.empty((0, 2)), contours, None, 1, True, "", (200, 200), (1.0, 1.0), None, "", bridges)


def grid_of_rings() -> list[Contour]:
    return [ring(30 + 40 * row, 30 + 40 * col, 8.0 + row + 3 * col) for row in range(3) for col in range(3)]


@settings(max_examples=40, deadline=None)
@given(
    st.permutations(range(9)),
    st.floats(0, 2 * np.pi),
    st.floats(-0.7, 0.7),
    st.floats(-0.7, 0.7),
    st.lists(st.sampled_from(range(9)), unique=True),
)
def test_marks_find_contours_that_have_moved_turned_and_changed_their_order(order, turn, down, right, chosen):
    first = grid_of_rings()
    marks = [
        Mark(at, "rejected", f"ring {index}") for at, index in zip(find_anchors(first, chosen), chosen, strict=True)
    ]
    again = [ring(30 + 40 * (i // 3) + down, 30 + 40 * (i % 3) + right, 8.0 + i // 3 + 3 * (i % 3), 47, turn)
             for i in order]  # fmt: skip
    for one in pair_with_marks(again, marks):
        index = order[one.index]
        assert (one.mark.name if one.mark else "") == (f"ring {index}" if index in chosen else "")
        assert one.contour.name == (f"ring {index}" if index in chosen else "")


def test_an_anchor_is_far_from_other_contours() -> None:
    shared = [(20.0, 0.0), (20.0, 40.0)]
    contours = [line(*shared, (20, 60)), line((21, 0), (21, 45))]
    row, col = find_anchors(contours, [0])[0]
    assert (row, col > 50) == (20.0, True)
    assert assign_anchors(contours, [(row, col)]) == [0]


def test_the_exported_result_has_no_rejected_contours_and_has_names_and_colors() -> None:
    one, two, three = ring(30, 30, 10), ring(30, 90, 12), ring(90, 90, 14)
    marks = (Mark((30.0, 40.0), "rejected"), Mark((30.0, 102.0), "kept", "left ventricle", "#D55E00"))
    written = apply_marks(result_of(one, two, three), marks)
    assert [(c.name, c.color) for c in written.contours] == [("left ventricle", "#D55E00"), ("", "")]
    np.testing.assert_array_equal(written.contours[0].points, two.points)
    result = result_of(one)
    assert apply_marks(result, ()) is result


def test_a_bridge_is_dropped_with_its_contour() -> None:
    bridges = tuple(Bridge(np.array([[20.0, c - 1.0], [20.0, c], [20.0, c + 1.0]]), 2.0, 1.0) for c in (30.0, 90.0))
    written = apply_marks(
        result_of(ring(30, 30, 10), ring(30, 90, 10), bridges=bridges), [Mark((30.0, 40.0), "rejected")]
    )
    assert written.bridges == bridges[1:]


def test_marks_survive_a_run_from_another_start() -> None:
    row, col = np.indices((80, 120))
    values = np.where(np.hypot(row - 40, col - 32) < 18, 200.0, 20.0) + np.where(
        np.hypot(row - 40, col - 86) < 22, 150.0, 0.0
    )
    starts = [
        np.concatenate([circle((40, 32), radius=r, spacing=2.0), circle((40, 86), radius=r, spacing=2.0)])
        for r in (8.0, 13.0)
    ]
    first, second = (segment(values, seeds, Parameters(scales=1)) for seeds in starts)
    at = find_anchors(first.contours, range(len(first.contours)))
    marks = [Mark(at[i], name=f"{c.points[:, 1].mean() > 60}") for i, c in enumerate(first.contours)]
    assert len(first.contours) == len(second.contours) == 2
    for one in pair_with_marks(second.contours, marks):
        assert one.contour.name == f"{one.contour.points[:, 1].mean() > 60}"
