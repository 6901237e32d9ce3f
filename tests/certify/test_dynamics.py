"""Time constants, steady states and loops of a model."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from hysgen.certify.dynamics import dynamics, loop, steady_states
from hysgen.errors import ModelError
from hysgen.model.disturbances.coupling import Coupling
from hysgen.model.file import load_model
from hysgen.model.model import Grid, Model
from hysgen.model.path.hysteresis import Hysteresis
from hysgen.model.regression import rule_regressors

TS_S = 2e-5
A, B, C = 0.98, 0.0016, 0.02
LAG = Model("lag", TS_S, Grid(-5.0, 15.0, 6), np.tile([A, B, C], (6, 1)), 0.0, 100.0)


def test_appendix_a_is_a_lag_of_a_millisecond_whose_loop_closes() -> None:
    found = dynamics(load_model("appendix_a"))
    inner = [state for state in found.steady_states if state.inside and state.tau_s is not None]
    # DESIGN.md, finding 2: time constant of 1 ms, DC gain 0.083 um/V.
    middle = min(inner, key=lambda state: abs(state.u_V - 50.0))
    assert middle.tau_s == pytest.approx(1e-3, rel=0.05)
    assert middle.gain_um_per_V == pytest.approx(0.083, rel=0.05)
    assert not found.has_memory
    lowest, next_one = found.loops[:2]
    # The area of a lag's loop falls with its frequency.
    assert next_one.area_umV / lowest.area_umV == pytest.approx(next_one.f_Hz / lowest.f_Hz, rel=0.02)
    assert "a lag, not hysteresis" in found.describe()


def test_play_operators_keep_the_loop_open_at_any_frequency() -> None:
    # A curve of 0.08 um/V and two plays of 5 and 15 V with 0.01 um/V each, in half ranges of 50 V.
    block = Hysteresis(0.0, 100.0, (5.0, 4.0), (0.1, 0.3), (0.5, 0.5))
    model = dataclasses.replace(LAG, consequents=np.tile([A, 1.0 - A, 0.0], (6, 1)), blocks=(block,))
    found = dynamics(model, f_Hz=[0.2, 2.0, 20.0], amplitude_V=40.0)
    assert found.has_memory
    # In the steady state a play under amplitude A traces a parallelogram: 2 r across, 2 (A - r) high in its own output.
    area = sum(0.01 * 4 * r * (40.0 - r) for r in (5.0, 15.0))
    # The lag of 1 ms adds pi/4 of 2 pi 0.2 Hz 1 ms, 0.1 % of its box, of which the plays fill 3.6 %.
    assert area < found.loops[0].area_umV < 1.04 * area
    assert "has memory" in found.describe()


def test_a_linear_lag_has_its_own_time_constant_gain_and_ellipse() -> None:
    for state in steady_states(LAG, np.array([10.0, 60.0])):
        assert state.inside
        assert state.slope == pytest.approx(A, rel=1e-12)
        assert state.tau_s == pytest.approx(-TS_S / np.log(A), rel=1e-12)
        assert state.gain_um_per_V == pytest.approx(B / (1 - A), rel=1e-6)
        assert state.y_um == pytest.approx((B * state.u_V + C) / (1 - A), abs=1e-9)
    found = loop(LAG, 100.0, 50.0, 40.0)
    response = B / (np.exp(2j * np.pi * 100.0 * TS_S) - A)
    # Trapezoids under 500 samples a period fall short of an ellipse by (2 pi/500)^2/6 = 3e-5.
    assert found.area_umV == pytest.approx(np.pi * 40.0**2 * abs(response.imag), rel=1e-4)
    assert found.span_um == pytest.approx(2 * 40.0 * abs(response), rel=1e-4)


def test_steady_states_are_fixed_points_of_the_rules() -> None:
    model = load_model("appendix_a")
    states = [state for state in steady_states(model, np.linspace(35.0, 65.0, 6)) if state.inside]
    assert len(states) == 6
    y, u = np.array([state.y_um for state in states]), np.array([state.u_V for state in states])
    ahead = rule_regressors(y, u, model.grid) @ model.consequents.ravel()
    # The simulation stops at steps below 1e-13 um; the slope of 0.98 leaves 50 of them.
    np.testing.assert_allclose(ahead, y, atol=1e-12, rtol=0)


def test_a_model_with_channels_is_analysed_with_channels_at_zero() -> None:
    term = Coupling(("other_V",), (-1.0,), (1.0,), taps=1)
    model = dataclasses.replace(LAG, terms=(term,), weights=np.array([0.5]))
    coupled, plain = (steady_states(m, np.array([50.0]))[0] for m in (model, LAG))
    assert coupled.y_um == pytest.approx(plain.y_um, abs=1e-9)


def test_frequencies_that_cannot_be_simulated_are_refused() -> None:
    with pytest.raises(ModelError, match="3000 Hz is above a 20th of its rate"):
        loop(LAG, 3000.0, 50.0, 10.0)
    with pytest.raises(ModelError, match="choose a higher frequency"):
        loop(LAG, 1e-3, 50.0, 10.0)
