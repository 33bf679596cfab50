"""Key states of a timeline: as many of them as the memory has room for, spread evenly, and the last ones used."""

from __future__ import annotations

from cpm_core.segmentation.method import MethodState

Place = tuple[int, int]
"""Branch that owns a state, and its step."""

_LATELY = 3
"""Key states on the grid for each that is kept only because it was used lately."""


class KeptStates:
    """States by branch and step within a number of bytes.

    States whose step is a multiple of the stride are kept for good, so that from one of them every other is a few steps
    away; those between only for as long as nothing newer wants their room, which makes single steps backwards cheap.
    When the room is used up the stride is doubled and every second state let go. Arrays that several states share, as
    the far force of some steps in a row, are counted once.

    Parameters
    ----------
    budget : int
        Most bytes to use; the states that are `fixed` are kept even where they take more.
    """

    def __init__(self, budget: int) -> None:
        self.used = 0
        self.stride = 1
        self._budget = budget
        self._states: dict[Place, MethodState] = {}
        self._lately: dict[Place, None] = {}
        self._fixed: dict[str, Place] = {}
        self._shared: dict[int, int] = {}

    def __len__(self) -> int:
        return len(self._states)

    def __contains__(self, place: object) -> bool:
        return place in self._states

    def get(self, place: Place) -> MethodState | None:
        """The state of a place, or None when it is not kept."""
        state = self._states.get(place)
        if state is not None and place in self._lately:
            self._lately[place] = self._lately.pop(place)
        return state

    @property
    def budget(self) -> int:
        """Most bytes to use."""
        return self._budget

    @budget.setter
    def budget(self, budget: int) -> None:
        self._budget = budget
        self._make_room()

    def fix(self, role: str, place: Place) -> None:
        """Let a place play a role, such as that of the newest state: it is kept until another one plays it."""
        before = self._fixed.get(role)
        self._fixed[role] = place
        self._lately.pop(place, None)
        if before is not None and before != place and before in self._states and before not in self._fixed.values():
            self._file(before)

    def put(self, place: Place, state: MethodState) -> None:
        """Keep a state, instead of what was kept of that place."""
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
        """Keep a state no longer."""
        state = self._states.pop(place, None)
        if state is None:
            return
        self._lately.pop(place, None)
        for array in state.arrays():
            owners = self._shared.pop(id(array)) - 1
            if owners:
                self._shared[id(array)] = owners
            else:
                self.used -= array.nbytes

    def hand_over(self, giver: int, taker: int, last: int) -> None:
        """Let another branch own the states of one up to a step, and drop those after it."""
        self._fixed = {role: (taker, at[1]) if at[0] == giver else at for role, at in self._fixed.items()}
        for place in [place for place in self._states if place[0] == giver]:
            state = self._states.get(place)
            self.drop(place)
            if state is not None and place[1] <= last and (taker, place[1]) not in self._states:
                self.put((taker, place[1]), state)

    def clear(self) -> None:
        """Keep nothing, and begin with the finest stride."""
        for kept in (self._states, self._lately, self._fixed, self._shared):
            kept.clear()
        self.used, self.stride = 0, 1

    def _file(self, place: Place) -> None:
        """Put a place among those used lately unless there is more reason to keep it."""
        if place[1] % self.stride and place not in self._fixed.values():
            self._lately[place] = None
        else:
            self._lately.pop(place, None)

    def _make_room(self) -> None:
        while self.used > self._budget:
            gone = self._victims()
            if not gone:
                return
            for place in gone:
                self.drop(place)

    def _victims(self) -> list[Place]:
        """The next states to let go, none when all the others are fixed."""
        fixed = set(self._fixed.values())
        lately = next((place for place in self._lately if place not in fixed), None)
        settled = len(self._states) - len(self._lately)
        if lately is not None and (_LATELY * len(self._lately) > settled or settled <= len(fixed)):
            return [lately]
        if all(place in fixed or place in self._lately for place in self._states):
            return [] if lately is None else [lately]
        gone: list[Place] = []
        while not gone:
            self.stride *= 2
            gone = [
                place
                for place in self._states
                if place[1] % self.stride and place not in fixed and place not in self._lately
            ]
            if self.stride > max(step for _, step in self._states):
                gone = gone or [place for place in self._states if place not in fixed]
        return gone
