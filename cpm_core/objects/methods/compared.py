"""Which methods are compared, and with what settings: a value that a session keeps."""

from __future__ import annotations

from dataclasses import dataclass, replace

from cpm_core.objects.methods.registry import CONTOUR_METHODS, method_named
from cpm_core.objects.methods.settings import Settings

FIRST = ("cpm", "gvf", "gac", "chan_vese")
"""The methods that are compared at first."""


@dataclass(frozen=True)
class Compared:
    """A comparison of methods; its start is what is drawn.

    Attributes
    ----------
    methods : tuple of str
        Names of the methods.
    settings : tuple of (str, Settings)
        The settings of methods that are not their defaults. Those of the particles have the parameters of the run.
    around : bool
        Whether the start lies around the objects.

    Raises
    ------
    ValueError
        When there is no method of a name, or settings are those of another method.
    """

    methods: tuple[str, ...] = FIRST
    settings: tuple[tuple[str, Settings], ...] = ()
    around: bool = False

    def __post_init__(self) -> None:
        for name in self.methods:
            method_named(name)
        for name, settings in self.settings:
            if not isinstance(settings, method_named(name).settings):
                raise ValueError(f"The settings of {name} are those of another method.")

    def settings_of(self, method: str) -> Settings:
        """The settings of a method by name: those that were chosen, or its defaults."""
        chosen = dict(self.settings).get(method)
        made: Settings = CONTOUR_METHODS[method].defaults if chosen is None else chosen
        return made

    def with_settings(self, method: str, settings: Settings) -> Compared:
        """The comparison in which a method has these settings."""
        others = {name: one for name, one in self.settings if name != method}
        changed = others if settings == CONTOUR_METHODS[method].defaults else {**others, method: settings}
        return replace(self, settings=tuple(changed.items()))
