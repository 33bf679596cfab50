"""The engine: one step of a run is the composition of motion, deletion, insertion and equilibrium.

``Engine(image, parameters)`` prepares what the particles feel; ``start`` makes the first state of a run; ``step`` makes
the next one from any state, without memory of its own, so that a run can be paused, steered, replayed and branched.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cpm_core.bridge import Bridge
from cpm_core.deletion import thinned
from cpm_core.dynamics import FADED
from cpm_core.enclosure import LAUNCHES, launch_places
from cpm_core.equilibrium import IDLE_STEPS, QUIET_STEPS, STILL, epsilon, is_idle, is_quiet
from cpm_core.ground import explore, idle_at, renewed, unvisited
from cpm_core.image import Image
from cpm_core.insertion import insertion, search_range
from cpm_core.level import Level
from cpm_core.levels import Levels
from cpm_core.motion import FAR_EVERY, Moved, far_force_for, move
from cpm_core.multiscale import shape_of_scale, to_image, to_scale
from cpm_core.neighbors import build_cells
from cpm_core.parameters import Parameters
from cpm_core.particles import Particles, State
from cpm_core.reconstruction import find_contours
from cpm_core.regions import Regions
from cpm_core.result import Result
from cpm_core.standing import Standing, seats

Array = NDArray[np.float64]
Index = NDArray[np.int64]

_STEPS_A_PIXEL = 2.0
"""Steps that a scale may take, for each pixel of the longest side: a front advances about two pixels a step."""

_FRONT, _LOOK_EVERY, _LOOK_IDLY = 20, 4, 8
"""Steps without new ground around it up to which a particle with an open side looks for places at every step, for a
front must not wait; how often others look, and how often ahead where nothing new has been found for longer."""

_LATE_EVERY, _COLD_EVERY = 2, 4
"""How often particles are deleted and inserted once next to no new ground is found, and once no repulsion is left."""

_UNDER_WAY, _PATIENCE = 0.3, 2
"""Part of the speed at which the field alone drives a particle above which one far from all ground counts as on its way
to some, and how many times as slowly it is then made to rest: it may have a long way to go."""

_CERTAIN = 1.25
"""How many times as strong as the weakest edge that counts one is that holds particles in any case."""

_LEAST_BETA = 0.1
"""Damping with which the speed is reckoned where there is none."""

_NOWHERE = -1
"""What stands for the idle steps of a particle far from all ground."""

_LEAST_STEPS = 400
"""Steps that a scale may take however small it is."""


class Engine:
    """The charged-particle model on one image.

    Parameters
    ----------
    values : array_like, shape (H, W), or Image
        Image.
    parameters : Parameters, optional
        For the number of scales, and the fields to prepare at once.
    regions : Regions, optional
        Regions of interest, which particles stay in, and barriers, which they do not cross; the whole image by default.

    Raises
    ------
    ValueError
        When the image has no edges in the regions of interest, or fewer scales than asked for.
    """

    def __init__(
        self, values: ArrayLike | Image, parameters: Parameters | None = None, regions: Regions | None = None
    ) -> None:
        parameters = parameters or Parameters()
        self.image = values if isinstance(values, Image) else Image(np.asarray(values, dtype=float))
        array = self.image.values
        if array.min() == array.max():
            raise ValueError(
                f"{self.image.source} is constant ({array.flat[0]:g} everywhere) and has no edges: "
                "open an image that shows something."
            )
        self.regions = regions
        if regions is not None:
            regions.check(array.shape)
        self._levels = Levels(array, parameters.scales, regions)
        self._levels.prepare(parameters)
        if regions is not None and not self.edge_map(parameters).any():
            raise ValueError("there are no edges in the regions of interest: draw them around what is to be found.")

    @property
    def scales(self) -> int:
        """Levels of the pyramid."""
        return len(self._levels)

    def level(self, parameters: Parameters, scale: int = 0) -> Level:
        """Fields of a scale, built when they are first asked for."""
        return self._levels.at(scale, parameters)

    def edge_map(self, parameters: Parameters, scale: int = 0) -> Array:
        """Edge map of a scale, shape (H, W), zero where the edge floor leaves no fixed charge."""
        return self.level(parameters, scale).charges

    def field(self, parameters: Parameters, scale: int = 0) -> Array:
        """Lorentz force on the pixels of a scale, shape (2, H, W): vectors of at most unit length."""
        return self.level(parameters, scale).lorentz.astype(float)

    def start(self, seeds: ArrayLike) -> State:
        """First state of a run.

        Parameters
        ----------
        seeds : array_like, shape (N, 2)
            Where the particles begin (row, col) [px]; those outside the image or the regions of interest, and those on
            a barrier, are left out.

        Returns
        -------
        State
            Particles at rest on the coarsest scale.

        Raises
        ------
        ValueError
            When there is no particle, or none inside the image and the regions of interest.
        """
        points = _starting_points(seeds, self.image.shape, self.regions)
        nobody = Particles.at_rest(points[:0])
        begun = State(nobody, points, self.image.shape, self.scales, unvisited(()), regions=self.regions)
        return self._enter(begun, self.scales - 1)

    def step(self, state: State, parameters: Parameters) -> State:
        """One time step.

        Parameters
        ----------
        state : State
            Any state of a run on this image.
        parameters : Parameters
            Obeyed at once, `scales` from the next start on. Other values than in the last step set particles that have
            come to rest going again.

        Returns
        -------
        State
            The next state: the same one if the run has stopped. A state of an engine with other regions goes on with
            the particles that lie in this one's.
        """
        if state.stop_reason:
            return state
        level = self.level(parameters, state.scale)
        if state.steering != parameters.steering or state.regions != self.regions:
            state = self._heated(state, parameters)
        idle = _idle(state, parameters)
        cold = not (idle < FADED).any()
        state, moved = self._move(state, idle, level, parameters)
        if len(state.particles):
            state = self._populate(state, moved, cold, level, parameters)
        return self._judge(state, level)

    def result(self, state: State, parameters: Parameters) -> Result:
        """Contours and figures of any state of a run.

        Parameters
        ----------
        state : State
            A state of a run on this image.
        parameters : Parameters
            For the reconstruction.

        Returns
        -------
        Result
            In px of the image.
        """
        scale, shape, level = state.scale, self.image.shape, self.level(parameters, state.scale)
        found, bridged = find_contours(state.particles.position, level, parameters, at_rest=state.converged)
        size = 2.0**scale
        contours = tuple(replace(c, points=to_image(c.points, scale, shape), strength=c.strength / size) for c in found)
        bridges = tuple(Bridge(to_image(b.points, scale, shape), b.length * size, b.strength / size) for b in bridged)
        return Result(
            particles=state.position,
            contours=contours,
            surface=None,
            steps=state.step,
            converged=state.converged,
            stop_reason=state.stop_reason,
            shape=shape,
            spacing=self.image.spacing,
            unit=self.image.unit,
            source=self.image.source,
            bridges=bridges,
        )

    def _heated(self, state: State, parameters: Parameters) -> State:
        """Set the particles going again under other parameters: what has come to rest must be able to obey them."""
        if state.regions != self.regions:
            allowed = _allowed(state.position, self.regions)
            state = replace(state, particles=state.particles.where(allowed), regions=self.regions)
        return replace(
            state,
            steering=parameters.steering,
            ground=renewed(state.ground, state.step_of_scale),
            annealed=1.0,
            heated=state.step_of_scale,
            idle=0,
            quiet=0,
            launches=0,
            far=None,
        )

    def _move(self, state: State, idle: Index, level: Level, parameters: Parameters) -> tuple[State, Moved]:
        """Force and motion, and removal of what leaves the image."""
        particles, step = state.particles, state.step_of_scale
        far = state.far
        if step % FAR_EVERY == 0 or far is None:
            far = far_force_for(particles, idle, level, parameters)
        moved = move(particles, idle, far, level, parameters)
        held = level.walls.held(particles, moved.particles)
        if held is not moved.particles:
            moved = moved.held_at(held, particles.position, level)
        inside = _inside(held.position, level.shape)
        left = len(held) - int(np.count_nonzero(inside))
        if left:
            moved = moved.where(inside)
        motion = moved.motion
        state = replace(
            state,
            particles=moved.particles,
            far=far,
            step=state.step + 1,
            step_of_scale=step + 1,
            born=0,
            deleted=left,
            displacement=float(motion.mean()) if len(motion) else float("nan"),
            moving=int(np.count_nonzero(motion > STILL)),
            epsilon=epsilon(moved.particles.distance),
        )
        return state, moved

    def _populate(self, state: State, moved: Moved, cold: bool, level: Level, parameters: Parameters) -> State:
        """Deletion, insertion and annealing; late in a run the first two only now and then."""
        annealed = state.annealed * parameters.annealing
        every = _COLD_EVERY if cold else _LATE_EVERY if state.idle >= IDLE_STEPS else 1
        if state.step % every:
            return replace(state, annealed=annealed, idle=state.idle + 1)
        particles, step, stirred = state.particles, state.step_of_scale, moved.motion > 0.0
        height, width = level.shape
        cells = build_cells(particles.position, height, width, search_range(parameters))
        standing = Standing(moved.strength, moved.seated, cells)
        kept = thinned(standing, stirred, parameters.d_min)
        ground, new = explore(state.ground, particles.position, standing.seated & kept, step)
        round_ = state.step // every
        turn = particles.identity + round_
        front = idle_at(ground, particles.position, step, state.idle) < _FRONT
        thorough = (turn % _LOOK_EVERY == 0) | particles.young | cold
        looking = (thorough | front) & stirred
        ahead = (turn % _LOOK_IDLY == 0) | front
        d_max = state.annealed * parameters.d_max
        births = insertion(standing, kept, looking, thorough, ahead, level, d_max, parameters, round_)
        born, deleted = len(births.position), len(kept) - int(np.count_nonzero(kept))
        if born:
            particles = particles.joined_by(births.position, births.parent, births.other, state.next_identity)
        if deleted:  # those who stay, in the order of their cells: what is near in space is then near in memory
            stay = standing.cells.order[kept[standing.cells.order]]
            particles = particles.taken(np.concatenate([stay, np.arange(len(kept), len(kept) + born)]))
        return replace(
            state,
            particles=particles,
            annealed=annealed,
            next_identity=state.next_identity + born,
            born=born,
            deleted=state.deleted + deleted,
            ground=ground,
            idle=state.idle + 1 if is_idle(new, ground.size) else 0,
        )

    def _judge(self, state: State, level: Level) -> State:
        """Rest, the way to the next scale, and the bound on steps."""
        quiet = is_quiet(state.epsilon, state.moving, state.born + state.deleted, state.count)
        state = replace(state, quiet=state.quiet + 1 if quiet else 0)
        most = max(_LEAST_STEPS, int(_STEPS_A_PIXEL * max(level.shape)))
        overdue = state.step_of_scale - state.heated >= most
        if state.scale > 0:
            if state.count == 0 or state.idle >= IDLE_STEPS or overdue:
                return self._enter(_settled(state, level), state.scale - 1)
            return state
        if state.count == 0:
            return state.stopped("all particles left the image")
        if state.quiet >= QUIET_STEPS:
            launched = _launched(state, level)
            if launched is not None:
                return launched
            reason = f"at rest: nothing has moved, appeared or vanished for {QUIET_STEPS} steps"
            return _without_stragglers(state, level).stopped(reason, True)
        if overdue:
            return state.stopped(f"not at rest after {most} steps at full size")
        return state

    def _enter(self, state: State, scale: int) -> State:
        """Begin a scale with what the coarser one found and with the drawing itself."""
        found = to_scale(to_image(state.particles.position, state.scale, state.shape), scale, state.shape)
        drawn = to_scale(state.start, scale, state.shape)
        shape = shape_of_scale(state.shape, scale)
        position = np.concatenate([found, drawn])
        position = position[_inside(position, shape)]
        position = position[_allowed(to_image(position, scale, state.shape), self.regions)]
        first = state.next_identity
        return replace(
            state,
            particles=Particles.at_rest(position, first),
            scale=scale,
            step_of_scale=0,
            next_identity=first + len(position),
            ground=unvisited(shape),
            annealed=1.0,
            heated=0,
            idle=0,
            quiet=0,
            launches=0,
            far=None,
            epsilon=float("nan"),
        )


def _idle(state: State, parameters: Parameters) -> Index:
    """Steps since there was new ground around each particle, as far as they make it rest."""
    particles = state.particles
    idle = idle_at(state.ground, particles.position, state.step_of_scale, _NOWHERE)
    away = idle == _NOWHERE
    if not away.any():
        return idle
    driven = parameters.w2 / max(parameters.beta, _LEAST_BETA)
    speed = np.einsum("ni,ni->n", particles.velocity, particles.velocity)
    under_way = state.idle // _PATIENCE if state.ground.size else 0  # the first to find anything may take all the time
    idle[away] = np.where(speed[away] > (_UNDER_WAY * driven) ** 2, under_way, state.idle)
    return idle


def _launched(state: State, level: Level) -> State | None:
    """Go on with particles beside enclosed boundaries that nobody has reached; None when nothing is missing."""
    if state.launches == LAUNCHES:
        return None
    places = launch_places(level, _settled(state, level).particles.position)
    if not len(places):
        return None
    state = _without_stragglers(state, level)  # else they would be set going again, and to no purpose
    return replace(
        state,
        particles=state.particles.with_more(places, state.next_identity),
        next_identity=state.next_identity + len(places),
        launches=state.launches + 1,
        born=state.born + len(places),
        annealed=1.0,
        heated=state.step_of_scale,
        idle=0,
        quiet=0,
    )


def _without_stragglers(state: State, level: Level) -> State:
    """Leave out the particles at rest that sit on no edge, if any have found one: nothing draws them on.

    In a hole of a pixel or two nobody sits in the strict sense, but the edge around is strong.
    """
    position = state.particles.position
    strength, seated = seats(position, level)
    found = seated | (strength >= _CERTAIN * level.floor)
    if found.all() or not found.any():
        return state
    return replace(state, particles=state.particles.where(found), deleted=state.deleted + int((~found).sum()))


def _settled(state: State, level: Level) -> State:
    """Leave out the particles that sit on no edge; a finer scale launches them anew from the drawing."""
    return replace(state, particles=state.particles.where(seats(state.particles.position, level)[1]))


def _starting_points(seeds: ArrayLike, shape: tuple[int, ...], regions: Regions | None) -> Array:
    """Check where particles are to start, and leave out those that may not be there."""
    points = np.asarray(seeds, dtype=float)
    if points.size == 0:
        raise ValueError("there are no particles to start with: draw a circle or click some points first.")
    if points.ndim != 2 or points.shape[1] != len(shape):
        raise ValueError(f"the starting particles have the shape {points.shape} but must be (N, {len(shape)}).")
    if not np.isfinite(points).all():
        wrong = int((~np.isfinite(points)).sum())
        raise ValueError(f"{wrong} coordinates of the starting particles are not finite: leave those particles out.")
    inside = _inside(points, shape)
    if not inside.any():
        size = " x ".join(map(str, shape))
        raise ValueError(
            f"none of the {len(points)} starting particles lies inside the image ({size} pixels): draw inside it."
        )
    points = points[inside]
    allowed = _allowed(points, regions)
    if not allowed.any():
        raise ValueError(
            f"none of the {len(points)} starting particles lies inside the regions of interest, clear of barriers: "
            "draw inside them."
        )
    return points[allowed]


def _inside(positions: Array, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Which positions lie on the image, its outermost pixels whole."""
    row, col = positions.T
    return np.asarray((row >= -0.5) & (row <= shape[0] - 0.5) & (col >= -0.5) & (col <= shape[1] - 0.5))


def _allowed(positions: Array, regions: Regions | None) -> NDArray[np.bool_]:
    """Which positions [px of the image] lie in the regions of interest and on no barrier."""
    return np.ones(len(positions), np.bool_) if regions is None else regions.allows(positions)
