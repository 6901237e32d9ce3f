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


@pytest.mark.parametrize(("low_V", "high_V"), [(0.0, 120.0), (-20.0, 120.0), (5.0, 45.0)])
def test_loops_are_as_wide_as_those_of_soft_ceramics(low_V: float, high_V: float) -> None:
    _, rising, falling = static_loop(NOMINAL, low_V, high_V)
    span = rising[-1] - rising[0]
    assert (falling - rising).min() > -1e-12  # falling above rising: the output lags
    assert 0.10 < (falling - rising).max() / span < 0.20  # data sheets of piezo actuators: 10 to 20 %
    assert (np.diff(rising) > 0).all()
    assert (np.diff(falling) > 0).all()


def test_there_is_no_staircase() -> None:
    u_V = 40.0 + np.linspace(0.0, 0.2, 2001)  # steps of 0.1 mV
    slope = np.diff(static_path(NOMINAL, u_V)) / np.diff(u_V)
    assert slope.min() > 0
    # 0.2 V bend the slope by next to nothing; a staircase would make it jump between its reversible part and infinity.
    assert slope.max() / slope.min() < 1.01


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
