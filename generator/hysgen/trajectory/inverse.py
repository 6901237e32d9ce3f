"""The exact inverse of a model along a whole reference, in float64, with as much preview as the model needs.

    rules        w(k) = (y(k+1) - sum_l p_l(y(k)) (q_l1 y(k) + q_l3)) / sum_l p_l(y(k)) q_l2,              Eq. (11)
    creep, modes x(k) = (w(k) - C s(k)) / D,   s(k+1) = F s(k) + B/D w(k),   F = A - B C / D
    hysteresis   the v(k) whose h(k) is wanted, sample after sample
    delay        u(k) = (v(k+d) - mu u(k-1)) / (1 - mu), from the end backwards where mu > 1/2

In the coordinates of the eigenvectors of F, each state with an eigenvalue inside the unit circle is computed from the
start on, each other state from the end backwards, where the reference rests: the inverse of a stage with zeros outside
the circle, exact but for what its voltage would have to do before the first sample.
Source: Devasia, Chen and Paden, IEEE Trans. Autom. Control 41 (1996) 930-942.
"""

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
import scipy  # its parts are imported where they work
from numpy.typing import NDArray
from scipy.optimize import brentq

from hysgen.errors import ModelError
from hysgen.machine.kernels.operators import hysteresis_inverse
from hysgen.model.model import Model
from hysgen.model.path.base import InputBlock, StateSpace, inverted
from hysgen.model.path.delay import Delay
from hysgen.model.path.hysteresis import Hysteresis
from hysgen.model.regression import memberships
from hysgen.model.simulate import rest_um

Floats = NDArray[np.float64]

FOUND = 1e-12
"""Share of the input range to which the voltage of a rest is found."""

FORGOTTEN = 1e-9
"""Share of a state before the first sample that may be missing."""

MOST_PREVIEW = 100_000
"""Samples of the voltage before the first sample of the reference, at most."""

NEAR_CIRCLE = 0.6
"""A delay whose zero is nearer to the unit circle is planned in whole samples: the exact inverse of it would ring."""

CORRECTIONS = 12
"""Largest number of corrections of the reference by what the inverse misses."""


def own_response(model: Model) -> Model:
    """The model without its disturbances: what of them comes next, and in which phase, no reference says."""
    return dataclasses.replace(model, terms=(), weights=np.zeros(0), scores={}, certificates={})


def without_unstable(model: Model) -> Model:
    """The model that the emitted inverse inverts: without disturbances and blocks that have no stable inverse.

    Asked for what this model answers to a voltage, the emitted inverse puts out this voltage.
    """
    solved = tuple(block for block in model.blocks if not block.responds or block.solves(model.Ts_s))
    return dataclasses.replace(own_response(model), blocks=solved)


def in_whole_samples(model: Model) -> tuple[Model, float]:
    """The model with its delay in whole samples, where the exact inverse of the delay is NEAR_CIRCLE, and the part of a
    sample by which its answer is too soon: nothing in a model tells the time, so a reference is sooner by it instead.
    """
    near = [
        b for b in model.blocks if isinstance(b, Delay) and NEAR_CIRCLE < b.part / (1.0 - b.part) < 1.0 / NEAR_CIRCLE
    ]
    if not near:
        return model, 0.0
    blocks = tuple(dataclasses.replace(b, samples=float(b.whole)) if b in near else b for b in model.blocks)
    return dataclasses.replace(model, blocks=blocks), near[0].part


def rest_voltage(model: Model, y_um: float) -> float:
    """Voltage under which the model rests at y; an end of the input range for a y beyond it."""
    ends_V = model.u_min_V, model.u_max_V
    missed = {u_V: rest_um(model, u_V, {}) - y_um for u_V in ends_V}
    if missed[ends_V[0]] * missed[ends_V[1]] > 0.0:
        return min(ends_V, key=lambda u_V: abs(missed[u_V]))
    return float(brentq(lambda u_V: rest_um(model, u_V, {}) - y_um, *ends_V, xtol=FOUND * (ends_V[1] - ends_V[0])))


def preview_samples(model: Model) -> int:
    """Samples by which the voltage begins before the reference: delay, and zeros outside the unit circle."""
    ahead = 1
    for block in model.blocks:
        ahead += block.preview
        space = block.state_space(model.Ts_s)
        outside = [] if space is None else [abs(z) for z in np.linalg.eigvals(inverted(space)[0]) if abs(z) > 1.0]
        if isinstance(block, Delay) and block.part > 0.5:
            outside = [block.part / (1.0 - block.part)]
        if outside:
            ahead += min(math.ceil(-math.log(FORGOTTEN) / math.log(min(outside))), MOST_PREVIEW)
    return ahead


