"""The float32 mirror of the path: the blocks of a model in series, the generated `<name>_inputs_...` functions.

    forward    v(k) = limiters and delay of u(k),   w(k) = responses of v(k), limited to the range of the rules
    inverse    w(k+n) of Eq. (11) -> limited -> responses solved, last to first -> limited to the allowed voltages
               -> limiters -> v(k+n), the command u(k) -> responses advanced by v -> w(k+n), which the rules take

n is the preview. The responses advance by the voltage that reaches the stage, and so the inverse does not accumulate
what limits or rounding leave. A fractional delay makes the voltage that arrives at k+n depend on the next command:
the stored responses are then one sample behind, advanced by what u(k) makes arrive at k+n-1, and the inverse solves
from a copy of them that is advanced by the v of the call before.

A limit leads the first modes that the inverse solves astray, by d from the state that was asked for:

    x*(k) = (w(k) - C (s(k) - d(k))) / D,   x(k) = x*(k) - calm sum of the velocities of d,   within the limits
    d(k+1) = A d(k) + B (x(k) - x*(k))

Solved from s itself, a limit would be a relay in the loop of a mode, which swings for ever between the limits. x* is
what would be asked for without limits; a force against the velocity takes energy out of d, limited or not, and what
y strays by is left to the lag of the rules.
"""

import copy
import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen.model.float32_arithmetic import flushed
from hysgen.model.part import Words
from hysgen.model.path.base import Bits, BlockMirror, Floats32, InputBlock, limited
from hysgen.model.path.modes import astray_members, straying
from hysgen.model.path.modes_mirror import ModesMirror
from hysgen.model.structs import MirroredStruct

Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class PathLimits:
    """Ranges of the command u and of the input w of the rules, and the tolerance of |w' - w| in the inverse."""

    u_min_V: np.float32
    u_max_V: np.float32
    w_min: np.float32
    w_max: np.float32
    w_tolerance: np.float32


@dataclass(frozen=True)
class PathInverse:
    """What the inverse of the path finds, (lanes,) each.

    u_V: command. w: input of the rules that follows, of the path without the responses that the inverse omits: fed back
    through Eq. (11), their ringing would drive the stage to its limits. u_clamped: v lay outside the allowed interval.
    unreachable: w lay outside its range, or a limit keeps the stage from it, now or by what it left. residual: w is
    missed by more than the tolerance although no limit acted. astray: what limits add to w.
    """

    u_V: Floats32
    w: Floats32
    u_clamped: Flags
    unreachable: Flags
    residual: Flags
    astray: Floats32


