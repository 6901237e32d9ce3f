"""The float32 mirror of the block `softening`, in the order of operations of its generated C."""

from collections.abc import Mapping

import numpy as np

from hysgen.model.float32_arithmetic import accumulate, flushed, reciprocal
from hysgen.model.path.base import BlockMirror, Floats32, limited
from hysgen.model.path.channels import ChannelListener, Channels

SHARES = ("share", "quadrature", "swing", "swing_quadrature")


class SofteningMirror(ChannelListener, BlockMirror):
    """Float32 modes over lanes, position and velocity each a sum of two words."""

    def __init__(self, block: Channels, constants: Mapping[str, Floats32], u_V: Floats32) -> None:
        self.members = block.members()
        self.listen_to(block, constants, u_V.shape)
        modes = constants["real"].size
        parts = [constants[name].reshape(2, modes) for name in ("fall", "seen")]
        self._steps = list(zip(constants["real"], constants["imag"], *parts[0], strict=True))
        self._seen = list(zip(*parts[1], strict=True))
        self._shares, self._quadratures, self._swings, self._swings_across = (
            constants[name].reshape(modes, -1) for name in SHARES
        )
        self._rate, self._most = constants["of_amplitude"]
        self._keep, self._per_rate = constants["lag"]
        self._level = constants["level"][0]
        self.last = [flushed(u_V - self._level), *(np.zeros_like(u_V) for _ in block.channels)]
        self.position = [self._sum(row, self.last) for row in self._shares]
        self.velocity = [self._sum(row, self.last) for row in self._quadratures]
        self.position_low, self.velocity_low = ([np.zeros_like(u_V) for _ in self._steps] for _ in range(2))
        self.env = self._bounded(self._size())

    def rest(self) -> Floats32:
        return self._out(self._whole(self.position))

    def apply(self, u_V: Floats32) -> Floats32:
        v = [flushed(u_V - self._level), *(past[0] for past in self.sample)]
        ways = [flushed(now - last) for now, last in zip(v, self.last, strict=True)]
        before, self.env = self._whole(self.position), self._next_env()
        s = self._share_of(self.env)
        for m in range(len(self._steps)):
            forward, turn = self._moves(m, s, v, ways)
            self.position[m], self.position_low[m] = accumulate(self.position[m], self.position_low[m], forward)
            self.velocity[m], self.velocity_low[m] = accumulate(self.velocity[m], self.velocity_low[m], turn)
        self.last = v
        return self._out(before)

    def _moves(self, m: int, s: Floats32, v: list[Floats32], ways: list[Floats32]) -> tuple[Floats32, Floats32]:
        """What a sample adds to position and velocity of a mode."""
        real, imag, fall, fall_across = self._steps[m]
        real, imag = real - s * fall, imag - s * fall_across
        away = self._sum(self._shares[m], v) - self.position[m]
        across = self._sum(self._quadratures[m], v) - self.velocity[m]
        return (
            (real * away - imag * across) + s * self._sum(self._swings[m], ways),
            (imag * away + real * across) + s * self._sum(self._swings_across[m], ways),
        )

    def _size(self) -> Floats32:
        """|zeta|"""
        terms = [a * x - b * y for (a, b), x, y in zip(self._seen, self.position, self.velocity, strict=True)]
        zeta = self._whole(terms)
        return np.where(zeta < 0.0, -zeta, zeta)

    def _next_env(self) -> Floats32:
        return self._bounded(self.env + self._rate * (self._size() - self.env))

    def _bounded(self, env: Floats32) -> Floats32:
        return flushed(limited(env, np.float32(0.0), self._most))

    @staticmethod
    def _share_of(env: Floats32) -> Floats32:
        return flushed(env * reciprocal(np.float32(1.0) + env))

    def _out(self, before: Floats32) -> Floats32:
        return np.asarray(self._level + (self._whole(self.position) - self._keep * before) * self._per_rate)

    @staticmethod
    def _sum(weights: Floats32, values: list[Floats32]) -> Floats32:
        return SofteningMirror._whole([weight * value for weight, value in zip(weights, values, strict=True)])

    @staticmethod
    def _whole(terms: list[Floats32]) -> Floats32:
        total = terms[0]
        for term in terms[1:]:
            total = total + term
        return total
