"""The learner over lanes: each lane is one `<name>_learner_t`; `learn` advances every lane by one sample.

    theta <- theta + P x (y - x' theta)/alpha,   P <- (P - P x x' P/alpha)/lambda,   alpha = 1 + x' P x

Eq. (10) with the division P/lambda before the update instead of after it, in the factors P = U D U', U unit upper
triangular, D > 0, with the outlier gate, limits and restarts of docs/learning.md. Source: Bierman (1977), chapter V.

    f = U' x,  g = D f,  alpha_j = alpha_(j-1) + f_j g_j,  alpha_(-1) = 1,  D_j <- D_j alpha_(j-1)/alpha_j
    U_ij <- U_ij - k_i f_j/alpha_(j-1),   k_i <- k_i + U_ij g_j   over i < j with the old U_ij, k_j = g_j;   P x = k

Matrices are (n, n, lanes), vectors (n, lanes). Sums run in ascending order; arguments are not modified. First stands
the state: initialisation (`<name>_learn_init`), restart, status bits and counters.
"""

import copy
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.float32.learner_numbers import (
    FACTOR_GRID,
    FAST,
    GAIN_GRID,
    LEAST_VARIANCE,
    REGRESSOR_GRID,
    SLOW,
    STEP_GRID,
    LearnerNumbers,
    learner_numbers,
)
from hysgen.float32.reference.instance import Instance, finite, limited, polynomial, powers, ratio, rule_sums
from hysgen.float32.struct_words import Holds, LearnerWords, Restart, Start
from hysgen.model.float32_arithmetic import MAGNITUDE_BITS, ROUNDING, Floats32, bits_of, float_of, flushed, reciprocal
from hysgen.model.model import Model

Mask = NDArray[np.bool_]

LAST = np.uint32(0xFFFFFFFF)
"""Largest value of a counter."""
_ZERO, _ONE, _TWO, _FOUR = (np.float32(value) for value in (0.0, 1.0, 2.0, 4.0))
_FAST, _SLOW, _LEAST_VARIANCE = np.float32(FAST), np.float32(SLOW), np.float32(LEAST_VARIANCE)
_LEVEL_ALPHA, _DEAD_ZONE_ALPHA = np.float32(2.0), np.float32(1.25)


def project(u: Floats32, x: Floats32) -> Floats32:
    """f_j = sum_{i<j} U_ij x_i + x_j; each sum starts at 0 and ends with x_j."""
    f = np.zeros_like(x)
    for i in range(len(x)):
        f[i] = f[i] + x[i]
        f[i + 1 :] = f[i + 1 :] + u[i, i + 1 :] * x[i]
    return f


def denominators(f: Floats32, g: Floats32) -> Floats32:
    """alpha_0 .. alpha_(n-1), (n, lanes); alpha_(n-1) = 1 + x' P x."""
    alpha = np.empty_like(f)
    before = np.ones(f.shape[1], np.float32)
    for j in range(len(f)):
        before = before + f[j] * g[j]
        alpha[j] = before
    return alpha


def quotients(f: Floats32, alpha: Floats32) -> tuple[Floats32, Floats32, Floats32]:
    """l_j = -f_j/alpha_(j-1), (n, lanes); alpha_(j-1)/alpha_j, (n, lanes); 1/alpha_(n-1), (lanes,)."""
    per_alpha = reciprocal(alpha)
    slope, ratio = f.copy(), per_alpha.copy()
    slope[1:] = f[1:] * per_alpha[:-1]
    ratio[1:] = alpha[:-1] * per_alpha[1:]
    return -slope, ratio, per_alpha[-1]


def factor(u: Floats32, slope: Floats32, g: Floats32) -> tuple[Floats32, Floats32]:
    """U and k = P x; slope: the l_j of `quotients`."""
    u, k = u.copy(), np.empty_like(g)
    for j in range(len(g)):
        column = u[:j, j].copy()
        u[:j, j] = on_grid(column + k[:j] * slope[j], FACTOR_GRID)
        k[:j] = k[:j] + column * g[j]
        k[j] = g[j]
    return u, k


