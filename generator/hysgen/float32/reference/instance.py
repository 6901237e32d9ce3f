"""The generated functions over lanes: each lane is one `<name>_t`; a call advances every lane by one sample.

y(k+1) = (y S + O + w G) / W + sum_j theta_j phi_j         predict (y measured), simulate (y the last output)
w(k)   = ((y(k+1) - sum_j theta_j phi_j) W - (y S + O)) / G        inverse, Eq. (11)

w is the command u behind the path (`ChainMirror`), u without one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hysgen.float32.coefficients import Bank, Coefficients, coefficients
from hysgen.float32.reference.rules import RuleSums, finite, limited, next_displacement, rule_sums, wanted_input
from hysgen.float32.struct_words import InstanceWords
from hysgen.model.disturbances import channels_of
from hysgen.model.float32_arithmetic import Floats32, Words, flushed
from hysgen.model.model import Model
from hysgen.model.path import preview
from hysgen.model.path.chain import ChainMirror, PathLimits
from hysgen.model.structs import Status

_LAST = np.uint32(0xFFFFFFFF)


class Instance(InstanceWords):
    """State of `lanes` instances, initialised like `<name>_init(self, y_um, u_V)`.

    bank: the active parameters, shared by all lanes; inputs, terms: the mirrors of the input blocks and of the terms.
    """

    def __init__(self, model: Model, y_um: Floats32, u_V: Floats32) -> None:
        self._model = model
        self.numbers: Coefficients = coefficients(model)
        self.bank: Bank = self.numbers.bank
        self.channels = channels_of(model.terms)
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

    def aux(self, values: Sequence[Floats32]) -> None:
        """Set the auxiliary channels of the next sample, (lanes,) each, in the order of `channels`."""
        named = dict(zip(self.channels, values, strict=True))
        for term in self.terms:
            bits = term.listen(named)
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
        found = self.inputs.invert(flushed(wanted_input(sums, y, wanted)), self._allowed())
        self.u_V = found.u_V
        self._count_event(Status.U_CLAMPED, found.u_clamped.astype(np.uint32))
        self._count_event(Status.UNREACHABLE, found.unreachable.astype(np.uint32))
        self._count_event(Status.INVERSE_RESIDUAL, found.residual.astype(np.uint32))
        self._apply(sums, extra, y, found.w)
        return self.u_V

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