class ChainMirror(MirroredStruct):
    """The blocks in series over lanes, at rest under the commands u_V (lanes,); without blocks, w = v = u.

    v_V: the last voltage that reached the stage. rest: w at rest. astray_um: what limits add to y(k), whose wanted
    value was asked_um; without modes that stray 0.
    """

    asked_um: Floats32
    astray_um: Floats32
    astray_position: list[Floats32]
    astray_velocity: list[Floats32]

    def __init__(self, blocks: Sequence[InputBlock], u_V: Floats32, Ts_s: float, limits: PathLimits) -> None:
        self._limits = limits
        self.blocks: list[BlockMirror] = []
        self._limiters: list[BlockMirror] = []
        self._delays: list[BlockMirror] = []
        self._responses: list[BlockMirror] = []
        self._solves = [block.solves(Ts_s) for block in blocks if block.responds]
        stray = straying(blocks, Ts_s)
        self._strays: ModesMirror | None = None
        self.members = astray_members(stray)
        self._late: BlockMirror | None = None
        self.v_V = v = u_V
        for block in blocks:
            mirror = block.mirror(v, Ts_s)
            if block is stray and isinstance(mirror, ModesMirror):
                self._strays = mirror
            self.blocks.append(mirror)
            group = self._responses if block.responds else self._limiters if block.limits else self._delays
            group.append(mirror)
            self._late = mirror if block.interpolates else self._late
            v = flushed(mirror.rest()) if block.responds else mirror.rest()
            self.v_V = self.v_V if block.responds else v
        self.rest = self._inside(v)
        self.straighten()

    def listen(self, aux: Mapping[str, Floats32]) -> Bits | None:
        """The auxiliary channels of the blocks that read some, (lanes,) each. Returns bits for the status word."""
        heard = [bits for block in self.blocks if (bits := block.listen(aux)) is not None]
        return functools.reduce(np.bitwise_or, heard) if heard else None

    def apply(self, u_V: Floats32) -> Floats32:
        """w(k), (lanes,), of the commands u(k), (lanes,)."""
        v = u_V
        for block in (*self._limiters, *self._delays):
            v = block.apply(v)
        self.v_V = v
        self.straighten()
        return self._respond(self._responses, v)[0]

    def invert(self, w: Floats32, allowed_V: tuple[Floats32, Floats32] | None = None) -> PathInverse:
        """The command for which w, (lanes,), is the input of the rules `preview` samples later.

        allowed_V: ends of the interval to which the voltage v(k+n) is limited; default: the range of the command.
        """
        limits = self._limits
        responses = [_copied(block) for block in self._responses] if self._late else self._responses
        if self._late:
            self._respond(responses, self.v_V)
        wanted = self._inside(w) if responses else w
        beyond = ((w < limits.w_min) | (w > limits.w_max)) & bool(responses)
        solved, target = wanted, wanted
        strays, led, asked, calm = None, np.zeros_like(w), wanted, wanted
        if self._strays:
            strays = responses[self._responses.index(self._strays)]
            led = flushed(self._strays.moving(self.astray_position, self.astray_velocity))
        for mirror, solves in zip(reversed(responses), reversed(self._solves), strict=True):
            solved = flushed(mirror.solve(solved + led if mirror is strays else solved)) if solves else solved
            if mirror is strays and self._strays:
                asked, calm = solved, self._strays.calming(self.astray_velocity)
                solved = solved + calm
            target = target if solves else solved
        low_V, high_V = allowed_V or (limits.u_min_V, limits.u_max_V)
        allowed = limited(solved, low_V, high_V)
        v = allowed
        for block in self._limiters:
            v = block.apply(v)
        u = v
        for block in reversed(self._delays):
            u = block.command(u)
        self.v_V = v
        reached, met, entered = self._respond(responses, v, strays)
        if self._late and responses:
            self._respond(self._responses, self._late.arrived())
        clamped = (solved < low_V) | (solved > high_V)
        held = clamped | beyond | (v.view(np.uint32) != allowed.view(np.uint32))
        missed = (met - target > limits.w_tolerance) | (target - met > limits.w_tolerance)
        at_end = (v <= low_V) | (v >= high_V)
        missed &= bool(responses)
        followed = reached if all(self._solves) else self._inside(wanted + (met - target))
        excused = at_end | (led.view(np.uint32) != 0)
        if self._strays:
            off = np.where(held, entered - asked, calm)
            led = flushed((self._strays.direct * off + led) + (wanted - w))
            moved = self._strays.moved(self.astray_position, self.astray_velocity, off)
            self.astray_position, self.astray_velocity = moved
        return PathInverse(u, followed, clamped, held | (missed & excused), missed & ~(held | excused), led)

    def state(self) -> list[Words]:
        """Every 32-bit word of the C struct of the inputs, in its order; empty without blocks."""
        if not self.blocks:
            return []
        return [self.v_V, *super().state(), *(word for block in self.blocks for word in block.state())]

    def restore(self, words: Sequence[Bits]) -> None:
        """Set the state: the bits of every word in the order of `state`, (lanes,) each, for any number of lanes."""
        if not self.blocks:
            return
        self.v_V, first = words[0].view(np.float32), 1 + len(super().state())
        super().restore(words[1:first])
        for block in self.blocks:
            count = len(block.state())
            block.restore(words[first : first + count])
            first += count

    def straighten(self) -> None:
        """No limit has acted, as far as the inverse knows."""
        self.astray_um, self.asked_um = np.zeros_like(self.v_V), np.zeros_like(self.v_V)
        modes = self.members[2].sizes[0] if self.members else 0
        self.astray_position, self.astray_velocity = ([np.zeros_like(self.v_V)] * modes for _ in range(2))

    def _respond(
        self, responses: Sequence[BlockMirror], v_V: Floats32, strays: BlockMirror | None = None
    ) -> tuple[Floats32, Floats32, Floats32]:
        """w of the voltage v; the output that the inverse aims at, before the first response that it omits; and the
        input of the modes that stray."""
        w, met, entered = v_V, None, v_V
        for mirror, solves in zip(responses, self._solves, strict=True):
            met = w if met is None and not solves else met
            entered = w if mirror is strays else entered
            w = flushed(mirror.apply(w))
        w = self._inside(w) if responses else w
        return w, (w if met is None else met), entered

    def _inside(self, w: Floats32) -> Floats32:
        return limited(w, self._limits.w_min, self._limits.w_max)


def _copied(block: BlockMirror) -> BlockMirror:
    """A mirror with the same constants and a state of its own."""
    other = copy.copy(block)
    other.restore([word.copy().view(np.uint32) for word in block.state()])
    return other
