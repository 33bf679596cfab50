"""Finished sentences are found again among the templates that they were made of, and said in another language.

A template is a text with names in braces for what is put in, such as ``{name} has {count} pages``. A sentence is made
of it when it has its fixed parts, in their order; what stands between them are the values. Of several templates the one
with the most fixed letters is taken.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence

_PLACEHOLDER = re.compile(r"\{(\w+)\}")

_DEEPEST = 3
"""Sentences within values of sentences."""

_END_OF_SENTENCE = re.compile(r"(?<=[.!?]) (?=\S)")


class _Template:
    """A template and its translation."""

    def __init__(self, text: str, translation: str) -> None:
        self.translation = translation
        self._fixed: Sequence[str] = _PLACEHOLDER.split(text)[::2]
        self._names: Sequence[str] = _PLACEHOLDER.findall(text)
        self.letters = sum(map(len, self._fixed))

    def values(self, said: str) -> dict[str, str] | None:
        """What was put in to make the sentence; None when it is made of something else."""
        first, *between, last = self._fixed
        end = len(said) - len(last)
        at = len(first)
        if not (said.startswith(first) and said.endswith(last) and at <= end):
            return None
        found = []
        for fixed in between:
            place = said.find(fixed, at, end)
            if place < 0:
                return None
            found.append(said[at:place])
            at = place + len(fixed)
        return dict(zip(self._names, (*found, said[at:end]), strict=True))


class Templates:
    """Translations of templates, by the templates."""

    def __init__(self, translations: Mapping[str, str]) -> None:
        self._whole = {text: other for text, other in translations.items() if not _PLACEHOLDER.search(text)}
        made = [_Template(text, other) for text, other in translations.items() if _PLACEHOLDER.search(text)]
        self._templates = sorted(made, key=lambda template: template.letters, reverse=True)

    def translated(self, said: str, otherwise: Callable[[str], str] = str, depth: int = 0) -> str:
        """The sentence, or several of them, in the other language; unchanged where nothing of it is known.

        `otherwise` is asked for what is no template, such as the name of a parameter.
        """
        if not said or depth > _DEEPEST:
            return said
        known = self._whole.get(said) or otherwise(said)
        if known != said:
            return known
        for template in self._templates:
            values = template.values(said)
            if values is not None:
                put_in = {name: self.translated(value, otherwise, depth + 1) for name, value in values.items()}
                return template.translation.format(**put_in)
        return self._in_parts(said, otherwise, depth)

    def _in_parts(self, said: str, otherwise: Callable[[str], str], depth: int) -> str:
        """A text of several sentences, one after the name of a file and a colon, or a word with a number."""
        parts = _END_OF_SENTENCE.split(said)
        if len(parts) > 1:
            return " ".join(self.translated(part, otherwise, depth + 1) for part in parts)
        head, colon, tail = said.partition(": ")
        if colon:
            return f"{head}{colon}{self.translated(tail, otherwise, depth + 1)}"
        head, space, number = said.rpartition(" ")
        return f"{self.translated(head, otherwise, depth + 1)}{space}{number}" if number.isdecimal() else said
