"""Softening: the table rides on a mode whose spring yields, element by element, as Iwan's."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hysgen_lab.stage.effects.base import Action, Effect, require, require_finite

ELEMENTS, TURN_STEPS = 24, 400  # Jenkins elements; steps in a period of the mode, for 1e-4 of its frequency


@dataclass(frozen=True)
class SofteningEffect(Effect):
    """A mode at f_Hz for small amplitudes, of whose stiffness the share `yielding` slips in stops up to yield_V wide.

    x'' + 2 zeta w x' + w^2 ((1 - yielding) x + yielding mean_i f_i) = w^2 u,   f_i = clamp(f_i + dx, -r_i, r_i)

    r_i uniform to yield_V; x is the voltage that the stage is given in place of u. Source: Iwan, J. Appl. Mech. (1966).
    """

    f_Hz: float
    zeta: float
    yielding: float
    yield_V: float

    name = "softening"
    rank = 17

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.f_Hz > 0 and self.yield_V > 0, "softening: give a frequency and a yield voltage above 0")
        require(0 < self.zeta < 1 and 0 < self.yielding < 1, "softening: zeta and yielding must be shares")

    def action(self, Ts_s: float, seed: int, rest_V: float) -> Action:
        return _YieldingMode(self, Ts_s, rest_V)


class _YieldingMode(Action):
    """The mode under a held voltage, by symplectic Euler steps from rest."""

    def __init__(self, effect: SofteningEffect, Ts_s: float, rest_V: float) -> None:
        self.effect, self.rest_V, self.w = effect, rest_V, 2.0 * math.pi * effect.f_Hz
        self.steps = max(1, math.ceil(TURN_STEPS * effect.f_Hz * Ts_s))
        self.h_s, self.x, self.speed = Ts_s / self.steps, 0.0, 0.0
        self.reach = effect.yield_V * (np.arange(ELEMENTS) + 0.5) / ELEMENTS
        self.force = np.zeros(ELEMENTS)

    def command_V(self, u_V: float) -> float:
        moved_V, soft = self.rest_V + self.x, self.effect.yielding
        for _ in range(self.steps):
            spring = (1.0 - soft) * self.x + soft * float(self.force.mean())
            pull = self.w**2 * (u_V - self.rest_V - spring) - 2.0 * self.effect.zeta * self.w * self.speed
            self.speed += self.h_s * pull
            self.x += self.h_s * self.speed
            self.force = np.clip(self.force + self.h_s * self.speed, -self.reach, self.reach)
        return moved_V


EFFECT = SofteningEffect
