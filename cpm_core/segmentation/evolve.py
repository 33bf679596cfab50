"""A run step by step: an iterator over its states, whose parameters can be changed and which can be stopped."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields, replace
from functools import cached_property
from typing import Any, cast

from numpy.typing import ArrayLike

from cpm_core.contours.contour import Contour
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.image import drawing
from cpm_core.image.image import Image
from cpm_core.image.surface import Surface
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.model.state import State
from cpm_core.numerics.real_numbers import check_finite_number
from cpm_core.numerics.types import Array, record
from cpm_core.parameters import Parameters, choose_parameters
from cpm_core.parameters.formatting import format_choice, format_count, format_repr, quote_value
from cpm_core.results.result import Result
from cpm_core.segmentation.method import RUN_METHODS, Method

DEFAULT_METHOD = "cpm"
"""The method that this program uses unless another one is asked for."""


@record
class RunState(drawing.Pictured):
    """State of a run: its particles, and on demand its contours.

    Attributes
    ----------
    method : Method
        Method of the run.
    state : State
        All that the next step depends on.
    parameters : Parameters
        Those of the step that led here.

    Examples
    --------
    >>> run = cpm.evolve(cpm.example(), cpm.circle((32, 32), 8))
    >>> first = next(run)
    >>> first
    <RunState step 0, scale 2, 25 particles>
    >>> first.step, first.scale, first.count, first.position.shape
    (0, 2, 25, (25, 2))
    >>> for moment in run:
    ...     pass
    >>> moment.converged, moment.stop_reason.split(":")[0]
    (True, 'at rest')
    >>> len(moment.contours), moment.result.contours[0].closed, moment.surface
    (1, True, None)
    >>> axes = moment.plot()
    """

    method: Method[Any]
    state: State
    parameters: Parameters

    @property
    def step(self) -> int:
        """Number of steps so far."""
        return self.state.step

    @property
    def scale(self) -> int:
        """Scale of the image, 0 for the image itself; a run goes from coarse to fine."""
        return self.state.scale

    @property
    def count(self) -> int:
        """Number of particles."""
        return self.state.count

    @property
    def position(self) -> Array:
        """Positions of the particles, shape (N, D) [px of the image]."""
        return self.state.position

    @property
    def stop_reason(self) -> str:
        """Why the run ended, in words; empty while it continues."""
        return self.state.stop_reason

    @property
    def converged(self) -> bool:
        """Whether the particles came to rest."""
        return self.state.converged

    @cached_property
    def result(self) -> Result:
        """Result so far, reconstructed at the first access."""
        return cast("Result", self.method.result(self.state, self.parameters))

    @property
    def contours(self) -> tuple[Contour, ...]:
        """The contours that are reconstructed from the particles, at the first access."""
        return self.result.contours

    @property
    def surface(self) -> Surface | None:
        """The surface that is reconstructed from particles in a volume, at the first access; None in an image."""
        return self.result.surface

    def plot(self, ax: drawing.Axes | None = None, *, contours: bool = False, scale_bar: bool = True) -> drawing.Axes:
        """Draw the image with the particles by matplotlib; of a volume the surface. See `Result.plot`."""
        if contours or self.method.image.ndim == 3:
            return self.result.plot(ax, particles=True, contours=contours, scale_bar=scale_bar)
        ax = self.method.image.plot(ax, scale_bar=scale_bar)
        drawing.show_particles(ax, self.position)
        return ax

    def __repr__(self) -> str:
        return format_repr(
            "RunState", f"step {self.step}", f"scale {self.scale}", format_count(self.count, "particle"),
            self.stop_reason.partition(":")[0],
        )  # fmt: skip


class Evolution(Iterator[RunState]):
    """Iterator over the states of a run; made by `evolve`.

    The first is the start. Parameters, placed charges and the end can be set between two steps.

    Parameters
    ----------
    method : Method
        Method of the run.
    state : State
        The first state.
    parameters : Parameters
        For the first steps.
    max_steps : int, optional
        Greatest number of steps.
    charges : sequence of PlacedCharge
        For the first steps.

    Examples
    --------
    >>> run = cpm.evolve(cpm.example(), cpm.circle((32, 32), 8))
    >>> for moment in run:
    ...     if moment.step == 5:  # damp the rest of the run, and attract the particles to a place
    ...         run.update(beta=1.5)
    ...         run.charges = [cpm.PlacedCharge((32, 50), 1.0)]
    ...     if moment.step == 12:
    ...         run.stop()
    >>> run
    <Evolution disk, step 12, stopped, as requested>
    >>> run.moment.state.charges[0].strength, len(run.charges), run.parameters.beta
    (1.0, 1, 1.5)
    >>> run.result
    <Result disk, 1 contour (1 closed), 18 particles, stopped, as requested after 12 steps>
    """

    def __init__(
        self,
        method: Method[Any],
        state: State,
        parameters: Parameters,
        max_steps: int | None = None,
        charges: Sequence[PlacedCharge] = (),
    ) -> None:
        self._method = method
        self._moment = RunState(method, state, parameters)
        self._begun = False
        self._max_steps = max_steps
        self.parameters = parameters
        self.charges = charges
        """Placed charges of the next step."""

    @property
    def parameters(self) -> Parameters:
        """Parameters of the next step; another number of scales is not possible in a run."""
        return self._parameters

    @parameters.setter
    def parameters(self, given: Parameters | str) -> None:
        chosen = choose_parameters(given, self._moment.parameters)
        if not self._method.can_start(chosen):
            raise ValueError(
                f"scales is {chosen.scales} but must stay {self.parameters.scales} in a run: begin another."
            )
        self._parameters = chosen

    def update(self, **values: float | str) -> None:
        """Change parameters by name from the next step on, and keep all others; ValueError as for `Parameters`."""
        if unknown := sorted(values.keys() - {field.name for field in fields(Parameters)}):
            choice = format_choice(unknown[0], self._method.parameters)
            raise ValueError(f"{unknown[0]} is no parameter: choose {choice}")
        self.parameters = replace(self._parameters, **values)  # type: ignore[arg-type]

    @property
    def moment(self) -> RunState:
        """The newest state of the run; the first one before the iteration begins."""
        return self._moment

    @property
    def result(self) -> Result:
        """Result so far, with the present parameters for the contours."""
        return cast("Result", self._method.result(self._moment.state, self._parameters))

    def stop(self, reason: str = "stopped, as requested") -> None:
        """End the run: no step follows; `reason` becomes `Result.stop_reason`."""
        if not self._moment.stop_reason:
            self._moment = RunState(self._method, self._moment.state.stop(reason), self._parameters)

    def __next__(self) -> RunState:
        if not self._begun:
            self._begun = True
            return self._moment
        before = self._moment.state
        if before.stop_reason:
            raise StopIteration
        state = self._method.step(before, self._parameters, self.charges)
        if state.step == self._max_steps and not state.stop_reason:
            state = state.stop(f"stopped after {self._max_steps} steps, as requested")
        self._moment = RunState(self._method, state, self._parameters)
        return self._moment

    def __repr__(self) -> str:
        moment = self._moment
        reason = moment.stop_reason.partition(":")[0]
        return format_repr("Evolution", self._method.image.source, f"step {moment.step}", reason)


def evolve(
    values: ArrayLike | Image,
    seeds: ArrayLike,
    parameters: Parameters | str | None = None,
    *,
    max_steps: int | None = None,
    regions: AnyRegions | None = None,
    charges: Sequence[PlacedCharge] = (),
    method: str | Callable[..., Method[Any]] = DEFAULT_METHOD,
) -> Evolution:
    """Run step by step: iterate over the states of a run, from the start until the particles are at rest.

    Parameters
    ----------
    values, seeds, parameters, max_steps, regions, charges, method
        As for `segment`: an image of shape (H, W) and seeds of shape (N, 2), or a volume and seeds of shape (N, 3).

    Returns
    -------
    Evolution
        Yields a `RunState` at each step, the first being the start, with the particles and, computed on demand, the
        contours. `update` changes parameters at any time, `charges` can be set, and `stop` ends the run.

    Raises
    ------
    ValueError
        For an unusable image, seeds or parameters; the message says what to do.

    Examples
    --------
    >>> for moment in cpm.evolve(cpm.example(), cpm.circle((32, 32), 8)):
    ...     if moment.step % 80 == 0:
    ...         print(moment.step, moment.count, len(moment.contours))
    0 25 0
    80 81 1
    """
    if max_steps is not None:
        check_finite_number(
            "max_steps", max_steps, lambda count: count >= 1 and count == int(count), "at least 1, and whole"
        )
    chosen = choose_parameters(parameters, Parameters())
    run = _choose_method(method)(values, chosen, regions)
    return Evolution(run, run.start(seeds), chosen, max_steps, charges)


def _choose_method(given: str | Callable[..., Method[Any]]) -> Callable[..., Method[Any]]:
    """Return the method with a name, or the class that is given in its place; ValueError for anything else."""
    seeded = find_seeded_methods()
    found = seeded.get(given) if isinstance(given, str) else given
    if not callable(found):
        raise ValueError(f"method is {quote_value(given)} but must be a class, or {format_choice(str(given), seeded)}")
    return found


def find_seeded_methods() -> dict[str, type[Method[Any]]]:
    """Find the methods whose runs begin with seeds, by name; those that were registered, too."""
    return {name: method for name, method in RUN_METHODS.items() if method.seeded}


def segment(
    values: ArrayLike | Image,
    seeds: ArrayLike,
    parameters: Parameters | str | None = None,
    *,
    max_steps: int | None = None,
    regions: AnyRegions | None = None,
    charges: Sequence[PlacedCharge] = (),
    method: str | Callable[..., Method[Any]] = DEFAULT_METHOD,
    progress: Callable[[State], object] | None = None,
) -> Result:
    """Find the contours of objects by particles that flow from seeds to edges and along them, until equilibrium.

    Parameters
    ----------
    values : array_like, shape (H, W), or Image
        Image.
    seeds : array_like, shape (N, 2)
        Where particles start (row, col) [px]: `circle`, `uniform_grid`, `gradient_threshold`, or any points.
    parameters : Parameters or str, optional
        Values, or the name of one of `PRESETS`; the paper's defaults unless given.
    max_steps : int, optional
        Greatest number of steps.
    regions : Regions or VolumeRegions, optional
        Regions of interest, which particles stay in, and barriers, which they do not cross.
    charges : sequence of PlacedCharge
        Charges that attract or repel particles, in addition to the fixed charges of the edges.
    method : {"cpm", "published"} or class
        The model with what this program adds, or as published, which may go on until `max_steps`; or a class like that
        of `Method`, made with `values`, `parameters` and `regions`.
    progress : callable, optional
        Called with the `State` after every step; it may raise to stop.

    Returns
    -------
    Result
        Particles, contours through them, and the reason why the run ended.

    Raises
    ------
    ValueError
        For an unusable image, seeds or parameters; the message says what to do.

    Examples
    --------
    >>> result = cpm.segment(cpm.example("disk"), cpm.circle((32, 32), 8))
    >>> result
    <Result disk, 1 contour (1 closed), 81 particles, at rest after 103 steps>
    >>> round(result.contours[0].area), result.converged
    (1251, True)
    >>> cpm.segment(cpm.example("disk"), cpm.circle((32, 32), 8), cpm.Parameters(beta=0.6), max_steps=3).stop_reason
    'stopped after 3 steps, as requested'
    """
    run = evolve(values, seeds, parameters, max_steps=max_steps, regions=regions, charges=charges, method=method)
    next(run)
    for moment in run:
        if progress is not None:
            progress(moment.state)
    return run.result
