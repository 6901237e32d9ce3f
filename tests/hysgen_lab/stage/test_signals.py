"""Driving signals: those of the paper as printed, and excitations that keep what their docstrings promise."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from hysgen_lab.stage import signals
from hysgen_lab.stage.signals import SignalError

Floats = NDArray[np.float64]
TS_S = 20e-6  # section 4: 50 kHz


def largest_jump(u_V: Floats) -> float:
    return float(np.abs(np.diff(u_V)).max())


def turning_points(u_V: Floats) -> Floats:
    moves = np.diff(u_V)
    u_V, moves = u_V[np.append(True, moves != 0)], moves[moves != 0]
    return u_V[1:-1][np.sign(moves[1:]) != np.sign(moves[:-1])]


@pytest.mark.parametrize("part", ["identification", "validation"])
def test_fig5_is_100_hz_of_varying_amplitude_between_30_and_70_volts(part: signals.Part) -> None:
    u_V = signals.fig5(TS_S, part)
    assert u_V[0] == u_V[-1] == 30.0
    assert u_V.min() == pytest.approx(30.0, abs=1e-9)
    assert u_V.max() <= 70.0 + 1e-9
    periods = (u_V[:-1] - 30.0).reshape(-1, 500)  # 100 Hz at 50 kHz
    tops = periods.max(axis=1)
    assert (periods.argmax(axis=1) == 250).all()
    assert len(np.unique(tops)) >= 10
    assert largest_jump(u_V) < 2 * np.pi * 100.0 * 20.0 * TS_S * 1.001  # the steepest of its sines


def test_fig8_is_the_printed_formula() -> None:
    # Section 4.2 evaluated by hand: t = 0, and t = 0.5 s with math's own functions.
    t = 0.5
    for part, fading, slowing in (("identification", 2.0, 1.0), ("validation", 2.5, 1.2)):
        u_V = signals.fig8(TS_S, part)
        assert len(u_V) == 50_000
        assert u_V[0] == 45.0
        inner = math.sin(120 * math.pi * math.exp(-slowing * t) * t) + 1
        assert u_V[25_000] == pytest.approx(15 * math.exp(-fading * t) * inner + 30, abs=1e-9)
        assert u_V.min() >= 30.0
        assert u_V.max() <= 60.0


def test_fig11_sine_has_100_hz_and_the_other_no_period() -> None:
    k = np.arange(1000)
    lines = [a * np.sin(2 * np.pi * 20 * math.sqrt(n) * TS_S * k) for a, n in ((5, 1), (4, 2), (3, 5))]
    np.testing.assert_allclose(signals.fig11_non_harmonic(TS_S)[:1000], 45 + sum(lines), atol=1e-9)
    np.testing.assert_allclose(signals.fig11_sine(TS_S)[:1000], 45 + 12 * np.sin(2 * np.pi * 100 * TS_S * k), atol=1e-9)
    # Default durations: 0.1 s, 0.4 s, and 0.1 s of the reference.
    assert (signals.fig11_sine(TS_S).size, signals.fig11_non_harmonic(TS_S).size) == (5000, 20_000)
    assert signals.tracking_reference(TS_S, 50.0).size == 5000
    sine = signals.fig11_sine(TS_S, 0.1)
    np.testing.assert_allclose(sine[500:], sine[:-500], atol=1e-9)
    other = signals.fig11_non_harmonic(1e-3, 5.0)
    repeats = [np.abs(other[lag:-1] - other[: -lag - 1]).max() for lag in range(20, 2000)]
    assert min(repeats) > 1.0


@pytest.mark.parametrize("f_Hz", [50.0, 100.0])
def test_tracking_reference_is_that_of_section_4_3(f_Hz: float) -> None:
    y_um = signals.tracking_reference(TS_S, f_Hz)
    quarter = round(0.25 / f_Hz / TS_S)
    assert y_um[0] == 2.0
    assert y_um[quarter] == pytest.approx(2.6, abs=1e-9)
    assert y_um[3 * quarter] == pytest.approx(1.4, abs=1e-9)


def test_nested_amplitudes_fall_to_nothing_and_grow_again_at_each_frequency() -> None:
    u_V = signals.nested_amplitudes(TS_S, [50.0, 20.0], 30.0, 25.0, 6)
    assert len(u_V) == round(12 / 50.0 / TS_S) + round(12 / 20.0 / TS_S) + 1
    assert u_V[0] == u_V[-1] == 30.0
    for train in (u_V[:12_000], u_V[12_000:]):
        heights = np.abs(turning_points(train) - 30.0)
        assert len(heights) == 24
        middle = len(heights) // 2
        assert (np.diff(heights[:middle]) < 0).all()
        assert (np.diff(heights[middle:]) > 0).all()
        assert heights.min() < 0.05 * 25.0  # a quarter of the last of six periods is left of the amplitude
        assert heights.max() > 0.95 * 25.0


def test_plateaus_hold_and_travel_smoothly() -> None:
    u_V = signals.plateaus(1e-3, [10.0, 50.0, 20.0], 0.2, 0.05)
    assert len(u_V) == 3 * 200 + 2 * 50
    assert (u_V[:200] == 10.0).all()
    assert (u_V[250:450] == 50.0).all()
    assert (u_V[-200:] == 20.0).all()
    assert largest_jump(u_V) <= 40.0 * math.pi / 2 / 50
    assert largest_jump(signals.plateaus(1e-3, [10.0, 50.0], 0.2, 0.0)) == 40.0


@pytest.mark.parametrize(
    ("call", "complaint"),
    [
        (lambda: signals.fig5(TS_S, "test"), "part: 'test' is not in Fig. 5"),  # type: ignore[arg-type]
        (lambda: signals.fig8(TS_S, "test"), "part: 'test' is not in Fig. 8"),  # type: ignore[arg-type]
        (lambda: signals.fig5(5e-3, "validation"), "100.0 Hz is not resolved"),
        (lambda: signals.fig11_sine(0.0), "Ts_s: 0.0 s is no sampling period"),
        (lambda: signals.fig8(TS_S, "validation", 0.0), "duration_s: 0.0"),
        (lambda: signals.tracking_reference(TS_S, math.nan), "f_Hz: nan"),
        (lambda: signals.nested_amplitudes(TS_S, [], 30.0, 20.0, 3), "0 frequencies"),
        (lambda: signals.nested_amplitudes(1e-3, [300.0], 30.0, 20.0, 3), "300.0 Hz is not resolved"),
        (lambda: signals.nested_amplitudes(TS_S, [50.0], 30.0, 20.0, 0), "of 0 cycles"),
        (lambda: signals.plateaus(TS_S, [1.0], 1.0, -0.1), "ways of -0.1 s"),
        (lambda: signals.plateaus(TS_S, [], 1.0, 0.1), "0 levels"),
    ],
)
def test_what_cannot_be_made_is_refused_in_one_line(call: Callable[[], Floats], complaint: str) -> None:
    with pytest.raises(SignalError, match=complaint) as refusal:
        call()
    assert "\n" not in str(refusal.value)
