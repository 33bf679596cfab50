"""The model as published, sections 3 to 5.4, to the letter: to read next to the paper, and to compare with."""

from cpm_core.published.method import Published as Published
from cpm_core.published.method import PublishedState as PublishedState