def inverse(model: Model, y_um: Floats, rest_V: float) -> Floats:
    """Voltages u(k), (n,), that take the model from rest under rest_V along y(k), (n + 1,).

    The model has no disturbances. A y(k) that no voltage reaches takes the nearest end of the range of the hysteresis.
    Raises ModelError if a response of the model cannot be inverted.
    """
    of_y, of_w, constant = (memberships(y_um[:-1], model.grid) @ model.consequents).T
    w = (y_um[1:] - of_y * model.grid.clamp(y_um[:-1]) - constant) / of_w
    return inverse_of_path(model.blocks, w, rest_V, model.Ts_s)


def inverse_of_path(blocks: Sequence[InputBlock], out: Floats, rest_V: float, Ts_s: float) -> Floats:
    """Voltages, (n,), that bring forth the output of the blocks, (n,), from rest under rest_V."""
    levels = [rest_V]
    for block in blocks:
        levels.append(float(block.apply(np.full(2, levels[-1]), Ts_s)[0]))
    for block, before, behind in zip(reversed(blocks), levels[-2::-1], levels[:0:-1], strict=True):
        out = _solved(block, out, before, behind, Ts_s)
    return out


def corrected_inverse(model: Model, y_um: Floats, rest_V: float) -> tuple[Floats, Floats]:
    """`inverse`, and the y that the model answers, (n + 1,); the reference is corrected while its error falls.

    The first pass is exact up to interpolated delays and rounding; each further one inverts y + (y - answer).
    """
    aim = y_um
    best: tuple[float, Floats, Floats] | None = None
    for _ in range(CORRECTIONS):
        u_V = inverse(model, aim, rest_V)
        answer = model.simulate(np.append(u_V, u_V[-1]), float(y_um[0]))
        missed = float(np.abs(answer - y_um).max())
        if best is not None and not missed < 0.5 * best[0]:
            break
        best = (missed, u_V, answer)
        aim = aim + (y_um - answer)
    assert best is not None
    return best[1], best[2]


def _solved(block: InputBlock, out: Floats, input_at_rest: float, out_at_rest: float, Ts_s: float) -> Floats:
    """The input, (n,), of a block whose output is `out`, (n,), from rest."""
    if isinstance(block, Hysteresis):
        x, _ = hysteresis_inverse(block.series, out, block.start(input_at_rest))
        return 0.5 * (block.low_V + block.high_V) + 0.5 * (block.high_V - block.low_V) * x
    if isinstance(block, Delay):
        return _sooner(block, out)
    space = block.state_space(Ts_s)
    if space is not None:
        return input_at_rest + _linear_inverse(space, out - out_at_rest)
    if block.responds:
        raise ModelError(f"{block.kind}: has no inverse along a reference; fit the model without it")
    return out


def _linear_inverse(space: StateSpace, out: Floats) -> Floats:
    """The input of a linear block, both as deviations from rest; `out` stays at its last value."""
    _, _, C, D = space
    A, B, _, _ = inverted(space)
    zeros, V = np.linalg.eig(A)
    weights = np.linalg.solve(V, B) * (C @ V)
    x = out / D
    for zero, weight in zip(zeros, weights, strict=True):
        if abs(zero) < 1.0:
            state = scipy.signal.lfilter([0.0, weight], [1.0, -zero], out)
        else:
            last = weight * out[-1] / (1.0 - zero)
            back, _ = scipy.signal.lfilter([-weight / zero], [1.0, -1.0 / zero], out[::-1], zi=[last / zero])
            state = back[::-1]
        x = x - np.real(state) / D
    return np.asarray(x)


def _sooner(block: Delay, out: Floats) -> Floats:
    """The command whose delayed course is `out`."""
    mu, held = block.part, np.concatenate([out, np.full(block.whole + 1, out[-1])])
    early = held[block.whole : block.whole + out.size]
    if mu <= 0.5:
        start = [-mu / (1.0 - mu) * out[0]]
        return np.asarray(scipy.signal.lfilter([1.0 / (1.0 - mu)], [1.0, mu / (1.0 - mu)], early, zi=start)[0])
    later, end = held[block.whole + 1 :], [-(1.0 - mu) / mu * out[-1]]
    return np.asarray(scipy.signal.lfilter([1.0 / mu], [1.0, (1.0 - mu) / mu], later[::-1], zi=end)[0][::-1])
