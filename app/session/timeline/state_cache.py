"""Cache of the states of a timeline: as many as memory allows, evenly spaced, and those used most recently."""

from __future__ import annotations

from cpm_core.segmentation.method import MethodState

Place = tuple[int, int]
"""Branch that owns a state, and its step."""

_RECENT_SHARE = 3
"""States on the grid for each one that is kept only because it was used recently."""


class KeptStates:
    """States by branch and step, of at most `budget` bytes, except that `fixed` states are always kept.

    States whose step is a multiple of the stride stay, so that every other state is a few steps from one of them. The
    states in between stay until a newer one needs their memory, so that single steps backward are fast. When the memory
    is full, the stride is doubled and every second state on the grid is removed. Arrays that several states share, such
    as the far force of some steps in a row, are counted once.
    """

    def __init__(self, budget: int) -> None:
        self.used = 0
        self.stride = 1
        self._budget = budget
        self._states: dict[Place, MethodState] = {}
        self._recent: dict[Place, None] = {}
        self._fixed: dict[str, Place] = {}
        self._shared: dict[int, int] = {}

    def __len__(self) -> int:
        return len(self._states)

    def __contains__(self, place: object) -> bool:
        return place in self._states

    def get(self, place: Place) -> MethodState | None:
        """The state of a place, or None if it is not kept."""
        state = self._states.get(place)
        if state is not None and place in self._recent:
            self._recent[place] = self._recent.pop(place)
        return state

    @property
    def budget(self) -> int:
        """Maximum number of bytes."""
        return self._budget

    @budget.setter
    def budget(self, budget: int) -> None:
        self._budget = budget
        self._make_room()

    def fix(self, role: str, place: Place) -> None:
        """Give a role, such as that of the current state, to a place; it is kept until another place has that role."""
        before = self._fixed.get(role)
        self._fixed[role] = place
        self._recent.pop(place, None)
        if before is not None and before != place and before in self._states and before not in self._fixed.values():
            self._file(before)

    def release(self, role: str) -> None:
        """No place has this role any more."""
        before = self._fixed.pop(role, None)
        if before is not None and before in self._states and before not in self._fixed.values():
            self._file(before)

    def drop_branch(self, branch: int) -> None:
        """Remove the states of a branch."""
        for place in [place for place in self._states if place[0] == branch]:
            self.drop(place)

    def put(self, place: Place, state: MethodState) -> None:
        """Keep a state in place of the one kept before."""
        self.drop(place)
        self._states[place] = state
        for array in state.arrays():
            key = id(array)
            owners = self._shared.get(key, 0)
            self._shared[key] = owners + 1
            if not owners:
                self.used += array.nbytes
        self._file(place)
        if self.used > self._budget:
            self._make_room()

    def drop(self, place: Place) -> None:
        """Remove a state."""
        state = self._states.pop(place, None)
        if state is None:
            return
        self._recent.pop(place, None)
        for array in state.arrays():
            owners = self._shared.pop(id(array)) - 1
            if owners:
                self._shared[id(array)] = owners
            else:
                self.used -= array.nbytes

    def hand_over(self, giver: int, taker: int, last: int) -> None:
        """Move the states of a branch up to a step to another branch, and remove those after it."""
        self._fixed = {role: (taker, at[1]) if at[0] == giver else at for role, at in self._fixed.items()}
        for place in [place for place in self._states if place[0] == giver]:
            state = self._states.get(place)
            self.drop(place)
            if state is not None and place[1] <= last and (taker, place[1]) not in self._states:
                self.put((taker, place[1]), state)

    def clear(self) -> None:
        """Remove all states and restore the finest stride."""
        for kept in (self._states, self._recent, self._fixed, self._shared):
            kept.clear()
        self.used, self.stride = 0, 1

    def _file(self, place: Place) -> None:
        """Put a place among those used recently, unless it is fixed or on the grid."""
        if place[1] % self.stride and place not in self._fixed.values():
            self._recent[place] = None
        else:
            self._recent.pop(place, None)

    def _make_room(self) -> None:
        while self.used > self._budget:
            gone = self._victims()
            if not gone:
                return
            for place in gone:
                self.drop(place)

    def _victims(self) -> list[Place]:
        """The next states to remove; none when all others are fixed."""
        fixed = set(self._fixed.values())
        recent = next((place for place in self._recent if place not in fixed), None)
        on_grid = len(self._states) - len(self._recent)
        if recent is not None and (_RECENT_SHARE * len(self._recent) > on_grid or on_grid <= len(fixed)):
            return [recent]
        if all(place in fixed or place in self._recent for place in self._states):
            return [] if recent is None else [recent]
        gone: list[Place] = []
        while not gone:
            self.stride *= 2
            gone = [
                place
                for place in self._states
                if place[1] % self.stride and place not in fixed and place not in self._recent
            ]
            if self.stride > max(step for _, step in self._states):
                gone = gone or [place for place in self._states if place not in fixed]
        return gone
