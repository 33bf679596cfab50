"""A mistake in a call is answered by one sentence that says what is wrong, and what is named is found."""

from __future__ import annotations

import pickle

import pytest

import cpm_core as cpm
from cpm_core.methods import comparison
from cpm_core.segmentation import method as run_methods

SEEDS = cpm.circle((32, 32), 8)
IMAGE = cpm.example("disk")
PRESET_CALLS = {
    "segment": lambda given: cpm.segment(IMAGE, SEEDS, given, max_steps=1),
    "evolve": lambda given: cpm.evolve(IMAGE, SEEDS, given),
    "follow": lambda given: list(cpm.follow_pages([IMAGE], SEEDS, given, max_steps=1)),
    "partition": lambda given: cpm.partition(IMAGE, given),
    "skeleton": lambda given: cpm.skeleton(IMAGE, given),
    "Engine": lambda given: cpm.Engine(IMAGE, given),
    "published": lambda given: cpm.METHODS["published"](IMAGE, given),
}
MISTAKES = {
    "no seeds": (lambda: cpm.segment(IMAGE, None), "seeds is None but must be positions"),
    "no regions": (lambda: cpm.segment(IMAGE, SEEDS, regions=[1]), "regions is .* but must be Regions"),
    "no charge": (lambda: cpm.segment(IMAGE, SEEDS, charges=[(1, 2, 3)]), "a charge is .* but must be a PlacedCharge"),
    "a path": (lambda: cpm.segment("cells.png", SEEDS), '"cells.png" is a path, and no image: open it by load_image'),
    "a method to compare with": (
        lambda: cpm.segment(IMAGE, SEEDS, method="gvf"),
        'method is "gvf" but must be a class, or one of cpm, published',
    ),
    "no selection": (lambda: cpm.select(IMAGE, [(5, 5)], previous=3), "previous is 3 but must be a selection"),
    "a volume": (lambda: cpm.select(cpm.example("ball"), [(15, 15, 15)]), r"in a volume, use partition\(volume\)"),
    "nothing alike": (lambda: cpm.select_all(IMAGE, [3]), r"like is \[3\] but must be a list of selections"),
    "no method": (lambda: cpm.run_method("x", IMAGE, cpm.Start((SEEDS,))), 'method is "x" but must be one of cpm, obj'),
}


def in_one_sentence(caught):
    text = str(caught.value)
    assert text.count("\n") == 0
    assert text.endswith((".", "?"))
    assert ". " not in text


@pytest.mark.parametrize("name", PRESET_CALLS)
def test_parameters_are_values_or_the_name_of_a_preset(name):
    PRESET_CALLS[name]("noisy")
    for wrong in ("nosy", {"beta": 1.0}, {}, 3):
        with pytest.raises(ValueError, match=r"parameters is .* but must be Parameters, or one of shape, ") as caught:
            PRESET_CALLS[name](wrong)
        in_one_sentence(caught)


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_answered_in_one_sentence(name):
    call, says = MISTAKES[name]
    with pytest.raises(ValueError, match=says) as caught:
        call()
    in_one_sentence(caught)


@pytest.mark.parametrize(
    "load",
    [cpm.load_image, cpm.load_volume, cpm.load_contours, cpm.load_points, lambda path: list(cpm.load_pages(path))],
)
def test_a_missing_file_is_a_value_error_and_a_file_not_found(load):
    for kind in (ValueError, FileNotFoundError):
        with pytest.raises(kind, match=r"nothing\.csv does not exist") as caught:
            load("nothing.csv")
        in_one_sentence(caught)
        assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def test_presets_and_methods_cannot_be_overwritten():
    for table in (cpm.PRESETS, cpm.METHODS, cpm.CONTOUR_METHODS):
        with pytest.raises(TypeError):
            table["shape"] = None


class Hasty(cpm.Engine):
    """The charged particles under a name of their own."""

    name = "hasty"


@pytest.fixture
def put_back():
    """The tables of methods are put back after the test."""
    tables = run_methods._known_run_methods, comparison._known_contour_methods
    before = [dict(table) for table in tables]
    yield
    for table, known in zip(tables, before, strict=True):
        table.clear()
        table.update(known)


@pytest.mark.usefixtures("put_back")
def test_a_registered_method_is_run_by_its_name():
    cpm.register_method(Hasty)
    assert cpm.METHODS["hasty"] is Hasty
    assert cpm.segment(IMAGE, SEEDS, method="hasty", max_steps=2).provenance.method == "hasty"
    snake = cpm.CONTOUR_METHODS["snake"]
    cpm.register_method(cpm.ContourMethod("mine", "Mine", "", "", snake.settings, snake.evolve))
    assert cpm.METHODS["mine"] is cpm.CONTOUR_METHODS["mine"]
    assert cpm.run_method("mine", IMAGE, cpm.Start((SEEDS,)), max_steps=2).state.step == 2


@pytest.mark.usefixtures("put_back")
def test_only_a_method_with_a_name_of_its_own_is_registered():
    for wrong, says in (
        (cpm.Engine, 'a method with the name "cpm"'),
        (str, "is no method, since it has no "),
        (3, "3 is"),
    ):
        with pytest.raises(ValueError, match=says) as caught:
            cpm.register_method(wrong)
        in_one_sentence(caught)
