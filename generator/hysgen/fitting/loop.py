"""Identification of hysteretic states in the loop of a mode, by output error of the free run.

    y = c + sum_m Re x_m + Re x,   x_m as in `structure`,   x and the states h_r as in `model.path.loop`

The start is the strongest mode of an identified structure, with a share of its stiffness given to the states, from
several shapes of them. States are added one at a time while that lowers the error of the last third of each segment,
which the fit leaves out; then all rows are fitted. One state may grow under load (p < 0, a stiffening spring that its
box bounds); several are held to p >= 0: nothing would tell two springs without bound apart.
All numbers are refined jointly by Levenberg-Marquardt, with forward differences: a free run takes milliseconds.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve

from hysgen.fitting.structure import EDGE_DECAY, LAG, ModalForm, admitted_poles, states
from hysgen.machine.kernels.operators import loop_states
from hysgen.model.path.loop import MOST_PARTS, MOST_STATES, Loop

Floats = NDArray[np.float64]

LIGHT, APART, MOST_MODES = 0.3, 0.15, 6
"""Modes that the fit starts with: largest damping ratio (broader ones of a linear fit stand for what it cannot), least
distance as a share of the stronger's frequency (a linear fit splits a mode that moves), and largest number."""
COARSE: Final = 0.01
"""Periods of the mode in a sample above which the states take two steps in it."""

SHAPES: Final = ((0.5, 0.1, 1.0), (0.2, 0.3, 2.0), (0.5, 0.0, 0.3))
"""Starts: share of the stiffness, p and q in 1 / rms of y."""
BESIDE: Final = ((0.3, 3.0), (0.0, 0.3))
"""Starts of p and q of a state that is added, with no force."""
LEAST_FALL: Final = 0.02
"""Least fall of the error of rows left out by which a state is worth its cycles."""
ROUGH, FINE = 6, 25
"""Steps of Levenberg-Marquardt from every start, and from the best."""
WIDE, MARGIN = 20.0, 1.5
"""Box of a state in rms of y while it is fitted, and its delivered box over the largest |h| of the record."""
STEP = 1e-6  # of a forward difference


@dataclass(frozen=True, eq=False)
class _Task:
    """Runs of u and y, (n,) each, about their means and y over `scale` um; used: flags of the fitted rows of all."""

    u: Sequence[Floats]
    y: Sequence[Floats]
    used: NDArray[np.bool_]
    parts: int
    modes: int
    scale: float

    def split(self, theta: Floats) -> tuple[NDArray[np.complex128], NDArray[np.complex128], Floats]:
        """Poles (N + 1,), the last at the edge of the band, their gains, and (r, 4) force, quadrature, p and q."""
        rates = theta[: 2 * self.modes].view(np.complex128)
        poles = np.append(np.exp(rates), np.exp(-EDGE_DECAY + 3.1j))
        at = 4 * self.modes + 2
        return poles, theta[2 * self.modes : at].view(np.complex128), theta[at:].reshape(-1, 4)

    def run(self, theta: Floats, u: Floats) -> tuple[Floats, Floats]:
        """(n,) displacement, and (n, 1 + r) of `loop_states`."""
        poles, gains, own = self.split(theta)
        y = np.sum([states(pole, gain * u).real for pole, gain in zip(poles, gains, strict=True)], axis=0)
        step = poles[0] ** (1.0 / self.parts)
        shape = np.column_stack([own[:, 2:], np.full(len(own), WIDE)])
        moved = loop_states(y, self.parts, np.array([step.real, step.imag]), own[:, :2], shape)
        return y + moved[:, 0], moved

    def error(self, theta: Floats, rows: NDArray[np.bool_] | None = None) -> Floats:
        """(n,) error of the used rows, or of others, about its mean."""
        error = np.concatenate([self.run(theta, u)[0] - y for u, y in zip(self.u, self.y, strict=True)])
        error = error[self.used if rows is None else rows]
        return np.asarray(np.nan_to_num(error - error.mean(), nan=1e9, posinf=1e9, neginf=-1e9))

    def admitted(self, theta: Floats) -> Floats:
        """The nearest numbers whose modes decay, whose q is not negative, and p neither of several states."""
        theta = theta.copy()
        rates = theta[: 2 * self.modes].view(np.complex128)
        rates[:] = np.log(admitted_poles(np.exp(rates)))
        own = theta[4 * self.modes + 2 :].reshape(-1, 4)
        own[:, 3] = np.maximum(own[:, 3], 0.0)
        if len(own) > 1:
            own[:, 2] = np.maximum(own[:, 2], 0.0)
        return theta

    def scales(self, theta: Floats) -> Floats:
        """Size of each number, by which it is moved in a forward difference."""
        gains, own = theta[2 * self.modes : 4 * self.modes + 2], theta[4 * self.modes + 2 :].reshape(-1, 4)
        sizes = np.tile([abs(theta[1]), abs(theta[1]), 0.3, 1.0], (len(own), 1))
        rates = np.tile([0.1, 1.0], self.modes) * np.repeat(theta[1 : 2 * self.modes : 2], 2)
        return np.concatenate([rates, np.full(gains.size, np.abs(gains).max()), sizes.ravel()])

    def normal(self, theta: Floats, error: Floats) -> tuple[Floats, Floats]:
        """J J' and J e, with every number over its size."""
        step = STEP * self.scales(theta)
        J = np.array([(self.error(theta + d) - error) / STEP for d in np.diag(step)])
        return J @ J.T, J @ error


