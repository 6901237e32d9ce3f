"""Each additive term against the physics of its effect."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hysgen.errors import ModelError
from hysgen.model.terms import Drive
from hysgen.model.terms.coupling import Coupling
from hysgen.model.terms.creep import Creep
from hysgen.model.terms.drift import Drift
from hysgen.model.terms.memory import Memory
from hysgen.model.terms.resonance import Resonance

TS_S = 2e-5
Floats = np.ndarray[Any, np.dtype[np.float64]]


def loop_area(u: Floats, phi: Floats) -> float:
    return float(abs(np.sum(0.5 * (phi[1:] + phi[:-1]) * np.diff(u))))


def test_memory_keeps_the_loop_open_however_slow_the_input() -> None:
    plays = Memory((10.0,))
    areas = []
    for period in (2_000, 200_000):
        u = 40 + 30 * np.sin(2 * np.pi * np.arange(2 * period + 1) / period)
        phi = plays.regressors(Drive(u, TS_S))[period:, 0]
        areas.append(loop_area(u[period:], phi))
    # Half-width r under amplitude A: the parallelogram 2 (A - r) * 2 r. The regressor is one sample late, which
    # adds about pi A (A - r) * 2 pi / period: 6 of 800 at 2000 samples.
    exact = 4 * (30 - 10) * 10
    assert areas[1] == pytest.approx(exact, rel=1e-3)
    assert areas[0] == pytest.approx(exact, rel=0.02)


def test_memory_forgets_inner_loops_when_the_input_passes_them() -> None:
    plays = Memory.uniform(8, 50.0)
    direct = np.concatenate([np.linspace(0, 100, 500), np.linspace(100, 20, 400)])
    minor = np.concatenate([np.linspace(100, 50, 200), np.linspace(50, 80, 90)])
    detour = np.concatenate([direct[:500], minor, direct[500:]])
    last = [plays.regressors(Drive(np.append(u, 20.0), TS_S))[-1] for u in (direct, detour)]
    assert np.array_equal(last[0], last[1])


def test_state_after_one_turning_point_is_that_after_decaying_oscillations() -> None:
    plays = Memory.uniform(10, 40.0)
    k = np.arange(200_000)
    demagnetising = 47.0 + 80 * np.exp(-k / 30_000) * np.sin(2 * np.pi * k / 400)
    past = np.append(demagnetising, np.linspace(47.0, 60.0, 100))
    left = plays.regressors(Drive(np.append(past, 60.0), TS_S))[-1]
    # Between two turning points the oscillation shrinks by 2 * 80 * exp(-k/30000) * 200/30000, 1.1 V where it passes r.
    assert np.abs(left - plays.state_after((47.0,), 60.0)).max() < 1.1


def test_memory_settles_where_its_start_no_longer_matters() -> None:
    plays = Memory.uniform(6, 30.0)
    u = 50 + np.concatenate([np.linspace(0, 20, 200), np.linspace(20, -40, 400), np.linspace(-40, 0, 100)])
    burn_in = plays.burn_in(Drive(u, TS_S))
    widest = plays.thresholds_V[-1]
    r = np.array(plays.thresholds_V)
    starts = [np.clip(u[0] + end * widest, u[0] - r, u[0] + r) for end in (-1.0, 1.0)]
    runs = [plays.regressors(Drive(u, TS_S, start={"memory": start})) for start in starts]
    assert 200 < burn_in < 600
    assert np.array_equal(runs[0][burn_in:], runs[1][burn_in:])
    assert not np.array_equal(runs[0][burn_in - 1], runs[1][burn_in - 1])
    assert plays.burn_in(Drive(u[:150], TS_S)) == 150


def test_creep_step_response_is_a_sum_of_exponentials() -> None:
    taus = (0.01, 0.1, 1.0)
    u = np.full(100_000, 10.0)
    u[0] = 0.0
    phi = Creep(taus).regressors(Drive(u, TS_S))
    t = TS_S * (np.arange(u.size) - 1)
    for j, tau in enumerate(taus):
        # 1e5 float64 additions of numbers up to 10 lose less than 1e5 * 1e-16 * 10.
        assert np.abs(phi[1:, j] - 10 * -np.expm1(-t[1:] / tau)).max() < 1e-10


def test_creep_with_one_weight_goes_on_by_the_same_in_every_decade() -> None:
    term = Creep.log_spaced(9, 1e-3, 10.0, shared=True)
    u = np.full(200_000, 100.0)
    u[0] = 0.0
    phi = term.regressors(Drive(u, TS_S))
    free = Creep(term.tau_s).regressors(Drive(u, TS_S))
    assert np.abs(phi[:, 0] - free.mean(axis=1)).max() < 1e-12
    decades = phi[np.rint(np.array([0.003, 0.03, 0.3]) / TS_S).astype(int) + 1, 0]
    # Two lags per decade, each a ninth of the step; what lags beyond 10 s would have added is below 1 % until 0.3 s.
    assert np.diff(decades) == pytest.approx(np.full(2, 100 * 2 / 9), rel=0.01)
    system = term.linear(TS_S)
    assert system.C.shape == (1, 9)
    assert system.C.sum() == pytest.approx(1.0)
    assert term.size == len(term.gains(TS_S)) == 1
    assert Creep.from_json(term.to_json()) == term
    assert term.with_shape(term.shape()).shared


def test_creep_at_rest_under_the_first_input_does_not_move() -> None:
    phi = Creep.log_spaced(4, 1e-2, 100.0).regressors(Drive(np.full(1000, 63.7), TS_S))
    assert np.array_equal(phi, np.full((1000, 4), 63.7))


@pytest.mark.parametrize(("f_Hz", "zeta"), [(50.0, 0.01), (50.0, 0.3), (713.0, 0.002), (9000.0, 0.05)])
def test_resonance_rings_at_its_frequency_and_damping(f_Hz: float, zeta: float) -> None:
    u = np.zeros(int(6 / (f_Hz * TS_S)) + 2)
    u[0] = 1.0
    phi = Resonance((f_Hz,), (zeta,)).regressors(Drive(u, TS_S, start={"resonance": np.zeros(2)}))
    # Position and velocity form a spiral: its angle turns at the damped frequency, its logarithm falls at zeta w.
    spiral = phi[1:, 0] - 1j * phi[1:, 1]
    ratio = spiral[1:] / spiral[:-1]
    pole = np.log(ratio.mean()) / TS_S
    assert np.abs(ratio - ratio.mean()).max() < 1e-9
    assert abs(pole) / (2 * np.pi) == pytest.approx(f_Hz, rel=1e-9)
    assert -pole.real / abs(pole) == pytest.approx(zeta, rel=1e-7)


def test_resonance_is_the_exact_answer_of_an_oscillator_to_a_held_input() -> None:
    f_Hz, zeta = 640.0, 0.03
    w = 2 * np.pi * f_Hz
    rng = np.random.default_rng(5)
    held = rng.uniform(-1, 1, 60)
    u = np.repeat(held, 50)
    phi = Resonance((f_Hz,), (zeta,)).regressors(Drive(u, TS_S, start={"resonance": np.zeros(2)}))
    # Runge-Kutta of x'' + 2 zeta w x' + w^2 x = w^2 u with 40 steps per sample: error below 1e-9.
    h, x, v, track = TS_S / 40, 0.0, 0.0, []

    def slope(x: float, v: float, u: float) -> tuple[float, float]:
        return v, w * w * (u - x) - 2 * zeta * w * v

    for drive in u:
        track.append((x, v))
        for _ in range(40):
            a1, b1 = slope(x, v, drive)
            a2, b2 = slope(x + 0.5 * h * a1, v + 0.5 * h * b1, drive)
            a3, b3 = slope(x + 0.5 * h * a2, v + 0.5 * h * b2, drive)
            a4, b4 = slope(x + h * a3, v + h * b3, drive)
            x += h * (a1 + 2 * a2 + 2 * a3 + a4) / 6
            v += h * (b1 + 2 * b2 + 2 * b3 + b4) / 6
    position, velocity = np.array(track).T
    assert np.abs(phi[:, 0] - (position + zeta * velocity / w)).max() < 1e-8
    assert np.abs(phi[:, 1] - np.sqrt(1 - zeta**2) * velocity / w).max() < 1e-8


def test_resonance_too_slow_for_float32_is_refused() -> None:
    with pytest.raises(ModelError, match="does not decay in float32"):
        Resonance((20_000.0,), (1e-4,)).constants(1e-20)


def test_coupling_counts_a_channel_beyond_its_range_as_at_its_edge() -> None:
    term = Coupling(("t",), (20.0,), (24.0,), taps=2)
    phi = term.regressors(Drive(np.zeros(4), TS_S, {"t": np.array([21.0, 30.0, -5.0, 22.0])}))
    assert phi.tolist() == [[-1.0, 0.0], [2.0, -1.0], [-2.0, 2.0], [0.0, -2.0]]


def test_coupling_holds_the_last_finite_sample() -> None:
    mirror = Coupling(("t",), (20.0,), (24.0,)).mirror(np.zeros(1, dtype=np.float32), TS_S)
    seen = []
    for value in (21.0, np.nan, np.inf, -np.inf, 23.0):
        mirror.listen({"t": np.array([value], dtype=np.float32)})
        seen.append(float(mirror.regressors()[0][0]))
        mirror.advance(np.zeros(1, dtype=np.float32))
    assert seen == [-1.0, -1.0, -1.0, -1.0, 1.0]


def test_coupling_names_the_channel_that_a_record_lacks() -> None:
    with pytest.raises(ModelError, match="channel 't' is not in the record; it has x"):
        Coupling(("t",), (0.0,), (1.0,)).regressors(Drive(np.zeros(4), TS_S, {"x": np.zeros(4)}))


def test_drift_follows_a_step_of_the_error_with_its_time_constant_and_is_held_without_measurements() -> None:
    term, n = Drift(0.01, 0.5), 3000
    errors = np.where(np.arange(n) >= 100, 0.2, 0.0)
    bias = term.regressors(Drive(np.zeros(n), TS_S, innovation_um=errors))[:, 0]
    k = np.arange(n)
    assert np.abs(bias - np.where(k >= 100, 0.2 * -np.expm1(-(k - 99) * TS_S / 0.01), 0.0)).max() < 1e-12
    held = term.regressors(Drive(np.zeros(10), TS_S, start={"drift": bias[-1:]}))
    assert np.array_equal(held, np.full((10, 1), bias[-1]))


def test_drift_uses_past_samples_only() -> None:
    term, rng = Drift(0.01, 0.5), np.random.default_rng(2)
    errors = rng.normal(0, 0.1, 500)
    later = errors.copy()
    later[300:] += 1.0
    a, b = (term.regressors(Drive(np.zeros(500), TS_S, innovation_um=e)) for e in (errors, later))
    # b(k) is corrected by y(k), which is measured before y(k+1) is predicted.
    assert np.array_equal(a[:300], b[:300])
    assert not np.array_equal(a[300], b[300])


def test_drift_stays_within_its_limit_in_float32() -> None:
    mirror = Drift(1e-4, 0.25).mirror(np.zeros(2, dtype=np.float32), TS_S)
    for _ in range(200):
        mirror.correct(np.array([1e3, -1e3], dtype=np.float32))
    assert [float(bias) for bias in mirror.regressors()[0]] == [0.25, -0.25]
    mirror.correct(np.array([-0.1, 0.1], dtype=np.float32))
    assert abs(float(mirror.regressors()[0][0])) < 0.25


def test_plays_with_polynomials_follow_a_preisach_density_that_plays_alone_do_not() -> None:
    u = np.concatenate([level + size * np.sin(np.linspace(0, 6 * np.pi, 600)) for level, size in LOOPS])
    r = np.linspace(0.02, 0.98, 60) * 50.0
    plays = Memory(tuple(r)).regressors(Drive(u, TS_S, start={"memory": np.zeros(60)}))
    # A density that falls with the level: loops are smaller high up than low down.
    target = (plays - 0.004 * plays**2) @ np.exp(-r / 20.0)
    left = []
    for degree in (1, 2, 3):
        phi = Memory.polynomial(6, degree, -50.0, 50.0).regressors(Drive(u, TS_S, start={"memory": np.zeros(6)}))
        phi = np.column_stack([phi, u**0, u, u**2])
        left.append(float(np.std(target - phi @ np.linalg.lstsq(phi, target, rcond=None)[0])))
    assert left[1] < 0.3 * left[0]
    assert left[2] <= left[1]


LOOPS = ((0.0, 50.0), (20.0, 25.0), (-25.0, 20.0), (30.0, 15.0), (0.0, 10.0), (-30.0, 15.0))


def test_gain_of_a_polynomial_play_is_its_steepest_slope_and_no_more() -> None:
    plays = Memory.polynomial(4, 3, -20.0, 60.0)
    u = np.concatenate([np.linspace(-20.0, 60.0, 4001), np.linspace(60.0, -20.0, 4001)])
    phi = plays.regressors(Drive(u, TS_S))
    steepest = np.abs(np.diff(phi, axis=0)).max(axis=0) / np.abs(np.diff(u)).max()
    bounds = np.array(plays.gains(TS_S))
    assert (steepest <= bounds * (1 + 1e-9)).all()
    assert (steepest > 0.97 * bounds).all()  # 4000 steps resolve the steepest place of T_3 to 1 %
