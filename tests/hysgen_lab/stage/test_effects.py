"""Every effect of the virtual stage is what its name says, by its amplitude and units, and nothing else."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import welch

from hysgen_lab.stage import (
    CreepEffect,
    DelayEffect,
    NoiseEffect,
    PeriodicEffect,
    Stage,
    StageError,
    StickSlipEffect,
    run,
)
from hysgen_lab.stage.effects.amplifier import BandwidthEffect
from hysgen_lab.stage.effects.readings import DriftEffect

Floats = NDArray[np.float64]
TS_S = 20e-6
# Proportional, without lag, ideal converters: what remains is the effect under test.
BARE = Stage(lag_s=0.0, dac_bits=0, memory=None).quiet()
GAIN = 10.0 / 120.0


def sine(f_Hz: float, n: int, centre_V: float = 50.0, amplitude_V: float = 20.0, Ts_s: float = TS_S) -> Floats:
    return centre_V + amplitude_V * np.sin(2 * np.pi * f_Hz * Ts_s * np.arange(n))


def phasor(y: Floats, f_Hz: float, Ts_s: float = TS_S) -> complex:
    """Amplitude and phase of the line f_Hz in y by least squares with a constant: y ~ Im(phasor exp(j w t))."""
    w_t = 2 * np.pi * f_Hz * Ts_s * np.arange(len(y))
    (s, c, _), *_ = np.linalg.lstsq(np.stack([np.sin(w_t), np.cos(w_t), np.ones(len(y))], axis=1), y, rcond=None)
    return complex(s, c)


def test_creep_moves_on_after_a_step_along_its_closed_form() -> None:
    creep = CreepEffect(0.03)
    Ts_s = 0.01
    u_V = np.full(2001, 60.0)
    y_um = run(BARE.with_effects(creep=creep), u_V, Ts_s, rest_V=0.0).displacement_um[1:]
    t_s = Ts_s * np.arange(1, len(u_V))
    # The quadrature of the spectrum is good to 1e-7 of the creep's size, 0.15 of the step.
    np.testing.assert_allclose(y_um, 5.0 * (1 + creep.moved(t_s)), atol=5.0 * 0.15 * 1e-7)


def test_creep_gains_the_same_in_every_decade() -> None:
    Ts_s = 0.01
    y_um = run(BARE.with_effects(creep=0.03), np.full(1001, 60.0), Ts_s, rest_V=0.0).displacement_um
    decades = np.diff(y_um[[10, 100, 1000]]) / 5.0  # 0.1 s, 1 s, 10 s
    # 10 s is a hundredth of the slowest relaxation: exp1's next term, 0.01 / ln 10, is missing from the last decade.
    np.testing.assert_allclose(decades, 0.03, rtol=0.006)


def test_creep_counts_from_the_rest_before_the_record() -> None:
    y_um = run(BARE.with_effects(creep=0.03), np.full(2000, 60.0), 0.1).displacement_um
    # Nothing moves; rounding of some thirty relaxations.
    np.testing.assert_allclose(y_um, 5.0, atol=1e-12)


@pytest.mark.parametrize(("f_Hz", "zeta"), [(780.0, 0.02), (150.0, 0.1)])
def test_resonance_rings_at_its_frequency_with_its_damping(f_Hz: float, zeta: float) -> None:
    n = round(12 / f_Hz / TS_S)
    y_um = run(BARE.with_effects(resonance=(f_Hz, zeta)), np.full(n, 12.0), TS_S, rest_V=0.0).displacement_um - 1.0
    k = np.flatnonzero((y_um[1:-1] > y_um[:-2]) & (y_um[1:-1] >= y_um[2:])) + 1
    bend = y_um[k - 1] - 2 * y_um[k] + y_um[k + 1]
    shift = (y_um[k - 1] - y_um[k + 1]) / (2 * bend)
    peaks = y_um[k] - (y_um[k - 1] - y_um[k + 1]) * shift / 4
    damped_Hz = 1 / (np.mean(np.diff(k + shift)) * TS_S)
    decrement = float(np.mean(np.log(peaks[:-1] / peaks[1:])))
    # Peaks are read off a parabola through three samples, 64 or more to a period: 1e-3.
    assert damped_Hz == pytest.approx(f_Hz * math.sqrt(1 - zeta**2), rel=1e-3)
    assert decrement / math.hypot(2 * math.pi, decrement) == pytest.approx(zeta, rel=1e-2)


def test_a_mode_carries_its_share_and_the_rest_follows_stiffly() -> None:
    y_um = run(BARE.with_effects(resonance=(780.0, 0.02, 0.25)), np.full(100, 12.0), TS_S, rest_V=0.0).displacement_um
    assert y_um[1] == pytest.approx(0.75, abs=0.01)  # the mode has hardly moved after 20 us: (w t)^2 / 8 = 1e-3
    assert y_um.max() == pytest.approx(0.75 + 0.25 * (1 + math.exp(-math.pi * 0.02)), abs=1e-3)


@pytest.mark.parametrize("samples", [1.0, 1.6, 0.35, 7.93])
def test_delay_is_late_by_its_fraction_of_a_sample(samples: float) -> None:
    stage = Stage.nominal().quiet()
    u_V = sine(100.0, 5000)
    early = phasor(run(stage, u_V, TS_S).displacement_um[1000:], 100.0)
    late = phasor(run(stage.with_effects(delay=samples), u_V, TS_S).displacement_um[1000:], 100.0)
    lag = -np.angle(late / early) / (2 * np.pi * 100.0 * TS_S)
    # The plant is sampled elsewhere between the same D/A instants, whose staircase ripples by a few 1e-3 of a sample.
    assert lag == pytest.approx(samples, abs=0.01)


def test_delay_in_seconds_is_the_same_at_every_rate() -> None:
    assert run(
        BARE.with_effects(delay=DelayEffect(seconds=3e-3)), np.full(9, 12.0), 1e-3, rest_V=0.0
    ).displacement_um.tolist() == [*(0.0,) * 4, *(1.0,) * 5]


def test_saturation_clips_at_its_levels() -> None:
    u_V = sine(10.0, 10000, 50.0, 60.0)
    measured = run(BARE.with_effects(saturation=(2.5, 91.0)), u_V, TS_S)
    assert (measured.voltage_V == u_V).all()  # the record holds the command
    assert measured.truth.actuator_V.min() == 2.5
    assert measured.truth.actuator_V.max() == 91.0
    inside = (u_V[:-1] > 2.5) & (u_V[:-1] < 91.0)
    assert (measured.truth.actuator_V[1:][inside] == u_V[:-1][inside]).all()


def test_slew_limits_the_rate_and_only_the_rate() -> None:
    u_V = np.full(600, 50.0)
    volts = run(BARE.with_effects(slew=2e4), u_V, TS_S, rest_V=0.0).truth.actuator_V
    np.testing.assert_allclose(np.diff(volts)[:124], 2e4 * TS_S, rtol=1e-9)  # 0.4 V a sample, up to 49.6 V
    assert volts[-1] == 50.0
    # A command that leaves 20 us for each 0.26 V arrives before the next.
    slow_V = sine(100.0, 2000, 50.0, 20.0)
    assert (run(BARE.with_effects(slew=2e4), slow_V, TS_S).truth.actuator_V[1:] == slow_V[:-1]).all()


def test_bandwidth_of_first_order_is_its_exponential() -> None:
    u_V = np.full(200, 10.0)
    volts = run(BARE.with_effects(bandwidth=2000.0), u_V, TS_S, rest_V=0.0).truth.actuator_V
    t_s = TS_S * np.arange(200)
    np.testing.assert_allclose(volts, 10.0 * (1 - np.exp(-2 * np.pi * 2000.0 * t_s)), atol=1e-12)


def test_bandwidth_of_second_order_overshoots_as_its_damping_says() -> None:
    stage = BARE.with_effects(bandwidth=BandwidthEffect(500.0, order=2, zeta=0.4))
    volts = run(stage, np.full(400, 10.0), TS_S, rest_V=0.0).truth.actuator_V
    # 100 samples to a period: the peak is missed by at most (pi/100)^2 / 2 of the overshoot.
    assert volts.max() / 10.0 - 1 == pytest.approx(math.exp(-math.pi * 0.4 / math.sqrt(1 - 0.16)), abs=2e-4)


def test_drift_ramps_and_wanders_whatever_the_input() -> None:
    stage = BARE.with_effects(drift=DriftEffect(ramp_um_per_s=0.02, walk_um_per_rt_s=0.01))
    n, Ts_s = 20_000, 1e-3
    still = run(stage, np.full(n, 20.0), Ts_s, seed=5)
    moved = run(stage, sine(3.0, n, Ts_s=Ts_s), Ts_s, seed=5)
    assert (still.truth.drift_um == moved.truth.drift_um).all()
    np.testing.assert_allclose(still.displacement_um, 20.0 * GAIN + still.truth.drift_um, atol=1e-12)
    steps = np.diff(still.truth.drift_um)
    # 20 000 normal steps: their spread is known to 1/sqrt(2 n) of itself; five of these.
    assert steps.std() == pytest.approx(0.01 * math.sqrt(Ts_s), rel=5 / math.sqrt(2 * n))
    ramp = run(BARE.with_effects(drift=0.02), np.full(n, 20.0), Ts_s).truth.drift_um
    np.testing.assert_allclose(ramp, 0.02 * Ts_s * np.arange(n), atol=1e-9)


def test_periodic_lines_have_their_frequency_and_amplitude() -> None:
    stage = BARE.with_effects(periodic=[PeriodicEffect(49.7, 0.012, 0.3), PeriodicEffect(17.0, 0.004)])
    y_um = run(stage, np.full(10_000, 20.0), 1e-3).displacement_um - 20.0 * GAIN
    t_s = 1e-3 * np.arange(10_000)
    expected = 0.012 * np.sin(2 * np.pi * 49.7 * t_s + 0.3) + 0.004 * np.sin(2 * np.pi * 17.0 * t_s)
    np.testing.assert_allclose(y_um, expected, atol=1e-9)


def test_aging_changes_the_gain_over_its_time_and_then_stays() -> None:
    y_um = run(BARE.with_effects(aging=(-0.08, 2.0)), np.full(4001, 60.0), 1e-3).displacement_um
    t_s = 1e-3 * np.arange(4001)
    np.testing.assert_allclose(y_um, 5.0 * (1 - 0.08 * np.minimum(t_s / 2.0, 1.0)), atol=1e-9)


def test_outliers_are_single_and_touch_nothing_else() -> None:
    n, rate = 100_000, 0.02
    u_V = sine(100.0, n)
    clean, corrupted = (
        run(s, u_V, TS_S, 7) for s in (Stage.nominal(), Stage.nominal().with_effects(outliers=(rate, 0.2)))
    )
    at = corrupted.truth.outlier
    assert (clean.displacement_um[~at] == corrupted.displacement_um[~at]).all()
    size_um = np.abs(clean.displacement_um - corrupted.displacement_um)[at]
    assert size_um.min() >= 0.1 - 0.0005  # half the size, less one step of the sensor
    assert size_um.max() <= 0.3 + 0.0005
    assert not (at[1:] & at[:-1]).any()
    # One that would follow another is left out: a share `rate` of them.
    assert at.sum() == pytest.approx(rate * (1 - rate) * n, abs=5 * math.sqrt(rate * n))


def test_coupling_bends_this_axis_through_the_same_lag() -> None:
    stage = Stage(memory=None).quiet().with_effects(coupling={"axis2_V": 0.004})
    other = np.concatenate([np.zeros(100), np.full(900, 25.0)])
    y_um = run(stage, np.full(1000, 20.0), TS_S, aux={"axis2_V": other, "spare": other}).displacement_um - 20.0 * GAIN
    t_s = TS_S * (np.arange(1000) - 100)
    expected = np.where(t_s > 0, 0.1 * (1 - np.exp(-t_s / 1e-3)), 0.0)
    # The D/A puts 20 V out to half of its step, 0.07 mV.
    np.testing.assert_allclose(y_um, expected, atol=7e-5 * GAIN)
    with pytest.raises(StageError, match="axis2_V, which is not given"):
        run(stage, np.full(1000, 20.0), TS_S)


def test_stick_slip_sticks_and_jumps() -> None:
    stage = BARE.with_effects(stick_slip=StickSlipEffect(0.05, left=0.2, scatter=0.3))
    u_V = sine(1.0, 4000, 50.0, 20.0, 1e-3)
    y_um = run(stage, u_V, 1e-3, seed=3).displacement_um
    follows = GAIN * np.concatenate([u_V[:1], u_V[:-1]])
    jumps = np.abs(np.diff(y_um))
    assert np.abs(y_um - follows).max() <= 0.05 * 1.3 + 1e-12
    assert (jumps == 0).mean() > 0.8
    assert jumps[jumps > 0].min() > 0.8 * 0.05 * 0.7 - 1e-12
    # 6.7 um of way a period in jumps of about 0.04 um: some 160 in each of four.
    assert 400 < (jumps > 0).sum() < 900


def test_gain_step_multiplies_the_command_from_its_instant_on() -> None:
    u_V = sine(100.0, 400)
    y_um = run(BARE.with_effects(gain_step=(0.05, 200 * TS_S)), u_V, TS_S).displacement_um
    # The command of row k acts on row k + 1; the call for the rest before the record is the first.
    ratio = y_um[1:] / (GAIN * u_V[:-1])
    np.testing.assert_allclose(ratio[:198], 1.0, atol=1e-12)
    np.testing.assert_allclose(ratio[200:], 1.05, atol=1e-12)


@pytest.mark.slow
def test_chirp_passes_through_its_frequencies_with_its_amplitude() -> None:
    y_um = run(BARE.with_effects(chirp=(100.0, 400.0, 1.0, 0.02)), np.full(50_000, 60.0), TS_S).displacement_um - 5.0
    assert np.ptp(y_um) == pytest.approx(0.04, rel=1e-3)
    crossings = np.flatnonzero((y_um[1:] > 0) & (y_um[:-1] <= 0)) * TS_S
    t_s = 0.5 * (crossings[1:] + crossings[:-1])
    np.testing.assert_allclose(1 / np.diff(crossings), 100.0 + 300.0 * t_s, rtol=0.02)


def test_jumps_stay_where_they_went() -> None:
    y_um = run(BARE.with_effects(jumps=(0.01, 0.1)), np.full(5000, 60.0), TS_S, seed=3).displacement_um
    steps = np.abs(np.diff(y_um))
    assert 25 < np.count_nonzero(steps) < 80
    assert ((steps == 0.0) | ((steps > 0.05 - 1e-12) & (steps < 0.15 + 1e-12))).all()


@pytest.mark.slow
def test_creep_by_a_power_law_gains_by_its_power_from_decade_to_decade() -> None:
    Ts_s, creep = 0.1, CreepEffect(0.03, 1e-4, 1e6, 0.25)
    y_um = run(BARE.with_effects(creep=creep), np.full(10_001, 60.0), Ts_s, rest_V=0.0).displacement_um
    decades = np.diff(y_um[[10, 100, 1000, 10_000]])
    # Far from both cut-offs the gain of a decade is proportional to t^p; cut-offs four decades away leave 3 %.
    np.testing.assert_allclose(decades[1:] / decades[:-1], 10**0.25, rtol=0.03)


def test_white_noise_has_its_spread_and_no_memory() -> None:
    n = 100_000
    y_um = run(BARE.with_effects(noise=0.003), np.full(n, 20.0), TS_S).displacement_um
    y_um = y_um - y_um.mean()
    # Five standard errors of the spread, and of the correlation of neighbours.
    assert y_um.std() == pytest.approx(0.003, rel=5 / math.sqrt(2 * n))
    assert abs(np.mean(y_um[1:] * y_um[:-1])) / 0.003**2 < 5 / math.sqrt(n)


def test_sources_of_chance_are_independent() -> None:
    n = 100_000
    stage = BARE.with_effects(noise=0.003, drift=(0.0, 0.01))
    measured = run(stage, np.full(n, 20.0), TS_S, seed=4)
    noise, walk = measured.displacement_um - measured.truth.true_um, np.diff(measured.truth.drift_um)
    for shift in (-1, 0, 1):
        shifted = np.roll(noise, shift)[1:]
        assert abs(np.corrcoef(shifted, walk)[0, 1]) < 5 / math.sqrt(n)  # five standard errors


def test_flicker_noise_falls_by_ten_decibels_a_decade() -> None:
    y_um = run(BARE.with_effects(noise=NoiseEffect(0.0, 0.002)), np.full(2**18, 20.0), TS_S, seed=2).displacement_um
    f_Hz, density = welch(y_um, 1 / TS_S, nperseg=2**14)
    band = (f_Hz > 5.0) & (f_Hz < 2000.0)
    slope = np.polyfit(np.log10(f_Hz[band]), np.log10(density[band]), 1)[0]
    assert slope == pytest.approx(-1.0, abs=0.1)  # one relaxation per decade ripples around 1/f


def test_every_effect_switches_off_without_a_trace() -> None:
    u_V = sine(100.0, 2000)
    base = run(Stage.nominal(), u_V, TS_S, 1).displacement_um
    for name, value in EVERY.items():
        stage = Stage.nominal().with_effects(**{name: value})
        assert name in stage.active
        aux = {"axis2_V": np.ones(2000)}
        assert (run(stage, u_V, TS_S, 1, aux).displacement_um != base).any(), name
        off = stage.with_effects(**{name: None})
        assert off == Stage.nominal()
        assert (run(off, u_V, TS_S, 1, aux).displacement_um == base).all(), name


EVERY: dict[str, object] = {
    "bandwidth": 5e3,
    "saturation": (0.0, 60.0),
    "slew": 5e3,
    "creep": 0.03,
    "resonance": (780.0, 0.02),
    "delay": 1.6,
    "drift": (0.5, 0.02),
    "periodic": (50.0, 0.01),
    "aging": (-0.1, 0.1),
    "outliers": (0.01, 0.1),
    "coupling": {"axis2_V": 0.05},
    "stick_slip": 0.03,
}
