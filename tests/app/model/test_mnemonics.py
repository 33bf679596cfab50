"""No letter chooses two entries of a menu, in any language."""

from __future__ import annotations

from cpm_app.model.text.keys import find_mnemonic, make_mnemonics_unique
from hypothesis import given
from hypothesis import strategies as st

LETTERS = st.text(alphabet="aAbBéß終 &()", max_size=12)
TEXTS = st.lists(LETTERS, max_size=12)


def bare(text: str) -> str:
    return text.replace("&", "")


@given(TEXTS)
def test_no_letter_is_marked_twice(texts):
    letters = [letter for letter in map(find_mnemonic, make_mnemonics_unique(texts)) if letter]

    assert len(letters) == len(set(letters))


@given(TEXTS)
def test_the_first_text_with_a_letter_keeps_it(texts):
    made = make_mnemonics_unique(texts)

    first = {}
    for text, other in zip(texts, made, strict=True):
        if find_mnemonic(text):
            first.setdefault(find_mnemonic(text), (text, other))
    assert all(text == other for text, other in first.values())


@given(st.lists(st.text(alphabet="abc &", max_size=8), max_size=8))
def test_texts_in_letters_stay_the_same_but_for_the_mark(texts):
    assert [bare(text) for text in make_mnemonics_unique(texts)] == [bare(text) for text in texts]


@given(TEXTS)
def test_texts_that_are_told_apart_stay_so(texts):
    once = make_mnemonics_unique(texts)

    assert make_mnemonics_unique(once) == once


def test_another_letter_is_the_first_of_a_word_if_one_is_free():
    assert make_mnemonics_unique(["&Save", "&Send file"]) == ["&Save", "Send &file"]


def test_a_letter_behind_a_text_is_exchanged_there():
    assert make_mnemonics_unique(["開く(&O)", "最近(&O)"]) == ["開く(&O)", "最近(&A)"]


def test_a_text_whose_letters_are_all_taken_has_none():
    assert make_mnemonics_unique(["&a", "&a"]) == ["&a", "a"]


def test_a_doubled_sign_stands_for_itself():
    assert make_mnemonics_unique(["&Cut", "R&&D &Costs"]) == ["&Cut", "&R&&D Costs"]
