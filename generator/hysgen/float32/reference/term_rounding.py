"""What float32 adds to the disturbances and to the feedback in one step from a given state, beside `path_rounding`.

    extra = sum_j theta_j phi_j        behind the innovation of a measured sample, or of a later sample in an inverse

The states are the phases, which are exact, the samples of the channels, the words of the bias and of the modes.
"""

import functools
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from hysgen.float32.coefficients import coefficients
from hysgen.float32.reference.enclosed import HALF_BIT, Enclosed, Floats, Interval, Tape, largest_error
from hysgen.float32.reference.path_rounding import output, summed
from hysgen.float32.reference.rounding import Extra
from hysgen.float32.reference.step_numbers import Bounded, Complex, Number, Numbers, Real, every
from hysgen.model.disturbances import Mirror, Term
from hysgen.model.disturbances.base import box_of
from hysgen.model.disturbances.coupling import Coupling, Drives
from hysgen.model.disturbances.drift import Drift
from hysgen.model.disturbances.periodic import Periodic
from hysgen.model.feedback import Feedback, FeedbackMirror
from hysgen.model.model import Model
from hysgen.model.path import preview
from hysgen.model.path.modes import Modes

COSINE_ERROR: Final = 1.9e-7
"""Of `cosine_sine`: tests/model/test_periodic.py holds it to that over all phases of 32 bits."""
SLACK: Final = 1e-3
"""Part of its size by which y_um of the state is believed to leave the range of the rules; a bound above is none."""


@functools.singledispatch
def regressors(term: Term, n: Numbers, Ts_s: float, innovation: Number, ahead: int) -> list[Number]:
    """phi_j in the numbers n, `ahead` samples later; innovation: y(k) less its prediction, None in an inverse."""
    raise NotImplementedError


@regressors.register
def _(term: Periodic, n: Numbers, Ts_s: float, innovation: Number, ahead: int) -> list[Number]:
    return [part for line, f_Hz in enumerate(term.f_Hz) for part in _phasor(n, line, ahead * f_Hz * Ts_s, ahead)]


def _phasor(n: Numbers, line: int, turns: float, ahead: int) -> list[Number]:
    """Cosine and sine; float32 takes the upper 32 bits of the phase, and of the turn of each sample."""
    if isinstance(n, Bounded):
        return [n.rounded(every(-1.0, 1.0), COSINE_ERROR + 2.0 * np.pi * (1 + ahead) * 2.0**-32) for _ in range(2)]
    phase = (n.word("phase", line) + n.word("phase_low", line) * 2.0**-32) * 2.0**-32 + turns
    return [np.cos(2.0 * np.pi * phase), np.sin(2.0 * np.pi * phase)]


@regressors.register
def _(term: Coupling, n: Numbers, Ts_s: float, innovation: Number, ahead: int) -> list[Number]:
    return [n.heard(channel, age) for channel in range(len(term.channels)) for age in range(term.taps)]


@regressors.register
def _(term: Drives, n: Numbers, Ts_s: float, innovation: Number, ahead: int) -> list[Number]:
    constants, modes, drives = term.constants(Ts_s), len(term.f_Hz), len(term.channels)
    steps: Complex = Modes(term.f_Hz, term.zeta, (0.0,) * modes, 1.0).steps(Ts_s)
    shares = np.reshape(np.array(term.share) + 1j * np.array(term.quadrature), (modes, drives))
    values = [n.heard(channel, 0) for channel in range(drives)]
    most = np.array([float(value.value.size.max()) if isinstance(value, Enclosed) else 0.0 for value in values])
    positions, velocities = n.modes(1.0 - steps, steps[:, None] * shares, most)
    moves = []
    for m, (position, velocity) in enumerate(zip(positions, velocities, strict=True)):
        row = slice(m * drives, (m + 1) * drives)
        of_mode = ((shares[m].real, constants["share"][row]), (shares[m].imag, constants["quadrature"][row]))
        forward, turn = (
            summed([n.constant(*pair) * value for *pair, value in zip(*both, values, strict=True)]) for both in of_mode
        )
        real, imag = n.constant(steps[m].real, constants["real"][m]), n.constant(steps[m].imag, constants["imag"][m])
        moves.append(real * (forward - n.high(position)) - imag * (turn - n.high(velocity)))
    both = summed([n.high(position) for position in positions]), summed(moves)
    ends = [float(end) for end in constants["most"]]
    return [n.limited(phi, n.exact(-end), n.exact(end)) for phi, end in zip(both, ends, strict=True)]


@regressors.register
def _(term: Drift, n: Numbers, Ts_s: float, innovation: Number, ahead: int) -> list[Number]:
    constants = term.constants(Ts_s)
    bias = n.bias("bias_um", float(constants["limit"][0]))
    if innovation is None:
        return [n.high(bias)]
    limit = n.constant(term.limit_um, constants["limit"][0])
    moved = n.high(n.moved_on(bias, n.constant(term.rate(Ts_s), constants["rate"][0]) * innovation))
    return [n.limited(moved, n.exact(0.0) - limit, limit)]