def identify_loop(u_V: Sequence[Floats], y_um: Sequence[Floats], form: ModalForm, skipped: int) -> ModalForm | None:
    """The modes with hysteretic states in the loop of the strongest; None if they leave more than the `form` alone.

    u_V, y_um: (n,) of each segment, the first `skipped` rows of which have an unknown past. form: of the command alone.
    Deterministic.
    """
    middle, level = float(np.mean(np.concatenate(list(u_V)))), float(np.mean(np.concatenate(list(y_um))))
    scale = float(np.std(np.concatenate(list(y_um))))
    start = _start(form)
    if start is None:
        return None
    rows = [np.arange(y.size) >= min(skipped, y.size // 2) for y in y_um]
    early = np.concatenate([known & (np.arange(known.size) < (2 * known.size) // 3) for known in rows])
    fitted = np.concatenate(rows)
    poles, gains = start
    parts = MOST_PARTS if abs(np.angle(poles[0])) > 2.0 * math.pi * COARSE else 1
    task = _Task([u - middle for u in u_V], [(y - level) / scale for y in y_um], early, parts, poles.size, scale)
    linear = np.concatenate([form.simulate(u[None]) - y for u, y in zip(u_V, y_um, strict=True)])[fitted & ~early]
    least, best = float(np.std(linear)) / scale, None
    starts = [_shaped(poles, gains / scale, shape, parts) for shape in SHAPES]
    for _ in range(MOST_STATES):
        rough = [_refined(task, theta, ROUGH) for theta in starts]
        theta = _refined(task, min(rough, key=lambda theta: float(np.std(task.error(theta)))), FINE)
        checked = float(np.std(task.error(theta, fitted & ~early)))
        if not checked < (1.0 - LEAST_FALL) * least:
            break
        least, best = checked, theta
        starts = [np.concatenate([theta, [0.0, 0.0, *shape]]) for shape in BESIDE]
    if best is None:
        return None
    task = replace(task, used=fitted)
    return _form(task, _refined(task, best, FINE), form.Ts_s, (middle, level))


def _start(form: ModalForm) -> tuple[NDArray[np.complex128], NDArray[np.complex128]] | None:
    """The light modes of a form, the strongest first, none near a stronger one; None without any."""
    strength = np.abs(form.gains[:, 0]) / (1.0 - np.abs(form.poles))
    chosen: list[int] = []
    for m in np.argsort(-strength, kind="stable"):
        near = any(abs(form.f_Hz[m] / form.f_Hz[other] - 1.0) < APART for other in chosen)
        if form.zeta[m] < LIGHT and not near:
            chosen.append(int(m))
    chosen = chosen[:MOST_MODES]
    return (form.poles[chosen], form.gains[chosen, 0]) if chosen else None


def _shaped(
    poles: NDArray[np.complex128], gains: NDArray[np.complex128], shape: tuple[float, float, float], parts: int
) -> Floats:
    """The numbers of a start: one state takes a share of the stiffness of the first mode.

    The force of the command stays: x = b / (z - lam) of a mode w has b = -i f/w, and a state the force -share w^2 h.
    """
    share, p, q = shape
    rates, w = np.log(poles), abs(np.angle(poles[0]))
    softer = math.sqrt(1.0 - share)
    first = complex(rates[0].real, softer * w)
    force = 1j * share * w * w / parts / (softer * w)
    # The state acts from the start of a step on: what it pushes turns with the mode.
    force *= np.exp(first / parts)
    every = np.concatenate([[first], rates[1:], gains[:1] / softer, gains[1:], [0.0, force]])
    return np.concatenate([every.view(np.float64), [p, q]])


def _refined(task: _Task, theta: Floats, steps: int) -> Floats:
    """Levenberg-Marquardt over all numbers."""
    theta, mu = task.admitted(theta), 1e-3
    error = task.error(theta)
    power = float(error @ error)
    for _ in range(steps):
        square, product = task.normal(theta, error)
        diagonal, scales, before = np.sqrt(np.diag(square)), task.scales(theta), power
        diagonal = np.maximum(diagonal, 1e-12 * diagonal.max())  # a state without force has no shape yet
        for _ in range(6):
            damped = square / np.outer(diagonal, diagonal) + mu * np.eye(diagonal.size)
            trial = task.admitted(theta - scales * solve(damped, product / diagonal, assume_a="pos") / diagonal)
            beside = task.error(trial)
            if float(beside @ beside) < power:
                theta, error, power, mu = trial, beside, float(beside @ beside), max(mu / 5.0, 1e-9)
                break
            mu *= 5.0
        if before - power < 1e-4 * before:
            break
    return theta


def _form(task: _Task, theta: Floats, Ts_s: float, about: tuple[float, float]) -> ModalForm:
    """The modes in um with their block of states, about the means of command and displacement."""
    (middle, level), (poles, gains, own) = about, task.split(theta)
    error = task.error(theta)
    square, _ = task.normal(theta, error)
    variance = float(error @ error) / error.size
    sizes = task.scales(theta) * np.sqrt(np.diag(np.linalg.pinv(square)) * variance)
    errors = np.append(np.abs(poles[:-1, None]) * sizes[: 2 * task.modes].reshape(-1, 2), [[1.0, 1.0]], axis=0)
    most = np.max([np.abs(task.run(theta, u)[1][:, 1:]).max(axis=0) for u in task.u], axis=0)
    columns = np.column_stack([own[:, :2], own[:, 2:] / task.scale, MARGIN * task.scale * most]).T.tolist()
    force, quadrature, loading, unloading, box_um = (tuple(column) for column in columns)
    form = ModalForm(poles, task.scale * gains[:, None], 0.0, Ts_s, task.scale * math.sqrt(variance), errors)
    loop = Loop(
        f_Hz=float(form.f_Hz[0]),
        zeta=float(form.zeta[0]),
        force=force,
        quadrature=quadrature,
        loading=loading,
        unloading=unloading,
        box_um=box_um,
        parts=task.parts,
        lag_s=LAG * Ts_s,
        gain=float(form.static[0]),
    )
    return replace(form, constant_um=level - loop.gain * middle, loop=loop)
