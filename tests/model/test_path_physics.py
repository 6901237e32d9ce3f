"""Creep and modes against the physics of their effects; test_hysteresis_block.py has the hysteresis."""

import numpy as np
import pytest

from hysgen.errors import ModelError
from hysgen.machine.kernels.operators import mode_states
from hysgen.model.intervals import Interval
from hysgen.model.path.base import InputBlock
from hysgen.model.path.creep import Creep
from hysgen.model.path.modes import Modes
from hysgen.model.path.structure import Structure

TS_S = 2e-5


def test_creep_after_a_step_is_a_sum_of_exponentials() -> None:
    block = Creep(0.02, (0.01, 0.1, 1.0))
    u = np.full(100_000, 10.0)
    u[0] = 0.0
    t = TS_S * (np.arange(1, u.size) - 1)
    exact = 10.0 + 0.02 * sum(10.0 * -np.expm1(-t / tau) for tau in block.tau_s)
    # 1e5 float64 additions of numbers up to 10 lose less than 1e5 * 1e-16 * 10.
    assert np.abs(block.apply(u, TS_S)[1:] - exact).max() < 1e-10


@pytest.mark.parametrize(("f_Hz", "zeta"), [(50.0, 0.01), (50.0, 0.3), (713.0, 0.002), (9000.0, 0.05)])
def test_a_mode_rings_at_its_frequency_and_damping(f_Hz: float, zeta: float) -> None:
    u = np.zeros(int(6 / (f_Hz * TS_S)) + 2)
    u[0] = 1.0
    states = mode_states(u, Modes((f_Hz,), (zeta,), (1.0,), 4e-4).steps(TS_S), np.zeros(2))
    # Position and velocity form a spiral: its angle turns at the damped frequency, its logarithm falls at zeta w.
    spiral = states[1:, 0] - 1j * states[1:, 1]
    ratio = spiral[1:] / spiral[:-1]
    pole = np.log(ratio.mean()) / TS_S
    assert np.abs(ratio - ratio.mean()).max() < 1e-9
    assert abs(pole) / (2 * np.pi) == pytest.approx(f_Hz, rel=1e-9)
    assert -pole.real / abs(pole) == pytest.approx(zeta, rel=1e-7)


@pytest.mark.slow
def test_modes_behind_which_the_rules_lag_are_the_exact_answer_to_a_held_input() -> None:
    f_Hz, zeta, share, lag_s = 640.0, 0.03, 0.3, 4e-4
    w0, a = 2 * np.pi * f_Hz, np.exp(-TS_S / lag_s)
    u = np.repeat(np.random.default_rng(5).uniform(-1, 1, 60), 50)
    w = Modes((f_Hz,), (zeta,), (share,), lag_s).apply(u, TS_S, np.zeros(2))
    y = np.zeros(u.size)
    for k in range(u.size - 1):
        y[k + 1] = a * y[k] + (1 - a) * w[k]
    # Runge-Kutta of osc'' + 2 zeta w0 osc' + w0^2 osc = w0^2 u and tau y' = (1 - q) u + q osc - y, 40 steps a sample.
    h, x, exact = TS_S / 40, np.zeros(3), np.zeros(u.size)

    def slope(x: np.ndarray, u: float) -> np.ndarray:
        return np.array([x[1], w0 * w0 * (u - x[0]) - 2 * zeta * w0 * x[1], (u + share * (x[0] - u) - x[2]) / lag_s])

    for k, held in enumerate(u):
        exact[k] = x[2]
        for _ in range(40):
            s1 = slope(x, held)
            s2 = slope(x + 0.5 * h * s1, held)
            s3 = slope(x + 0.5 * h * s2, held)
            x = x + h * (s1 + 2 * s2 + 2 * s3 + slope(x + h * s3, held)) / 6
    assert np.abs(y - exact).max() < 1e-9


def test_modes_that_float32_cannot_hold_are_refused() -> None:
    with pytest.raises(ModelError, match="does not decay in float32"):
        Modes((20_000.0,), (1e-4,), (0.3,), 4e-4).constants(1e-20)
    with pytest.raises(ModelError, match="30000 Hz lies beyond half the sampling frequency, 25000 Hz"):
        Modes((30_000.0,), (0.1,), (0.3,), 4e-4).constants(TS_S)


@pytest.mark.parametrize(
    "block",
    [
        Modes((150.0,), (0.01,), (0.8,), 1e-3),
        Modes((150.0,), (0.01,), (0.8,), 1e-3, early_s=1e-4),
        Modes((150.0, 2100.0), (0.02, 0.05), (1.7, -0.9), 4e-4),
        Structure((150.0, 900.0), (0.02, 0.05), (0.7, 0.2), 4e-4, (0.1, -0.2), TS_S),
        Creep(0.02, (1e-3, 0.01)),
    ],
    ids=["mode", "early", "modes", "structure", "creep"],
)
def test_the_worst_command_reaches_most_of_the_range_of_w_and_never_leaves_it(block: InputBlock) -> None:
    """w is limited to this range, in Python and in C: what a command of the range can make of a mode is inside it."""
    impulse = np.zeros(60_000)
    impulse[1] = 1.0
    worst = np.where(block.apply(impulse, TS_S)[::-1] > 0.0, 1.0, -1.0)
    w, limits = block.apply(worst, TS_S), block.image(Interval(-1.0, 1.0))
    assert limits.low <= w.min()
    assert w.max() <= limits.high
    assert w[-2:].max() > 0.6 * limits.high
