"""The interface of an input block: float64 over a record, a float32 mirror, and its treatment in the inverse.

The command u passes through the blocks and arrives at the stage as v, the input of rules and terms:

    forward    v(k) = apply(u(k))          predict, simulate, learn
    inverse    Eq. (11) gives v(k); the limiters are applied to v(k), the terms advance by the limited v(k), and the
               other blocks compute the `command` for it, d samples ahead if they delay

The terms thus follow the limited input that reaches the stage (anti-windup), and a delay of d samples costs d samples
of preview: in the inverse every argument belongs to sample k + d, the result to sample k.
"""

import abc
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import ModelError
from hysgen.model.float32_arithmetic import LEAST
from hysgen.model.intervals import Interval
from hysgen.model.part import ModelPart
from hysgen.model.structs import MirroredStruct

Floats = NDArray[np.float64]
Floats32 = NDArray[np.float32]
Bits = NDArray[np.uint32]
StateSpace = tuple[Floats, Floats, Floats, float]
"""A (m, m), B (m,), C (m,) and D of s(k+1) = A s(k) + B x(k), w(k) = C s(k) + D x(k)."""

TOLERANCE: Final = 2.0**-20
"""Tolerance of the inverse of the path, as a share of the range of w: 1e-5 um of 10 um, 20 roundings of w."""


@dataclass(frozen=True)
class BlockBox:
    """What the C struct and the results of an input block never leave, as `InputBlock.box` gives it.

    floats: the interval of every float of the struct, by the C path of the float inside the struct (`ring[2]`).
    through: range of the output. solved: range of the input that the inverse finds, by `command` or `solve`; of a
    limiter, through. integers: the largest value of every integer that must not exceed a
    value, such as an index; an integer that is not named may have any value.
    """

    floats: Mapping[str, Interval]
    through: Interval
    solved: Interval
    integers: Mapping[str, int] = field(default_factory=dict)


def inverted(space: StateSpace) -> StateSpace:
    """The system from w to x; its poles are the zeros of the given one, whose D is not 0."""
    A, B, C, D = space
    return A - np.outer(B, C) / D, B / D, -C / D, 1.0 / D


def series(chain: Sequence[StateSpace]) -> StateSpace:
    """One system out of factors, each driven by the one before."""
    A, B, C, D = chain[0]
    for a, b, c, d in chain[1:]:
        A = np.block([[A, np.zeros((A.shape[0], a.shape[0]))], [np.outer(b, C), a]])
        B, C, D = np.concatenate([B, b * D]), np.concatenate([d * C, c]), d * D
    return A, B, C, D


class BlockMirror(MirroredStruct, abc.ABC):
    """The float32 reference of a block over `lanes` independent instances, in the generated C's order of operations."""

    @abc.abstractmethod
    def apply(self, u_V: Floats32) -> Floats32:
        """v(k) of the command u(k), (lanes,); moves the state by one sample."""

    @abc.abstractmethod
    def rest(self) -> Floats32:
        """Output at rest, (lanes,), as `_init` returns it: the input under which the next block rests.

        Valid until the first sample.
        """

    def listen(self, aux: Mapping[str, Floats32]) -> Bits | None:
        """The auxiliary channels of sample k, (lanes,) each. Returns the bits to set in the status word."""
        return None

    def solve(self, wanted: Floats32) -> Floats32:
        """Input, (lanes,), for which `apply` would return `wanted`; does not move the state.

        Called for responses of the stage only (`InputBlock.responds`).
        """
        raise NotImplementedError

    def command(self, v_V: Floats32) -> Floats32:
        """The command for which v arrives `preview` samples later, (lanes,); moves the state by one sample.

        Called for delays only.
        """
        raise NotImplementedError

    def arrived(self) -> Floats32:
        """What arrives one sample before v of the last `command`, (lanes,). Called where a block `interpolates`."""
        raise NotImplementedError


