"""From continuous time to substeps: the mesh inside one D/A period, and exact steps of the linear parts over it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from hysgen.stage.description import Stage
from hysgen.stage.effects import Bandwidth, Creep, require

Floats = NDArray[np.float64]

FINEST_S = 4e-6  # first substep behind the D/A's instant, where a fast amplifier bends most: 250 kHz
COARSEST_S = 100e-6  # creep and friction see straight pieces no longer than this; the lag is 1 ms
COARSEST_SLEWING_S = 20e-6  # a rate limit ends in a kink, at an instant of its own
GROWTH = 0.05  # a substep t after the D/A's instant is at most this share of t
CREEP_NODES_PER_DECADE = 6  # quadrature of the creep spectrum: error below 1e-7 of the creep (tested)


@dataclass(frozen=True)
class Mesh:
    """Substeps h_s of one sampling period; the A/D's sample is taken after substep `tap`, `late` periods on."""

    h_s: Floats
    tap: int
    late: int


@dataclass(frozen=True)
class Linear:
    """x' = A x + B v, y = c x + d v, stepped exactly over each substep for v linear over it.

    x(t + h) = phi x(t) + g0 v(t) + g1 v(t + h);  phi: (m, n, n), g0 and g1: (m, n), c and rest: (n,)
    rest is the state under a constant v = 1.
    """

    phi: Floats
    g0: Floats
    g1: Floats
    c: Floats
    rest: Floats
    d: float


@dataclass(frozen=True)
class Spectrum:
    """Relaxations that sample a creep spectrum; keep, g0, g1: (m, n) as phi, g0, g1 above; share: (n,)."""

    keep: Floats
    g0: Floats
    g1: Floats
    share: Floats


def mesh(stage: Stage, Ts_s: float) -> Mesh:
    """Where the signals are evaluated between two D/A instants.

    An ideal amplifier holds its voltage: one substep is exact. A real one bends after every D/A instant: the mesh is
    fine there and grows with the time since. The reading's fractional delay puts a node of its own into the mesh.
    """
    require(math.isfinite(Ts_s) and Ts_s > 0, f"Ts_s: {Ts_s} s is no sampling period; give a time above 0")
    late_s = stage.delay.samples * Ts_s + stage.delay.seconds if stage.delay else 0.0
    # A rounding error short of a whole number of periods is that whole number.
    periods = math.floor(late_s / Ts_s + 1e-9)
    tap_s = Ts_s - max(late_s - periods * Ts_s, 0.0)
    coarsest_s = COARSEST_SLEWING_S if stage.slew else COARSEST_S
    nodes = [0.0]
    while nodes[-1] < Ts_s * (1 - 1e-9):
        if stage.bandwidth or stage.slew:
            h_s = min(max(FINEST_S, GROWTH * nodes[-1]), coarsest_s)
        else:
            h_s = COARSEST_S if stage.creep or stage.stick_slip else Ts_s
        # Equal pieces up to the end, so that no sliver is left.
        left_s = Ts_s - nodes[-1]
        nodes.append(nodes[-1] + left_s / max(1, math.ceil(left_s / h_s - 1e-9)))
    nodes[-1] = Ts_s
    if min(abs(node - tap_s) for node in nodes) > 1e-9 * Ts_s:
        nodes = sorted([*nodes, tap_s])
    tap = int(np.argmin(np.abs(np.array(nodes) - tap_s))) - 1
    return Mesh(np.diff(np.array(nodes)), tap, periods)


def mechanics(stage: Stage, h_s: Floats) -> Linear:
    """Modes in parallel, then the lag: share_i / (1 + 2 zeta s/w + s^2/w^2) + rest, times 1 / (1 + lag s)."""
    n = 2 * len(stage.resonance)
    lagging = stage.lag_s > 0
    size = n + int(lagging)
    A, B, c = np.zeros((size, size)), np.zeros(size), np.zeros(size)
    stiff = 1.0
    for i, mode in enumerate(stage.resonance):
        A[2 * i : 2 * i + 2, 2 * i : 2 * i + 2], B[2 * i : 2 * i + 2] = _oscillator(mode.f_Hz, mode.zeta)
        c[2 * i] = mode.share
        stiff -= mode.share
    if not lagging:
        return _exact(A, B, c, stiff, h_s)
    A[-1] = c / stage.lag_s
    A[-1, -1] = -1 / stage.lag_s
    B[-1] = stiff / stage.lag_s
    out = np.zeros(size)
    out[-1] = 1.0
    return _exact(A, B, out, 0.0, h_s)


def amplifier(bandwidth: Bandwidth | None, h_s: Floats) -> Linear:
    """The amplifier's response to its command, unit gain; without states if it is ideal."""
    if bandwidth is None:
        return _exact(np.zeros((0, 0)), np.zeros(0), np.zeros(0), 1.0, h_s)
    if bandwidth.order == 1:
        w = 2 * math.pi * bandwidth.f_Hz
        return _exact(np.array([[-w]]), np.array([w]), np.array([1.0]), 0.0, h_s)
    A, B = _oscillator(bandwidth.f_Hz, bandwidth.zeta)
    return _exact(A, B, np.array([1.0, 0.0]), 0.0, h_s)


def creep_spectrum(creep: Creep | None, h_s: Floats) -> Spectrum:
    """Gauss-Legendre quadrature, in ln(tau), of the continuous spectrum that `Creep` states."""
    if creep is None:
        none = np.zeros((len(h_s), 0))
        return Spectrum(none, none, none, np.zeros(0))
    count = max(6, math.ceil(CREEP_NODES_PER_DECADE * creep.decades))
    place, weight = (np.asarray(part, dtype=np.float64) for part in np.polynomial.legendre.leggauss(count))
    tau_s = creep.tau_min_s * 10 ** (creep.decades * (place + 1) / 2)
    ratio = h_s[:, None] / tau_s
    gone = -np.expm1(-ratio)
    # Exact for a linear input: its begin counts gone/ratio - exp(-ratio), its end 1 - gone/ratio.
    g1 = 1 - gone / ratio
    return Spectrum(np.exp(-ratio), gone - g1, g1, creep.per_decade * creep.decades * weight / 2)


def _oscillator(f_Hz: float, zeta: float) -> tuple[Floats, Floats]:
    """x'' + 2 zeta w x' + w^2 x = w^2 v in the states (x, x'/w)."""
    w = 2 * math.pi * f_Hz
    return np.array([[0.0, w], [-w, -2 * zeta * w]]), np.array([0.0, w])


def _exact(A: Floats, B: Floats, c: Floats, d: float, h_s: Floats) -> Linear:
    """Step x' = A x + B v exactly: one matrix exponential per substep length of [A B 0; 0 0 1/h; 0 0 0]."""
    n = len(B)
    steps: dict[float, tuple[Floats, Floats, Floats]] = {}
    for h in {float(h) for h in h_s} if n else ():
        whole = np.zeros((n + 2, n + 2))
        whole[:n, :n], whole[:n, n] = A * h, B * h
        whole[n, n + 1] = 1.0
        power = expm(whole)
        steps[h] = (power[:n, :n], power[:n, n] - power[:n, n + 1], power[:n, n + 1])
    if not n:
        empty = np.zeros((len(h_s), 0))
        return Linear(np.zeros((len(h_s), 0, 0)), empty, empty, c, np.zeros(0), d)
    phi, g0, g1 = (np.stack([steps[float(h)][i] for h in h_s]) for i in range(3))
    rest: Floats = np.asarray(np.linalg.solve(A, -B), dtype=np.float64)
    return Linear(phi, g0, g1, c, rest, d)
