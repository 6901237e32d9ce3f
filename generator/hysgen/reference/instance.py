"""The generated functions over lanes: each lane is one `<name>_t`, and a call steps all of them by one sample.

    y(k+1) = (y S + O + u G) / W + sum_j theta_j phi_j         predict (y measured), simulate (y the last output)
    u(k)   = ((y(k+1) - sum_j theta_j phi_j) W - (y S + O)) / G        inverse, Eq. (11)
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hysgen.coefficients import Bank, Coefficients, coefficients
from hysgen.model import Model
from hysgen.reference.arithmetic import Floats32, Words, bits_of, reciprocal
from hysgen.reference.rules import RuleSums, rule_sums
from hysgen.reference.safety import finite, limited, settled
from hysgen.status import COUNTERS, Status

_LAST = np.uint32(0xFFFFFFFF)


class Instance:
    """State of (lanes,) instances, initialised as `<name>_init(self, y_um, u_V)` does.

    y_um, u_V: last model output in um and last accepted input in V; status, counters: as in the C struct; bank: the
    active parameters, shared by all lanes; terms: the mirrors of the model's terms.
    """

    def __init__(self, model: Model, y_um: Floats32, u_V: Floats32) -> None:
        lanes = np.broadcast_shapes(np.shape(y_um), np.shape(u_V))
        self.numbers: Coefficients = coefficients(model)
        self.bank: Bank = self.numbers.bank
        self.status: Words = np.zeros(lanes, dtype=np.uint32)
        self.counters: dict[str, Words] = {name: np.zeros(lanes, dtype=np.uint32) for name in COUNTERS}
        self.y_um: Floats32 = np.full(lanes, self.numbers.rest_um)
        self.u_V: Floats32 = np.full(lanes, self.numbers.rest_V)
        self.y_um = self._checked_y(y_um)
        self.u_V = self._checked_u(u_V)
        self.terms = [term.mirror(self.u_V, model.Ts_s) for term in model.terms]

    def predict(self, y_um: Floats32, u_V: Floats32) -> Floats32:
        """One step from measured y(k) and u(k), (lanes,) each: y(k+1) in um, which is also kept."""
        y, u = self._checked_y(y_um), self._checked_u(u_V)
        for term in self.terms:
            term.correct(y - self.y_um)
        return self._step(y, u)

    def simulate(self, u_V: Floats32) -> Floats32:
        """One step of the free run from the last output under u(k), (lanes,): y(k+1) in um."""
        y, clamped = limited(self.y_um, self.numbers.y_min_um, self.numbers.y_max_um)
        self._count(Status.Y_CLAMPED, clamped)
        return self._step(y, self._checked_u(u_V))

    def inverse(self, y_um: Floats32, y_next_um: Floats32) -> Floats32:
        """u(k) in V that takes y(k) to y(k+1), (lanes,) each, limited to the input range; that input is applied."""
        numbers = self.numbers
        y = self._checked_y(y_um)
        reference, rejected = finite(y_next_um, y)
        reference, clamped = limited(reference, numbers.reference_min_um, numbers.reference_max_um)
        self._count(Status.Y_REJECTED, rejected)
        self._count(Status.Y_CLAMPED, clamped, flag=Status.REFERENCE_CLAMPED)
        sums, extra = rule_sums(numbers, self.bank, y), self._extra()
        wanted = reference if extra is None else reference - extra
        numerator = wanted * sums.weight - (y * sums.slope + sums.offset)
        u = settled(numerator * reciprocal(sums.gain))
        u, clamped = limited(u, numbers.u_min_V, numbers.u_max_V)
        self._count(Status.U_CLAMPED, clamped)
        self._count(None, clamped, flag=Status.UNREACHABLE)
        self._apply(sums, extra, y, u)
        return u

    def words(self) -> Mapping[str, Words]:
        """Every word of the C struct between `active` and `bank`, in its order; a term's are `terms[<its place>][i]`."""
        named: dict[str, Words] = {"y_um": bits_of(self.y_um), "u_V": bits_of(self.u_V), "status": self.status}
        named |= self.counters
        for place, term in enumerate(self.terms):
            named |= {f"terms[{place}][{i}]": word.view(np.uint32) for i, word in enumerate(term.state())}
        return named

    def _step(self, y: Floats32, u: Floats32) -> Floats32:
        return self._apply(rule_sums(self.numbers, self.bank, y), self._extra(), y, u)

    def _apply(self, sums: RuleSums, extra: Floats32 | None, y: Floats32, u: Floats32) -> Floats32:
        rules = ((y * sums.slope + sums.offset) + u * sums.gain) * reciprocal(sums.weight)
        self.y_um = settled(rules if extra is None else rules + extra)
        self.u_V = u
        for term in self.terms:
            term.advance(u)
        return self.y_um

    def _extra(self) -> Floats32 | None:
        """sum_j theta_j phi_j in the order of the weights; None without terms."""
        phi = [regressor for term in self.terms for regressor in term.regressors()]
        total: Floats32 | None = None
        for theta, regressor in zip(self.bank.weight, phi, strict=True):
            product = theta * regressor
            total = product if total is None else total + product
        return total

    def _checked_y(self, y_um: Floats32) -> Floats32:
        y, rejected = finite(y_um, self.y_um)
        y, clamped = limited(y, self.numbers.y_min_um, self.numbers.y_max_um)
        self._count(Status.Y_REJECTED, rejected)
        self._count(Status.Y_CLAMPED, clamped)
        return y

    def _checked_u(self, u_V: Floats32) -> Floats32:
        u, rejected = finite(u_V, self.u_V)
        u, clamped = limited(u, self.numbers.u_min_V, self.numbers.u_max_V)
        self._count(Status.U_REJECTED, rejected)
        self._count(Status.U_CLAMPED, clamped)
        return u

    def _count(self, counter: Status | None, happened: Words, flag: Status | None = None) -> None:
        """Set the flag and step the counter, which stops at its largest value, where `happened` is 1."""
        bit = flag if flag is not None else counter
        assert bit is not None
        self.status = self.status | happened * np.uint32(bit)
        for name, owner in COUNTERS.items():
            if owner is counter:
                count = self.counters[name]
                self.counters[name] = count + (happened & (count < _LAST))