class InputBlock(ModelPart):
    """A block between the command and the stage.

    A kind is a frozen dataclass whose fields are the parameters. The defaults here are right for a stateless limiter
    whose parameters are not optimised, and C without constants.
    """

    limits: ClassVar[bool] = True
    """Whether the block is a limiter: its own output passes it unchanged, and the inverse applies it to v(k)."""
    responds: ClassVar[bool] = False
    """Whether the block is a response of the stage (hysteresis, creep, modes): the inverse solves it for its input."""

    def solves(self, Ts_s: float) -> bool:
        """Whether a response has a stable inverse (`BlockMirror.solve`); the inverse of the model omits it if not."""
        return True

    def zero(self, Ts_s: float) -> float:
        """Largest |eigenvalue| of the inverse of a linear response; 0 of a block whose inverse has no state."""
        return 0.0

    def state_space(self, Ts_s: float) -> StateSpace | None:
        """The block as a linear system from input to output; None of a block that is not one."""
        return None

    unit: ClassVar[str] = ""
    """Unit of the output; that of the input by default."""

    @property
    def preview(self) -> int:
        """Samples of preview that the inverse needs for this block."""
        return 0

    @property
    def interpolates(self) -> bool:
        """Whether v(k + preview) depends on the command u(k + 1) too, which `command` cannot know at sample k."""
        return False

    @abc.abstractmethod
    def describe(self) -> str:
        """One line of text: the parameters with units."""

    @abc.abstractmethod
    def apply(self, u_V: Floats, Ts_s: float, start: Floats | None = None) -> Floats:
        """Output (n,) of the inputs u_V (n,), in float64, from the state `start`, by default at rest under u(0)."""

    def driven(self, u_V: Floats, aux: Mapping[str, Floats] | None, Ts_s: float, start: Floats | None = None) -> Floats:
        """`apply` beside the auxiliary channels of a block that has some; None: every channel at its middle."""
        return self.apply(u_V, Ts_s, start)

    def linear_part(self, u_V: Floats, Ts_s: float) -> Floats:
        """(n,) output of the block where it is linear; by default `apply`, from rest under u(0)."""
        return self.apply(u_V, Ts_s)

    def added_um(self, u_V: Floats, aux: Mapping[str, Floats], Ts_s: float) -> Floats | float:
        """(n,) displacement that the block adds to its linear part, at the gain of its identification, under u_V."""
        return 0.0

    def free_responses(self, t_s: Floats) -> list[Floats]:
        """Courses of unit size, (n,) each, by which a state from before the record fades; t_s: (n,) since its start."""
        return []

    def image(self, u_V: Interval) -> Interval:
        """Range of the output for inputs in u_V."""
        return u_V

    def box(self, u_V: Interval, Ts_s: float) -> BlockBox:
        """What the struct of the generated C never leaves while the input of the block stays in u_V:

            x(k) in box, u(k) in u_V   =>   x(k+1) in box,   v(k) in through

        in float32, for the state `_init` leaves under any u in u_V and after every later call. The proof of the
        generated C assumes the box before a call and demands the box after the call, and uses an interval of every
        number but no relation between numbers: so a bound has to be as wide as intervals of each operation make it.

        Raises ModelError if the kind gives no box.
        """
        raise ModelError(f"blocks: {self.kind}: gives no box of its state; write box() in the file of the block")

    @abc.abstractmethod
    def mirror(self, u_V: Floats32, Ts_s: float) -> BlockMirror:
        """The float32 reference, at rest under u_V (lanes,), as the generated `_init` leaves it."""


def limited(value: Floats32, low: Floats32 | np.float32, high: Floats32 | np.float32) -> Floats32:
    """`value` between low and high over lanes."""
    return np.where(value < low, low, np.where(value > high, high, value))


def singles(values: Floats) -> Floats32:
    """`values` as float32; magnitudes below LEAST become zero, so that no product with a state is denormal."""
    return np.where(np.abs(values) < LEAST, 0.0, values).astype(np.float32)