def real_extra(
    model: Model, terms: Sequence[Mirror], innovation: Floats | None, aux: Mapping[str, Floats]
) -> Floats | float:
    """sum_j theta_j phi_j [um] in real arithmetic from the state of the mirrors, which stays; (lanes,).

    aux: the channels of this sample, which the mirrors have heard.
    """
    phi = [
        part
        for term, mirror in zip(model.terms, terms, strict=True)
        for part in regressors(
            term, Real(mirror, term.heard(aux) if isinstance(term, Coupling) else ()), model.Ts_s, innovation, 0
        )
    ]
    return sum((theta * part for theta, part in zip(model.weights, phi, strict=True)), 0.0)


def extra_error(model: Model, *, corrected: bool) -> Extra | None:
    """Size and error of the disturbances whatever the state; None without any; infinite where there is no bound.

    corrected: by the innovation of a measured sample.
    """
    if not model.terms:
        return None
    if any(regressors.dispatch(type(term)) is regressors.dispatch(Term) for term in model.terms):
        return Extra(np.inf, np.inf)
    sizes = [size for term in model.terms for size in box_of(term, model.Ts_s).regressors]
    size = 1.01 * float(sum(abs(theta) * most for theta, most in zip(model.weights, sizes, strict=True)))
    tape, numbers = Tape(), coefficients(model)
    innovation: Number = None
    if corrected:
        grid, (low, high) = model.grid, (float(numbers.y_min_um), float(numbers.y_max_um))
        off = max(abs(low - grid.y_min_um), abs(high - grid.y_max_um))
        last = _last_output(model, size)
        innovation = tape.number(every(low, high), rounding=off) - tape.number(last)
    ahead = 0 if corrected else preview(model.blocks)
    phi = [
        part
        for term in model.terms
        for part in regressors(term, Bounded(tape, term, every(0.0, 0.0)), model.Ts_s, innovation, ahead)
    ]
    weights = zip(model.weights.tolist(), numbers.bank.weight, phi, strict=True)
    total = summed([tape.constant(theta, rounded) * part for theta, rounded, part in weights])
    return Extra(size, float(largest_error(total).max()))


def _last_output(model: Model, extra_um: float) -> Interval:
    """y_um of a state: an output, which is a mean of the rules and the disturbances, or a displacement of `init`."""
    w, grid = model.w_range, model.grid
    q1, q2, q3 = model.consequents.T
    rules = np.array([q1 * y + q2 * end + q3 for y in (grid.y_min_um, grid.y_max_um) for end in (w.low, w.high)])
    low, high = min(float(rules.min()), grid.y_min_um), max(float(rules.max()), grid.y_max_um)
    slack = SLACK * max(abs(low), abs(high))
    return every(low - extra_um - slack, high + extra_um + slack)


def corrected(feedback: Feedback, residual: Number, n: Numbers, Ts_s: float, reach_um: float) -> tuple[Number, Number]:
    """c(k) where it moves, and what it moves by, with the integral of the model."""
    moves, notches = residual, feedback.filter
    if notches is not None:
        moves = n.flushed(output(notches, residual, n, Ts_s))
    end = (
        reach_um if notches is None else 1.01 * float(np.max(moves.value.size)) if isinstance(moves, Enclosed) else 0.0
    )
    (before,), (correction,) = n.stored("before_um", 1, -end, end), n.stored("correction_um", 1, *feedback.ends)
    step = n.flushed(n.constant(0.5 * feedback.integral, feedback.half) * (moves + before))
    limit = n.constant(feedback.limit_um, np.float32(feedback.limit_um))
    return n.flushed(n.limited(correction + step, n.exact(0.0) - limit, limit)), step


def real_correction(feedback: Feedback, mirror: FeedbackMirror, residual_um: Floats, Ts_s: float) -> Floats:
    """c(k) in real arithmetic from the state of the mirror, which stays; no end of the voltage acts."""
    moved, _ = corrected(feedback, residual_um, Real(mirror), Ts_s, 0.0)
    return np.asarray(moved)


def correction_error(model: Model) -> float | None:
    """Bound of |c_float32 - c_real| of one call from any state; None without feedback.

    Where the voltage is at an end, the sign of the step decides whether c moves: c is then off by the step at most.
    """
    if model.feedback is None:
        return None
    tape, reach = Tape(), float(coefficients(model).reach_um)
    residual = tape.number(every(-reach, reach), rounding=float(2.0 * HALF_BIT * reach))
    n = Bounded(tape, model.feedback, every(-reach, reach))
    moved, step = corrected(model.feedback, residual, n, model.Ts_s, reach)
    return float(largest_error(moved).max() + largest_error(step).max())
