"""The stage's hysteresis is a Preisach hysteresis, and two unrelated ways of computing it agree."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import dblquad, solve_ivp

from hysgen_lab.stage import BoucWen, Density, Preisach, Relays, Stage, StageError, run, static_loop, static_path
from hysgen_lab.stage.effects.memory import everett, everett_table

Floats = NDArray[np.float64]
NOMINAL = Stage.nominal()


def wandering(seed: int, extremes: int, low_V: float = -15.0, high_V: float = 115.0) -> Floats:
    """A path through random extremes, in steps that hit none of them by accident."""
    corners = np.random.default_rng(seed).uniform(low_V, high_V, extremes)
    pieces = [np.linspace(a, b, 37)[:-1] for a, b in itertools.pairwise(corners)]
    return np.concatenate([*pieces, corners[-1:]])


def test_everett_function_is_the_integral_of_the_relay_density() -> None:
    density = Density()
    nodes_V, table = everett_table(density)
    for high_V, low_V in ((120.0, -20.0), (45.0, 5.0), (26.0, 24.0)):
        by_quadrature, _ = dblquad(
            lambda beta, alpha: float(density.on(np.array(alpha)) * density.off(np.array(beta))),
            low_V,
            high_V,
            low_V,
            lambda alpha: alpha,
            epsabs=1e-12,
            epsrel=1e-12,
        )
        # Both quadratures are good to about 1e-12; the rest is what the difference of large integrals costs.
        assert everett(nodes_V, table, high_V, low_V) == pytest.approx(by_quadrature, rel=1e-9)


@pytest.mark.parametrize("count", [140, 1000])
def test_single_relays_agree_with_the_everett_function(count: int) -> None:
    relays = Relays(count=count)
    path = wandering(1, 60)
    apart = static_path(NOMINAL, path) - static_path(NOMINAL.with_effects(memory=relays), path)
    # Between two rows of relays the staircase waits: off by half a row's weight at either end of the present piece.
    form = relays.form(NOMINAL.stroke_um, NOMINAL.full_V)
    rows = np.unique(form.arrays["up_V"].round(6), return_inverse=True)[1]
    heaviest_um = np.bincount(rows, form.arrays["weight_um"]).max()
    assert np.abs(apart).max() < heaviest_um
    assert np.abs(apart).max() > 0


def test_passed_extremes_are_wiped_out() -> None:
    inner = np.array([30.0, 70.0, 40.0, 60.0, 45.0, 55.0])
    after = np.array([80.0, 20.0, 50.0])
    with_loops = static_path(NOMINAL, np.concatenate([[10.0], inner, after]))[-3:]
    plain = static_path(NOMINAL, np.concatenate([[10.0], after]))[-3:]
    # The sums run over the same pieces in the same order: equal bits.
    assert (with_loops == plain).all()


def test_a_minor_loop_returns_to_where_it_left_the_curve() -> None:
    w_um = static_path(NOMINAL, np.array([60.0, 35.0, 60.0, 35.0, 48.0, 35.0]))
    # One sum of E over up to four pieces of at most 10 um each: rounding stays below 1e-12 um.
    assert w_um[2] == pytest.approx(w_um[0], abs=1e-12)
    assert w_um[3] == pytest.approx(w_um[1], abs=1e-12)
    assert w_um[5] == pytest.approx(w_um[1], abs=1e-12)


def test_minor_loops_between_equal_voltages_are_congruent() -> None:
    loop_V = np.concatenate([np.linspace(60, 40, 51), np.linspace(40, 60, 51)])
    low = static_path(NOMINAL, np.concatenate([[-10.0, 60.0], loop_V]))[2:]
    high = static_path(NOMINAL, np.concatenate([[110.0, 40.0, 60.0], loop_V]))[3:]
    assert high[0] - low[0] > 0.1  # they hang at different heights
    # Interpolation of the Everett function is good to 1e-9 um, see the test against quadrature.
    np.testing.assert_allclose(low - low[0], high - high[0], atol=1e-9)


def test_loops_of_one_size_differ_along_the_range_as_no_play_operators_can() -> None:
    # Play operators see voltage differences only: their loops of one size are equal wherever they stand.
    opening = []
    for middle_V in (10.0, 50.0, 100.0):
        _, rising, falling = static_loop(NOMINAL, middle_V - 15, middle_V + 15)
        opening.append(float((falling - rising).max()))
    assert max(opening) > 1.5 * min(opening)


@pytest.mark.parametrize(("low_V", "high_V"), [(0.0, 120.0), (-20.0, 120.0), (5.0, 45.0)])
def test_loops_are_as_wide_as_those_of_soft_ceramics(low_V: float, high_V: float) -> None:
    _, rising, falling = static_loop(NOMINAL, low_V, high_V)
    span = rising[-1] - rising[0]
    assert (falling - rising).min() > -1e-12  # falling above rising: the output lags
    assert 0.10 < (falling - rising).max() / span < 0.20  # data sheets of piezo actuators: 10 to 20 %
    assert (np.diff(rising) > 0).all()
    assert (np.diff(falling) > 0).all()


def test_small_loops_are_relatively_narrower_and_flatter() -> None:
    width, gain = [], []
    for half_V in (1.0, 10.0, 40.0):
        u_V, rising, falling = static_loop(NOMINAL, 50 - half_V, 50 + half_V)
        width.append(float((falling - rising).max() / (rising[-1] - rising[0])))
        gain.append(float((rising[-1] - rising[0]) / (u_V[-1] - u_V[0])))
    assert width == sorted(width)
    assert gain == sorted(gain)


def test_there_is_no_staircase() -> None:
    u_V = 40.0 + np.linspace(0.0, 0.2, 2001)  # steps of 0.1 mV
    slope = np.diff(static_path(NOMINAL, u_V)) / np.diff(u_V)
    assert slope.min() > 0
    # 0.2 V bend the slope by next to nothing; a staircase would make it jump between its reversible part and infinity.
    assert slope.max() / slope.min() < 1.01


def loop_area(stage: Stage, f_Hz: float) -> float:
    """Area in V um of the second period of a sine of 5..45 V, read without noise, 4000 samples a period.

    Against the voltage that was there when y was read: the next one, put out only then, would open the loop.
    """
    n = 4000
    u_V = 25.0 - 20.0 * np.cos(2 * np.pi * np.arange(2 * n + 1) / n)
    measured = run(stage.quiet(), u_V, 1 / (f_Hz * n))
    u_V, y_um = measured.truth.actuator_V[n:], measured.displacement_um[n:]
    return float(-np.sum((y_um[1:] + y_um[:-1]) / 2 * np.diff(u_V)))


@pytest.mark.parametrize("memory", [Preisach(), Relays(), BoucWen()])
def test_the_loop_stays_open_as_the_frequency_falls(memory: Preisach | Relays | BoucWen) -> None:
    stage = NOMINAL.with_effects(memory=memory)
    straight = stage.with_effects(memory=None)
    assert loop_area(stage, 0.01) > 5.0  # of 40 V times 3 um
    assert loop_area(stage, 0.0001) == pytest.approx(loop_area(stage, 0.01), rel=1e-9)
    # The lag of 1 ms alone opens pi 20 V 1.67 um sin(2 pi 0.001) = 0.66 V um at 1 Hz, less the D/A's half sample, 12 %.
    assert loop_area(straight, 1.0) == pytest.approx(0.58, abs=0.01)
    assert abs(loop_area(straight, 0.01)) < 1e-9


def test_the_path_counts_and_not_its_speed() -> None:
    path = wandering(3, 20)
    stretched = np.repeat(path, np.random.default_rng(4).integers(1, 9, len(path)))
    once = static_path(NOMINAL, path)
    again = static_path(NOMINAL, stretched)
    assert (
        again[np.flatnonzero(np.append(np.diff(stretched) != 0, True))] == once[np.append(np.diff(path) != 0, True)]
    ).all()


@pytest.mark.parametrize("exponent", [1.0, 1.6])
def test_bouc_wen_solves_its_differential_equation(exponent: float) -> None:
    memory = BoucWen(exponent=exponent)
    stage = NOMINAL.with_effects(memory=memory)
    corners_V = (0.0, 80.0, 20.0, 55.0)
    climb = memory.loop_um / memory.reach_V
    beta, gamma = (part * climb / memory.loop_um**exponent for part in (memory.balance, 1 - memory.balance))

    def slope(u_V: float, z: Floats, sign: float) -> Floats:
        return climb - beta * sign * np.abs(z) ** (exponent - 1) * z - gamma * np.abs(z) ** exponent

    z_um, at_V = [0.0], -60.0  # the history begins below the D/A's range
    for to_V in (*stage.history_V[:-1], *corners_V):
        sign = float(np.sign(to_V - at_V))
        done = solve_ivp(slope, (at_V, to_V), z_um[-1:], args=(sign,), rtol=1e-10, atol=1e-12)
        z_um.append(float(done.y[0, -1]))
        at_V = to_V
    z_of_corners = np.array(z_um[-len(corners_V) :])
    reversible = (stage.stroke_um + 2 * memory.loop_um) / stage.full_V * np.array(corners_V)
    expected = reversible - (z_of_corners - z_of_corners[0])
    # Runge-Kutta in pieces of 0.25 V on a reach of 18 V: (0.25/18)^4 = 4e-8 of 0.75 um; passing z = 0 with exponent 1.6
    # costs two orders.
    np.testing.assert_allclose(static_path(stage, np.array(corners_V)), expected, atol=4e-6)


@pytest.mark.parametrize(("memory", "tolerance"), [(Preisach(), 1e-9), (Relays(), 1e-9), (BoucWen(), 1e-2)])
def test_the_closed_full_stroke_is_the_nominal_displacement(memory: Preisach, tolerance: float) -> None:
    # Preisach and relays are scaled to it; Bouc-Wen closes within exp(-120 V / 18 V) of twice its loop: 0.002 um.
    stage = NOMINAL.with_effects(memory=memory)
    w_um = static_path(stage, np.array([0.0, 120.0, 0.0, 120.0, 0.0]))
    assert w_um[0] == pytest.approx(0.0, abs=1e-12)
    assert w_um[-2] - w_um[-1] == pytest.approx(10.0, abs=tolerance)


@pytest.mark.parametrize("memory", [Preisach(), Relays(), BoucWen(), None])
def test_the_sensor_reads_zero_where_it_was_zeroed(memory: Preisach | None) -> None:
    at_rest, zeroed = (replace(NOMINAL, zero_V=zero_V).with_effects(memory=memory) for zero_V in (0.0, 24.0))
    path = wandering(5, 10)
    assert static_path(zeroed, np.array([24.0]))[0] == pytest.approx(0.0, abs=1e-12)
    # A zero is a constant: the history is the same.
    shift = static_path(at_rest, path) - static_path(zeroed, path)
    np.testing.assert_allclose(shift, static_path(at_rest, np.array([24.0]))[0], atol=1e-12)


def test_too_many_nested_turning_points_are_an_error_not_an_overrun() -> None:
    n = 70_000
    shrinking = 60.0 + 50.0 * np.linspace(1.0, 0.0, n) * (-1.0) ** np.arange(n)
    with pytest.raises(StageError, match="65536 nested turning points"):
        static_path(NOMINAL, shrinking)
    with pytest.raises(StageError, match="65536 nested turning points"):
        run(NOMINAL.with_effects(), shrinking, 20e-6)
