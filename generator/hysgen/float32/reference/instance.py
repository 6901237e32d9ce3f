"""The generated functions over lanes: each lane is one `<name>_t`; a call advances every lane by one sample.

y(k+1) = (y S + O + w G) / W + sum_j theta_j phi_j         predict (y measured), simulate (y the last output)
w(k)   = ((y(k+1) - sum_j theta_j phi_j) W - (y S + O)) / G        inverse, Eq. (11)

w is the command u behind the path (`ChainMirror`), u without one. Input checks and the sums over the rules, with one
exponential per sample, come first:

S(y) = sum_l v_l q_l1,   O(y) = sum_l v_l q_l3,   G(y) = sum_l v_l q_l2,   W(y) = sum_l v_l,   p_l = v_l / W
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np

from hysgen.float32.coefficients import WINDOW, Bank, Coefficients, coefficients
from hysgen.float32.struct_words import InstanceWords
from hysgen.model.feedback import FeedbackMirror
from hysgen.model.float32_arithmetic import (
    INFINITY_BITS,
    LEAST_BITS,
    MAGNITUDE_BITS,
    Floats32,
    Words,
    bits_of,
    float_of,
    flushed,
    inside,
    nearest,
    power_of_two,
    reciprocal,
)
from hysgen.model.model import Model
from hysgen.model.path import preview
from hysgen.model.path.chain import ChainMirror, PathLimits
from hysgen.model.structs import Status

_ONE = np.float32(1.0)


@dataclass(frozen=True)
class RuleSums:
    """S [1], O [um], G [um/V] and W [1] as slope, offset, gain and weight, (lanes,) each."""

    slope: Floats32
    offset: Floats32
    gain: Floats32
    weight: Floats32


def rule_sums(numbers: Coefficients, bank: Bank, y_um: Floats32) -> RuleSums:
    """S, O, G, W of `bank` at y_um, (lanes,), within the displacement range."""
    if numbers.windowed:
        first, strengths = window(numbers, y_um)
        return RuleSums(
            slope=pairwise([v * bank.slope[first + np.uint32(j)] for j, v in enumerate(strengths)]),
            offset=pairwise([v * bank.offset[first + np.uint32(j)] for j, v in enumerate(strengths)]),
            gain=pairwise([v * bank.gain[first + np.uint32(j)] for j, v in enumerate(strengths)]),
            weight=pairwise([v * numbers.present[first + np.uint32(j)] for j, v in enumerate(strengths)]),
        )
    r = ratio(numbers, y_um)
    return RuleSums(
        slope=polynomial(bank.slope, r),
        offset=polynomial(bank.offset, r),
        gain=polynomial(bank.gain, r),
        weight=polynomial(numbers.strength, r),
    )


def next_displacement(sums: RuleSums, y_um: Floats32, w: Floats32) -> Floats32:
    """y(k+1) of the rules, (y S + O + w G) / W, (lanes,)."""
    return ((y_um * sums.slope + sums.offset) + w * sums.gain) * reciprocal(sums.weight)


def wanted_input(sums: RuleSums, y_um: Floats32, y_next_um: Floats32) -> Floats32:
    """The w that takes y to y(k+1), Eq. (11): (y(k+1) W - (y S + O)) / G, (lanes,)."""
    return (y_next_um * sums.weight - (y_um * sums.slope + sums.offset)) * reciprocal(sums.gain)


def ratio(numbers: Coefficients, y_um: Floats32) -> Floats32:
    """r = exp((y - middle)/h) of the dense layout, (lanes,); v_l = w_l r^l."""
    return power_of_two((y_um - numbers.origin_um) * numbers.per_step)


def window(numbers: Coefficients, y_um: Floats32) -> tuple[Words, list[Floats32]]:
    """Index n of the nearest rule, (lanes,), and v_j = w_j r^j of rows n .. n + 10 of the padded tables."""
    rule, t = nearest((y_um - numbers.origin_um) * numbers.per_step)
    r = powers(power_of_two(t * numbers.octaves), WINDOW)
    return rule, [w * power for w, power in zip(numbers.strength, r, strict=True)]


def strengths(numbers: Coefficients, y_um: Floats32) -> list[Floats32]:
    """v_l = w_l r^l of the dense layout, (lanes,) for each rule."""
    r = powers(ratio(numbers, y_um), numbers.rules)
    return [w * power for w, power in zip(numbers.strength, r, strict=True)]


def powers(r: Floats32, count: int) -> list[Floats32]:
    """r^0 .. r^(count-1) by r^k = r^(k//2) r^(k - k//2), the fewest multiplications in sequence."""
    values = [np.full_like(r, _ONE), r]
    for k in range(2, count):
        values.append(values[k // 2] * values[k - k // 2])
    return values[:count]


def polynomial(c: Floats32, r: Floats32) -> Floats32:
    """sum_k c_k r^k by Estrin's scheme: neighbours combine as a + b r, the results with r^2, then r^4, and so on."""
    parts: list[Floats32 | np.float32] = list(c)
    power = r
    while len(parts) > 1:
        joined = [parts[k] + parts[k + 1] * power for k in range(0, len(parts) - 1, 2)]
        parts = [*joined, *parts[2 * len(joined) :]]
        power = power * power
    return cast("Floats32", parts[0])


def pairwise(parts: list[Floats32]) -> Floats32:
    """The sum of `parts` by pairwise summation, in the order of the generated C."""
    while len(parts) > 1:
        joined = [parts[k] + parts[k + 1] for k in range(0, len(parts) - 1, 2)]
        parts = [*joined, *parts[2 * len(joined) :]]
    return parts[0]


def finite(x: Floats32, held: Floats32) -> tuple[Floats32, Words]:
    """`x` where it is finite, `held` where it is NaN or infinite; magnitudes below 2^-40 become +0.

    Returns the numbers, and 1 where `x` was replaced by `held`, else 0. The bit patterns are compared, not the floats,
    so that no float comparison has a NaN operand.
    """
    magnitude = bits_of(x) & np.uint32(MAGNITUDE_BITS)
    rejected = magnitude >= np.uint32(INFINITY_BITS)
    chosen = np.where(magnitude < LEAST_BITS, np.uint32(0), bits_of(x))
    return float_of(np.where(rejected, bits_of(held), chosen)), rejected.astype(np.uint32)


def limited(x: Floats32, low: Floats32 | np.float32, high: Floats32 | np.float32) -> tuple[Floats32, Words]:
    """`x` limited to [low, high], and 1 where the limit changed it, else 0."""
    below, above = x < low, x > high
    return np.where(below, low, np.where(above, high, x)), (below | above).astype(np.uint32)


_LAST = np.uint32(0xFFFFFFFF)


class Instance(InstanceWords):
    """State of `lanes` instances, initialised like `<name>_init(self, y_um, u_V)`.

    bank: the active parameters, shared by all lanes; inputs, terms: the mirrors of the input blocks and of the terms.
    """

    def __init__(self, model: Model, y_um: Floats32, u_V: Floats32) -> None:
        self._model = model
        self.numbers: Coefficients = coefficients(model)
        self.bank: Bank = self.numbers.bank
        self.channels = model.channels
        self.init(y_um, u_V)

    def init(self, y_um: Floats32, u_V: Floats32) -> None:
        """Initialise at y_um and u_V, (lanes,) each; numbers that are not finite are replaced by rest_um and rest_V."""
        lanes = np.broadcast_shapes(np.shape(y_um), np.shape(u_V))
        self.status = np.zeros(lanes, dtype=np.uint32)
        self.counters = {name: np.zeros(lanes, dtype=np.uint32) for name in self.COUNTERS}
        self.y_um = np.full(lanes, self.numbers.rest_um)
        self.u_V = np.full(lanes, self.numbers.rest_V)
        self.y_um, self.u_V = self._checked_y(y_um), self._checked_u(u_V)
        self.low_V, self.high_V = np.full(lanes, self.numbers.u_min_V), np.full(lanes, self.numbers.u_max_V)
        self.step_V = np.full(lanes, self.numbers.u_step_max_V)
        self.inputs = ChainMirror(self._model.blocks, self.u_V, self._model.Ts_s, self._limits())
        self.terms = [term.mirror(self.inputs.rest.size, self._model.Ts_s) for term in self._model.terms]
        self.loop = FeedbackMirror(self._model.feedback, self.inputs.rest.size, self._model.Ts_s)

    def aux(self, values: Sequence[Floats32]) -> None:
        """Set the auxiliary channels of the next sample, (lanes,) each, in the order of `channels`."""
        named = dict(zip(self.channels, values, strict=True))
        for bits in (*(term.listen(named) for term in self.terms), self.inputs.listen(named)):
            if bits is not None:
                self.status = self.status | bits

    def limits(self, low_V: Floats32, high_V: Floats32, step_V: Floats32) -> None:
        """Limit the voltage of the inverse to low_V .. high_V and its change per sample to step_V, (lanes,) each, in V.

        Numbers that are not finite are replaced by the limits that `init` sets; the limits never exceed these.
        """
        numbers = self.numbers
        low, high, step = (
            finite(number, np.full(self.low_V.shape, held))[0]
            for number, held in ((low_V, numbers.u_min_V), (high_V, numbers.u_max_V), (step_V, numbers.u_step_max_V))
        )
        self.low_V, _ = limited(low, numbers.u_min_V, numbers.u_max_V)
        self.high_V, _ = limited(high, self.low_V, numbers.u_max_V)
        self.step_V, _ = limited(step, np.float32(0.0), numbers.u_step_max_V)

    def predict(self, y_um: Floats32, u_V: Floats32) -> Floats32:
        """One step from the measured y(k) [um] and u(k) [V], (lanes,) each; returns and stores y(k+1) [um]."""
        y, u = self._checked_y(y_um), self._checked_u(u_V)
        for term in self.terms:
            term.correct(y - self.y_um)
        return self._forward(y, u)

    def simulate(self, u_V: Floats32) -> Floats32:
        """One step of the free run from the stored output, with u(k) [V], (lanes,); returns and stores y(k+1) [um]."""
        y, clamped = limited(self.y_um, self.numbers.y_min_um, self.numbers.y_max_um)
        self._count_event(Status.Y_CLAMPED, clamped)
        return self._forward(y, self._checked_u(u_V))

    def inverse(self, y_um: Floats32, y_next_um: Floats32) -> Floats32:
        """u(k) [V] that moves y(k) to y(k+1) [um], (lanes,) each, within the limits of range and input blocks.

        The state advances by one sample with the returned u(k). In a model with a delay, y and y_next belong to the
        sample that is `preview` samples after that of the returned input.
        """
        numbers = self.numbers
        held, rejected = finite(y_um, self.y_um)
        y, clamped = limited(held, numbers.y_min_um, numbers.y_max_um)
        reference, refused = finite(y_next_um, y)
        reference, cut = limited(reference, numbers.reference_min_um, numbers.reference_max_um)
        self._count_event(Status.Y_CLAMPED, clamped)
        self._count_event(Status.Y_REJECTED, rejected | refused)
        self._count_event(Status.REFERENCE_CLAMPED, cut)
        sums, extra = rule_sums(numbers, self.bank, y), self._extra(preview(self._model.blocks))
        wanted = reference if extra is None else reference - extra
        strays, led_um, start = bool(self.inputs.members), self.inputs.astray_um, y
        if strays:
            # Where a limit led the model astray, it goes on from where it was asked to be.
            start = np.where(bits_of(led_um) != 0, self.inputs.asked_um, y)
        inverted = self.inputs.invert(flushed(wanted_input(sums, start, wanted)), self._allowed())
        if strays:
            moved = (sums.slope * led_um + sums.gain * inverted.astray) * reciprocal(sums.weight)
            self.inputs.astray_um = inside(moved)
            self.inputs.asked_um = np.where(bits_of(self.inputs.astray_um) != 0, reference, np.float32(0.0))
        self.u_V = inverted.u_V
        self._count_event(Status.U_CLAMPED, inverted.u_clamped.astype(np.uint32))
        self._count_event(Status.UNREACHABLE, inverted.unreachable.astype(np.uint32))
        self._count_event(Status.INVERSE_RESIDUAL, inverted.residual.astype(np.uint32))
        self._apply(sums, extra, y, inverted.w)
        return self.u_V

    def correct(self, residual_um: Floats32) -> Floats32:
        """Correction c(k) [um], (lanes,), for the residual [um], (lanes,): reference less reading."""
        reach = self.numbers.reach_um
        held, rejected = finite(residual_um, np.zeros_like(self.y_um))
        residual, clamped = limited(held, -reach, reach)
        self._count_event(Status.Y_REJECTED, rejected)
        self._count_event(Status.Y_CLAMPED, clamped)
        ends = (self.u_V >= self.high_V).astype(np.uint32), (self.u_V <= self.low_V).astype(np.uint32)
        return self.loop.apply(residual, *(ends if self._model.rises else ends[::-1]))

    def _forward(self, y: Floats32, u: Floats32) -> Floats32:
        self.u_V = u
        w = self.inputs.apply(u)
        return self._apply(rule_sums(self.numbers, self.bank, y), self._extra(), y, w)

    def _allowed(self) -> tuple[Floats32, Floats32]:
        """Ends of the interval of voltages, (lanes,) each in V, that the limits of the inverse allow at this sample."""
        last_V = self.inputs.v_V if self._model.blocks else self.u_V
        lowest_V, _ = limited(last_V - self.step_V, self.low_V, self.high_V)
        highest_V, _ = limited(last_V + self.step_V, self.low_V, self.high_V)
        return lowest_V, highest_V

    def _limits(self) -> PathLimits:
        numbers = self.numbers
        return PathLimits(numbers.u_min_V, numbers.u_max_V, numbers.w_min, numbers.w_max, numbers.w_tolerance)

    def _apply(self, sums: RuleSums, extra: Floats32 | None, y: Floats32, w: Floats32) -> Floats32:
        rules = next_displacement(sums, y, w)
        self.y_um = flushed(rules if extra is None else rules + extra)
        for term in self.terms:
            term.advance()
        return self.y_um

    def _extra(self, ahead: int = 0) -> Floats32 | None:
        """sum_j theta_j phi_j(k + ahead) [um], summed in the order of the weights; None without terms."""
        phi = [regressor for term in self.terms for regressor in term.regressors_ahead(ahead)]
        total: Floats32 | None = None
        for theta, regressor in zip(self.bank.weight, phi, strict=True):
            product = theta * regressor
            total = product if total is None else total + product
        return total

    def _checked_y(self, y_um: Floats32) -> Floats32:
        y, rejected = finite(y_um, self.y_um)
        y, clamped = limited(y, self.numbers.y_min_um, self.numbers.y_max_um)
        self._count_event(Status.Y_REJECTED, rejected)
        self._count_event(Status.Y_CLAMPED, clamped)
        return y

    def _checked_u(self, u_V: Floats32) -> Floats32:
        u, rejected = finite(u_V, self.u_V)
        u, clamped = limited(u, self.numbers.u_min_V, self.numbers.u_max_V)
        self._count_event(Status.U_REJECTED, rejected)
        self._count_event(Status.U_CLAMPED, clamped)
        return u

    def _count_event(self, event: Status, happened: Words) -> None:
        """Set the status bit of `event` and increment its counter, if any, where `happened` is 1; counters saturate."""
        self.status = self.status | happened * np.uint32(event)
        for name, counter in self.COUNTERS.items():
            if counter.flag == event:
                count = self.counters[name]
                self.counters[name] = count + (happened & (count < _LAST))
