"""The identification of a structure finds the modes of a stage that it shares no code with, in both kinds of record."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.linalg import expm

from hysgen.errors import FitError
from hysgen.fitting.loop import _Task
from hysgen.fitting.structure import _seen, _slopes, identify_structure, pieces_of
from hysgen.model.path.modes import LEAST_DAMPING, MOST_DAMPING

Floats = NDArray[np.float64]

TS_S = 1.0 / 6400.0
F_HZ, ZETA = np.array([641.0, 814.0, 1325.0, 2133.0]), np.array([0.010, 0.012, 0.008, 0.011])
SHAPES = np.array([[1.0, 0.4], [-0.7, 0.9], [0.3, 0.6], [0.2, -0.5]])


def masses(v: Floats, start: Floats | None = None) -> tuple[Floats, Floats]:
    """(n,) sum of q'' + 2 zeta w q' + w^2 q = w^2 shape' v for held inputs v, (2, n), and the last state."""
    w = 2.0 * np.pi * F_HZ
    zero, eye = np.zeros((4, 4)), np.eye(4)
    A = np.block([[zero, eye], [-np.diag(w**2), -np.diag(2.0 * ZETA * w)]])
    whole = np.zeros((10, 10))
    whole[:8, :8], whole[:8, 8:] = A, np.vstack([np.zeros((4, 2)), w[:, None] ** 2 * SHAPES])
    step = expm(whole * TS_S)
    x = np.zeros(8) if start is None else start
    y = np.empty(v.shape[1])
    for k in range(v.shape[1]):
        y[k] = x[:4].sum()
        x = step[:8, :8] @ x + step[:8, 8:] @ v[:, k]
    return y, x


def held_noise(rng: np.random.Generator, samples: int) -> Floats:
    return np.repeat(rng.standard_normal((2, samples // 3 + 1)), 3, axis=1)[:, :samples]


def periodic(rng: np.random.Generator, period: int) -> tuple[Floats, Floats]:
    """Two periods of a steady state."""
    v = held_noise(rng, period)
    _, settled = masses(np.tile(v, 4))
    return np.tile(v, 2), masses(np.tile(v, 2), settled)[0]


@pytest.mark.parametrize("kind", ["periods", "rows"])
def test_frequencies_and_dampings_are_found_from_two_drives_under_noise(kind: str) -> None:
    rng = np.random.default_rng(5)
    if kind == "periods":
        parts = [periodic(rng, 2048) for _ in range(3)]
    else:
        v = held_noise(rng, 9000)
        parts = [(v, masses(v)[0])]
    noise = 0.01 * float(np.std(parts[0][1]))
    measured = [y + 3.0 + noise * rng.standard_normal(y.size) for _, y in parts]
    found = identify_structure([v for v, _ in parts], measured, TS_S)
    for f_Hz, zeta in zip(F_HZ, ZETA, strict=True):
        m = int(np.argmin(np.abs(found.f_Hz - f_Hz)))
        # Five standard errors: one false alarm in a million. 1 % of noise over 9000 rows leaves 3e-4 of a frequency.
        assert abs(found.f_Hz[m] - f_Hz) < 5.0 * found.f_error_Hz[m] < 5.0 * 3e-4 * f_Hz
        assert found.zeta[m] == pytest.approx(zeta, rel=0.05)
    fresh = held_noise(rng, 3000)
    error = found.simulate(fresh)[600:] - masses(fresh)[0][600:] - 3.0
    assert float(np.sqrt(np.mean(error**2))) < noise


def test_a_mode_that_the_record_does_not_support_is_left_out() -> None:
    rng = np.random.default_rng(6)
    v = held_noise(rng, 9000)
    y = masses(v)[0]
    found = identify_structure([v], [y + 0.01 * float(np.std(y)) * rng.standard_normal(y.size)], TS_S)
    assert len(found.poles) <= 6


def test_too_few_rows_are_refused() -> None:
    v = held_noise(np.random.default_rng(7), 1000)
    with pytest.raises(FitError, match="give a longer record"):
        identify_structure([v], [masses(v)[0]], TS_S)


@pytest.mark.parametrize("periods", [2, 1])
def test_the_jacobian_is_the_derivative_of_the_free_run(periods: int) -> None:
    rng = np.random.default_rng(8)
    v = np.tile(held_noise(rng, 600), periods)
    [piece] = pieces_of([v], [masses(v)[0]], 50)
    poles, gains = np.array([0.6 + 0.7j, -0.4 + 0.8j]), rng.standard_normal((2, 2)) + 1j * rng.standard_normal((2, 2))
    slopes, _ = _slopes(piece, poles, gains)
    numbers = np.concatenate([poles, gains.ravel()])
    for i, slope in enumerate(slopes):
        step = np.zeros_like(numbers)
        step[i // 2] = 1e-6 * (1j if i % 2 else 1.0)
        ends = [(numbers + sign * step) for sign in (1.0, -1.0)]
        high, low = (_seen(piece, end[:2], end[2:].reshape(2, 2)) for end in ends)
        # Central differences of step 1e-6: 1e-12 of curvature, 1e-10 of rounding.
        assert slope == pytest.approx((high - low) / 2e-6, abs=1e-6 * float(np.abs(slope).max()))


@given(st.floats(-9.0, 2.0), st.floats(-1.0, 4.0))
def test_a_mode_beside_a_loop_is_one_that_a_block_takes(sigma: float, omega: float) -> None:
    """A broad state of 0 Hz, which the fit of a mode that moves leaves beside it, ended in a refusal of the block."""
    task = _Task([], [], np.zeros(0, dtype=np.bool_), 1, 1, 1.0)
    rate = task.admitted(np.array([sigma, omega, *np.zeros(8)]))[:2].view(np.complex128)[0]
    assert LEAST_DAMPING < -rate.real / abs(rate) < MOST_DAMPING
    assert 0.0 < rate.imag < np.pi
