"""Modes in float32: mirror of the generated C, forward and inverse, and what a limit of the inverse leaves in them.

    c <- c + s (x - c),   w = direct x + sum_j (of_position_j position_j + of_velocity_j velocity_j)

The inverse solves w for x. What limits leave moves by the same recursion in one word, because it dies away.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from hysgen.model.float32_arithmetic import accumulate, inside
from hysgen.model.path.base import BlockMirror, Floats32, singles
from hysgen.model.structs import Member


class ModesMirror(BlockMirror):
    """Float32 modes over lanes, position and velocity each a sum of two words; w takes the higher words."""

    def __init__(self, members: tuple[Member, ...], constants: Mapping[str, Floats32], u_V: Floats32) -> None:
        self.members = members
        self._steps = list(zip(constants["real"], constants["imag"], strict=True))
        self._outputs = list(zip(constants["of_position"], constants["of_velocity"], strict=True))
        self.direct, self._rest = constants["direct"][0], u_V
        self._per_direct = constants["per_direct"][0] if "per_direct" in constants else None
        self._calm = constants.get("calm", singles(np.zeros(1)))
        self.position: list[Floats32] = [u_V.copy() for _ in self._steps]
        self.velocity: list[Floats32] = [np.zeros_like(u_V) for _ in self._steps]
        self.position_low: list[Floats32] = [np.zeros_like(u_V) for _ in self._steps]
        self.velocity_low: list[Floats32] = [np.zeros_like(u_V) for _ in self._steps]

    def rest(self) -> Floats32:
        return np.asarray(self.direct * self._rest + self.moving(self.position, self.velocity))

    def apply(self, u_V: Floats32) -> Floats32:
        w = np.asarray(self.direct * u_V + self.moving(self.position, self.velocity))
        for j, (real, imag) in enumerate(self._steps):
            position, velocity = self.position[j], self.velocity[j]
            away = u_V - position
            forward, turn = real * away + imag * velocity, imag * away - real * velocity
            self.position[j], self.position_low[j] = accumulate(position, self.position_low[j], forward)
            self.velocity[j], self.velocity_low[j] = accumulate(velocity, self.velocity_low[j], turn)
        return w

    def solve(self, wanted: Floats32) -> Floats32:
        if self._per_direct is None:
            return wanted
        return np.asarray((wanted - self.moving(self.position, self.velocity)) * self._per_direct)

    def moved(
        self, position: Sequence[Floats32], velocity: Sequence[Floats32], x: Floats32
    ) -> tuple[list[Floats32], list[Floats32]]:
        """Positions and velocities behind the input x, in one word each; beyond LIMIT they start again at 0."""
        moved = []
        for (real, imag), at, speed in zip(self._steps, position, velocity, strict=True):
            away = x - at
            moved.append((inside(at + (real * away + imag * speed)), inside(speed + (imag * away - real * speed))))
        return [at for at, _ in moved], [speed for _, speed in moved]

    def calming(self, velocity: Sequence[Floats32]) -> Floats32:
        """Input against the velocities, (lanes,)."""
        total = velocity[0]
        for further in velocity[1:]:
            total = total + further
        return np.asarray(total * self._calm[0])

    def moving(self, positions: Sequence[Floats32], velocities: Sequence[Floats32]) -> Floats32:
        """sum_j q_j (Re M_j position_j - Im M_j velocity_j)."""
        total: Floats32 | None = None
        for (of_position, of_velocity), position, velocity in zip(self._outputs, positions, velocities, strict=True):
            mode = of_position * position + of_velocity * velocity
            total = mode if total is None else total + mode
        assert total is not None
        return total