def magnitude(x: Floats32) -> Floats32:
    """|x|, computed by clearing the sign bit."""
    return float_of(bits_of(x) & np.uint32(MAGNITUDE_BITS))


def on_grid(x: Floats32, grid: float) -> Floats32:
    """`x` rounded to multiples of `grid` for |x| <= 2^22 grid; for larger |x| the rounding is coarser."""
    floor = ROUNDING * np.float32(grid)
    return (x + floor) - floor


class Learner(LearnerWords):
    """`lanes` learners, initialised from `instance` like `<name>_learn_init(self, model)`; `learn` is their
    recursive least squares."""

    def __init__(self, model: Model, instance: Instance) -> None:
        self.numbers: LearnerNumbers = learner_numbers(model, instance.numbers)
        self.model_numbers = instance.numbers
        self.base, self.channels = instance.bank, instance.channels
        n, lanes = self.numbers.size, instance.u_V.shape[0]
        starts: dict[Start, Any] = {
            Start.ZERO: _ZERO,
            Start.ONE: _ONE,
            Start.MODEL_Y: instance.y_um,
            Start.MODEL_U: instance.u_V,
        }
        shapes = {Holds.VECTOR: (n, lanes), Holds.MATRIX: (n, n, lanes)}
        for member in self.described():
            if member.holds in (Holds.COUNTERS, Holds.INPUTS, Holds.TERMS):
                continue
            dtype = np.float32 if member.type == "float" else np.uint32
            start, shape = starts[member.start or Start.ZERO], shapes.get(member.holds, (lanes,))
            setattr(self, member.name, start.copy() if np.shape(start) else np.full(shape, start, dtype))
        own = [self._number(i) * self.numbers.scale[i] for i in range(n)]
        self.reference = np.repeat(np.array(own, np.float32)[:, None], lanes, axis=1)
        self.counters = {name: np.zeros(lanes, np.uint32) for name in self.COUNTERS}
        self.inputs, self.terms = copy.deepcopy(instance.inputs), copy.deepcopy(instance.terms)
        self.inputs.straighten()
        self.restart(np.ones(lanes, np.bool_))

    def restart(self, where: Mask) -> None:
        """Reset to the reference parameters and the prior, P = alpha I with U = I."""
        if not where.any():
            return
        numbers = self.numbers
        values: dict[Restart, Any] = {
            Restart.REFERENCE: self.reference,
            Restart.PRIOR: numbers.prior[:, None],
            Restart.LEVEL: numbers.level_um,
        }
        for member in self.described():
            if member.restart is not None:
                zero = _ZERO if member.type == "float" else np.uint32(0)
                self._put(where, **{member.name: values.get(member.restart, zero)})
        self._put(where, u=_ZERO)

    def _put(self, where: Mask, **values: Any) -> None:
        """Change words of the state where true, and leave them elsewhere."""
        for name, value in values.items():
            setattr(self, name, np.where(where, value, getattr(self, name)))

    def count_event(self, event: str, happened: Mask) -> None:
        """Set the status bit of `event` and increment its counter where `happened`."""
        if not happened.any():
            return
        flag = np.uint32(self.COUNTERS[event].flag)
        self.status = self.status | np.where(happened, flag, np.uint32(0))
        self.count(event, happened)

    def count(self, event: str, happened: Mask) -> None:
        """Increment the counter of `event` where `happened`; counters saturate at LAST."""
        count = self.counters[event]
        self.counters[event] = count + (happened & (count < LAST)).astype(np.uint32)

    def stored(self) -> list[tuple[int, int]]:
        """(i, j) of every U_ij above the diagonal, in the order of the struct: column by column."""
        return [(i, j) for j in range(self.numbers.size) for i in range(j)]

    def _number(self, i: int) -> np.float32:
        """The initial bank number of parameter i; 0 for the bias, which is not part of the bank."""
        parameter = self.numbers.parameters[i]
        table = {"slope": self.base.slope, "gain": self.base.gain, "offset": self.base.offset}
        table |= {"bias": np.zeros(1, np.float32)}
        number: np.float32 = table[parameter.group][parameter.index]
        return number

    def aux(self, values: Sequence[Floats32]) -> None:
        """Set the auxiliary channels of the next sample as `<name>_learn_aux`, (lanes,) each, in their order."""
        named = dict(zip(self.channels, values, strict=True))
        for term in self.terms:
            term.listen(named)
        self.inputs.listen(named)

    def learn(self, y_um: Floats32, u_V: Floats32) -> None:
        """Process sample k, (lanes,) each; the innovation is y(k) minus its prediction from sample k - 1."""
        numbers = self.numbers
        y, y_lost = finite(y_um, self.y_um)
        u, u_lost = finite(u_V, self.u_V)
        u, _ = limited(u, self.model_numbers.u_min_V, self.model_numbers.u_max_V)
        w = self.inputs.apply(u)
        usable = (y_lost == 0) & ~((y < numbers.y_low_um) | (y > numbers.y_high_um))
        away = u - self.mean_u_V
        self.count_event("rejected", ~usable | (u_lost != 0))
        taking = (self.fresh != 0) & usable
        innovation, begun = self._evaluate_reading(taking, np.where(taking, y, self.y_um))
        for term in self.terms:
            term.correct(np.where(taking, innovation, _ZERO))
        self._update(begun)
        self._store_regressors(usable & (u_lost == 0), y, w)
        self.rested = (magnitude(away) < numbers.rest_V).astype(np.uint32)
        self.mean_u_V = flushed(self.mean_u_V + _FAST * away)
        self.u_V = u
        for term in self.terms:
            term.advance()

    def _evaluate_reading(self, where: Mask, y: Floats32) -> tuple[Floats32, Mask]:
        """Innovation e = y - x' theta - fixed_um [um], (lanes,), and the lanes in which an update with e begins."""
        predicted = []
        for theta in (self.theta, self.reference, self.trial):
            total = np.zeros_like(y)
            for i in range(self.numbers.size):
                total = total + self.x[i] * theta[i]
            predicted.append(total + self.fixed_um)
        e, reference, tried = (y - prediction for prediction in predicted)
        rested = self.rested != 0
        self.count_event("resting", where & rested)
        where = where & ~rested
        self._try(where, tried, reference)
        lost = self._restart_needed(where, e, reference, y - self.y_um)
        self.count_event("restarts", lost)
        self.restart(lost)
        begun = where & ~lost
        self._begin(begun, e)
        return e, begun

    def begin_trial(self, where: Mask, samples: int) -> None:
        """Begin to compare `trial` with the reference parameters; nothing to compare on if nothing was ever learnt."""
        to_come = np.where(self.counters["updates"] != 0, np.uint32(samples), np.uint32(0))
        names = ("trial_um", "trial_reference_um", "trial_error", "trial_reference_error")
        self._put(where, trying=to_come, **dict.fromkeys(names, _ZERO))

    def _try(self, where: Mask, tried: Floats32, reference: Floats32) -> None:
        """Update the errors of a trial: innovations within the limit of the outlier gate, added up as in a free run."""
        numbers, moved = self.numbers, _TWO * self.moving_um
        limit = magnitude(numbers.gate_ratio * self.scale_um + (moved + numbers.gate_floor_um))
        for name, e in (("trial", tried), ("trial_reference", reference)):
            before, level = getattr(self, f"{name}_um"), getattr(self, f"{name}_error")
            free_run = numbers.carried * before + limited(e, -limit, limit)[0]
            step = _SLOW * ((free_run * free_run + numbers.floor_um * numbers.floor_um) - level)
            self._put(where, **{f"{name}_um": flushed(free_run), f"{name}_error": level + step})
        self.trying = self.trying - (where & (self.trying > 0)).astype(np.uint32)

    def _restart_needed(self, where: Mask, e: Floats32, reference: Floats32, step: Floats32) -> Mask:
        """Update the running means; true where the shadow, after its settling time, fails the restart test.

        The test fails if the mean square innovation of the shadow exceeds `worse` times that of the reference
        parameters or `lost` times that of the persistence y(k+1) = y(k).
        """
        numbers, settings = self.numbers, self.numbers.settings
        square = numbers.floor_um * numbers.floor_um
        rate = np.where(self.age >= settings.settle // 2, _SLOW, _ZERO)

        def track(name: str, value: Floats32, pace: Floats32 | np.float32) -> None:
            level = getattr(self, name)
            self._put(where, **{name: level + pace * (value - level)})

        track("moving_um", magnitude(step) + numbers.floor_um, _FAST)
        for name, missed in (("error", e), ("reference_error", reference), ("step_error", step)):
            track(name, missed * missed + square, rate)
        worse: Mask = self.error > numbers.worse * self.reference_error
        lost: Mask = self.error > numbers.lost * self.step_error
        return where & (self.age >= settings.settle) & (worse | lost)

    def _begin(self, where: Mask, e: Floats32) -> None:
        """Begin an update with the sample or with the pseudo-measurement w reference_j = w theta_j of a prior."""
        numbers, settings = self.numbers, self.numbers.settings
        sliding = (self.age >= settings.window) | np.bool_(settings.forgetting < 1.0)
        since = self.since_refresh + sliding.astype(np.uint32)
        measuring = since < settings.refresh
        refreshing = where & ~measuring
        lanes = np.arange(e.size)
        weight = numbers.refresh[self.turn]
        back = weight * (self.reference[self.turn, lanes] - self.theta[self.turn, lanes])
        turned = np.arange(numbers.size)[:, None] == self.turn
        forgetting = np.where(sliding, numbers.inflate, numbers.inflate_first)
        following = np.where(self.turn + 1 < numbers.size, self.turn + 1, 0).astype(np.uint32)
        self._put(refreshing, x=np.where(turned, weight, _ZERO), turn=following)
        self._put(
            where,
            inflate=np.where(measuring, forgetting, _ONE),
            innovation_um=np.where(measuring, e, back),
            since_refresh=np.where(measuring, since, np.uint32(0)),
            measuring=measuring.astype(np.uint32),
        )

    def _update(self, where: Mask) -> None:
        """The update of P and theta with the x, the innovation and the forgetting factor that `_begin` stored."""
        f = project(self.u, self.x)
        self._put(where, f=f, g=on_grid((self.d * self.inflate) * f, GAIN_GRID))
        accepted = self._update_diagonal(where)
        u, k = factor(self.u, self.l, self.g)
        self._put(accepted, u=u, k=k)
        self._update_theta(accepted)

    def _update_diagonal(self, where: Mask) -> Mask:
        """alpha_j, l_j = -f_j/alpha_(j-1) and D_j in the lanes whose innovation is accepted; returns those lanes."""
        numbers = self.numbers
        alpha = denominators(self.f, self.g)
        before = alpha[-1]
        wild = where & (bits_of(before) >= bits_of(np.asarray(numbers.largest_denominator)))
        self.count_event("restarts", wild)
        self.restart(wild)
        where = where & ~wild
        where = where & ~self._excluded(where & (self.measuring != 0), before)
        slope, ratio, per_alpha = quotients(self.f, alpha)
        d, ceiling = (self.d * self.inflate) * ratio, numbers.ceiling[:, None]
        clamped = (d < _LEAST_VARIANCE) | (d > ceiling)
        d = np.where(d < _LEAST_VARIANCE, _LEAST_VARIANCE, np.where(d > ceiling, ceiling, d))
        self._put(where, l=slope, d=d, per_alpha=per_alpha)
        self.count_event("clamped", where & clamped.any(axis=0))
        return where

    def _excluded(self, where: Mask, alpha: Floats32) -> Mask:
        """True for outliers and innovations in the dead zone; updates the running mean of |innovation|."""
        numbers, settings = self.numbers, self.numbers.settings
        e = self.innovation_um
        size = magnitude(e)
        limit = numbers.gate_ratio * self.scale_um + (_TWO * self.moving_um + numbers.gate_floor_um)
        far = e * e > limit * limit * alpha
        quiet = (size < numbers.dead_zone_um) & (alpha < _DEAD_ZONE_ALPHA) & (self.inflate > _ONE)
        most = _FOUR * self.scale_um + numbers.gate_floor_um
        seen = np.where(size > most, most, size) + numbers.floor_um
        scale = self.scale_um + _FAST * (seen - self.scale_um)
        scale = np.where(alpha < _LEVEL_ALPHA, scale, self.scale_um)
        run = np.where(far, self.run + np.uint32(1), self.run - (self.run > 0).astype(np.uint32))
        changed = run >= settings.outlier_run
        scale = np.where(changed & (size > scale), size, scale)
        self._put(where, scale_um=scale, run=np.where(changed, np.uint32(0), run))
        outlier = far & ~changed
        self.count_event("outliers", where & outlier)
        self.count_event("changes", where & changed)
        self.count_event("quiet", where & quiet)
        return where & (outlier | quiet)

    def _update_theta(self, where: Mask) -> None:
        """theta <- theta + k e/alpha, summed with its rounding error; no parameter moves by more than step_um."""
        numbers = self.numbers
        q = self.innovation_um * self.per_alpha
        size = float_of((bits_of(self.k) & np.uint32(MAGNITUDE_BITS)).max(axis=0)) * magnitude(q)
        long = where & (size > numbers.step_um)
        q = np.where(long, q * (numbers.step_um * reciprocal(np.where(long, size, _ONE))), q)
        self.count_event("limited", long)
        carried = self.theta_low + on_grid(self.k * q, STEP_GRID)
        theta = self.theta + carried
        self._put(where, theta=theta, theta_low=carried - (theta - self.theta))
        beyond = where & (bits_of(magnitude(theta)) >= bits_of(np.asarray(numbers.limit_um))).any(axis=0)
        self.count_event("restarts", beyond)
        self.restart(beyond)
        counted = where & ~beyond
        self.count("updates", counted)
        self.age = self.age + (counted & (self.measuring != 0) & (self.age < LAST)).astype(np.uint32)

    def _store_regressors(self, where: Mask, y_um: Floats32, v: Floats32) -> None:
        """Store the scaled regressors x_i = phi_i(k)/scale_i of this sample for the innovation of sample k + 1."""
        model, numbers = self.model_numbers, self.numbers
        y, outside = limited(y_um, model.y_min_um, model.y_max_um)
        r = ratio(model, y)
        per_weight = reciprocal(polynomial(model.strength, r))
        firing = [
            power * per_weight * scale for power, scale in zip(powers(r, model.rules), numbers.firing, strict=True)
        ]
        share = {"slope": y * numbers.per_y, "gain": v * numbers.per_u}
        rows = []
        for parameter in numbers.parameters:
            j = parameter.index
            if parameter.group == "bias":
                row = np.ones_like(y)
            elif parameter.group == "offset":
                row = firing[j]
            else:
                row = firing[j] * share[parameter.group]
            rows.append(on_grid(row, REGRESSOR_GRID))
        self._put(where, x=np.stack(rows), fixed_um=self._fixed(y, v, per_weight), y_um=y_um)
        self.fresh = np.where(where & (outside == 0), np.uint32(1), np.uint32(0))
        self.count_event("outside", where & (outside != 0))

    def _fixed(self, y: Floats32, v: Floats32, per_weight: Floats32) -> Floats32:
        """The part of the prediction y(k+1) whose parameters are not learned [um], (lanes,)."""
        sums = rule_sums(self.model_numbers, self.base, y)
        parts = {"slope": y * sums.slope, "offset": sums.offset, "gain": v * sums.gain}
        total: Floats32 | None = None
        for group, part in parts.items():
            if not self.numbers.learns(group):
                total = part if total is None else total + part
        if total is not None:
            total = total * per_weight
        phi = [regressor for term in self.terms for regressor in term.regressors()]
        if phi:
            extra = self.base.weight[0] * phi[0]
            for theta, regressor in zip(self.base.weight[1:], phi[1:], strict=True):
                extra = extra + theta * regressor
            total = extra if total is None else total + extra
        return np.zeros_like(y) if total is None else flushed(total)
