"""Certificates: no point of the range violates them, and they are tight."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fixtures.random_models import TS_S, random_drive, random_model
from hysgen.certify.certificates import certify, inverse_stability
from hysgen.certify.enclosure import gain, gain_extrema, slope, slope_extremum
from hysgen.model.file import load_model
from hysgen.model.membership import rule_regressors
from hysgen.model.model import Grid, Model
from hysgen.model.simulate import simulate
from hysgen.model.terms import Drive
from hysgen.model.terms.creep import Creep
from hysgen.model.terms.memory import Memory

seeds = st.integers(0, 2**31)
sizes = st.integers(2, 40)
wildness = st.sampled_from([0.01, 0.3, 3.0, 100.0])


def dense(model: Model, points: int = 4001) -> Any:
    """Displacements over the whole grid."""
    return np.linspace(model.grid.y_min_um, model.grid.y_max_um, points)


def output(model: Model, y: Any, u: Any) -> Any:
    """f(y, u) by Eq. (5)."""
    return rule_regressors(y, u, model.grid) @ model.consequents.ravel()


@given(seeds, sizes, wildness)
@settings(max_examples=60, deadline=None, derandomize=True)
def test_no_point_of_the_range_exceeds_the_certified_slope_and_gain(seed: int, rules: int, wild: float) -> None:
    model = random_model(seed, rules, wild)
    y = dense(model)
    steepest = slope_extremum(model)
    values = np.abs([slope(model, y, np.full_like(y, u)) for u in (0.0, 37.0, 100.0)])
    # Rounding is not part of the bounds: 1e-15 of the largest v_l per um of step, on both sides.
    rounding = 1e-13 * np.abs(model.consequents).max() / min(model.grid.step_um, 1.0)
    assert values.max() <= steepest.bound + rounding
    assert values.max() <= steepest.value + 1e-6 + rounding
    low, high = gain_extrema(model)
    b = gain(model, y)
    assert low.bound - 1e-12 <= b.min()
    assert b.max() <= high.bound + 1e-12


@given(seeds, sizes, wildness)
@settings(max_examples=60, deadline=None, derandomize=True)
def test_enclosures_are_as_narrow_as_asked_and_met_where_they_say(seed: int, rules: int, wild: float) -> None:
    model = random_model(seed, rules, wild)
    steepest = slope_extremum(model)
    assert 0.0 <= steepest.bound - steepest.value <= 1e-6 * (1 + 1e-6)
    assert steepest.u_V is not None
    met = abs(float(slope(model, np.array([steepest.y_um]), np.array([steepest.u_V]))[0]))
    # The series ends at order 12: what is left is far below 1e-6, but y in um is known to 1e-16 of 100 um only.
    assert met == pytest.approx(steepest.value, abs=1e-6)
    for extremum in gain_extrema(model):
        assert float(gain(model, np.array([extremum.y_um]))[0]) == pytest.approx(extremum.value, rel=1e-6, abs=1e-9)


@given(seeds, sizes)
@settings(max_examples=30, deadline=None, derandomize=True)
def test_slope_and_gain_are_the_derivatives_of_the_model(seed: int, rules: int) -> None:
    model = random_model(seed, rules)
    y = dense(model, 50)[1:-1]
    u = np.linspace(0, 100, y.size)
    step = 1e-5 * model.grid.step_um
    by_y = (output(model, y + step, u) - output(model, y - step, u)) / (2 * step)
    # Rounding of f, 1e-14 um at 100 um, over a step of at least 2e-8 um.
    np.testing.assert_allclose(slope(model, y, u), by_y, atol=2e-5, rtol=1e-5)
    np.testing.assert_allclose(gain(model, y), (output(model, y, u + 1) - output(model, y, u)), atol=1e-10, rtol=0)


def test_certified_contraction_draws_two_free_runs_together() -> None:
    found = 0
    for seed in range(40):
        model = random_model(seed, wild=0.05)
        certificate = certify(model)
        if not certificate.contraction_holds:
            continue
        found += 1
        drive = Drive(random_drive(300, seed), TS_S)
        one = simulate(model, drive, model.grid.y_min_um).y_um
        other = simulate(model, drive, model.grid.y_max_um).y_um
        distance = np.abs(one - other)
        assert (distance[1:] <= certificate.slope.bound * distance[:-1] + 1e-12).all()
    assert found >= 5


def test_appendix_a_holds_everywhere_and_appendix_b_says_how_far() -> None:
    a, b = certify(load_model("appendix_a")), certify(load_model("appendix_b"))
    assert a.gain_holds
    assert a.contraction_holds
    assert a.inverse_holds
    assert a.contracting_V == (-20.0, 120.0)
    assert b.gain_holds
    assert not b.contraction_holds
    assert b.contracting_V is not None
    low, high = b.contracting_V
    model, y = load_model("appendix_b"), dense(load_model("appendix_b"))
    for u in (low, high):
        assert np.abs(slope(model, y, np.full_like(y, u))).max() < 1.0
    # The interval ends where contraction does, to 0.01 V.
    for u in (low - 0.01, high + 0.01):
        assert np.abs(slope(model, y, np.full_like(y, u))).max() > 1.0
    assert f"certified for {low:.4g} .. {high:.4g} V only" in b.lines()[1]


@given(seeds, wildness)
@settings(max_examples=40, deadline=None, derandomize=True)
def test_contraction_holds_for_every_input_that_is_said_to_contract(seed: int, wild: float) -> None:
    model = random_model(seed, wild=wild)
    inputs = certify(model).contracting_V
    if inputs is not None:
        y = dense(model, 1001)
        for u in np.linspace(*inputs, 5):
            assert np.abs(slope(model, y, np.full_like(y, u))).max() < 1.0


def test_a_gain_that_changes_sign_or_fades_is_not_certified() -> None:
    model = random_model(3, wild=0.05)
    assert certify(model).gain_holds
    for factor, holds in ((-1.0, True), (1.0, True)):
        turned = model.consequents * [1.0, factor, 1.0]
        assert certify(dataclasses.replace(model, consequents=turned)).gain_holds is holds
    for weakest in (0.0, -0.5, 1e-4):
        fading = model.consequents.copy()
        fading[:3, 1] *= weakest
        certificate = certify(dataclasses.replace(model, consequents=fading))
        assert not certificate.gain_holds
        assert not certificate.inverse_holds
        assert "NOT certified" in certificate.lines()[0]


def run_inverse(model: Model, y_um: Any) -> Any:
    """u of Eq. (11) along a reference for a model with terms, unclamped, by the loop."""
    plays = [term for term in model.terms if isinstance(term, Memory)]
    u = np.zeros(y_um.size - 1)
    z = np.full(sum(term.size for term in plays), 50.0)
    r = np.concatenate([np.asarray(term.thresholds_V) for term in plays])
    for k in range(u.size):
        here = np.array([y_um[k]])
        rest = float(output(model, here, np.zeros(1))[0]) + model.weights @ z
        u[k] = (y_um[k + 1] - rest) / float(gain(model, here)[0])
        z = np.maximum(u[k] - r, np.minimum(u[k] + r, z))
    return u


@pytest.mark.parametrize(("loop", "certified"), [(0.5, True), (0.97, True), (1.5, False)])
def test_small_gain_tells_whether_the_inverse_with_memory_stays_bounded(loop: float, certified: bool) -> None:
    # One rule for all y, and alternating weights on narrow plays: past inputs come back through the inverse.
    grid, b = Grid(0.0, 10.0, 6), 0.005
    plays = Memory((0.01, 0.02))
    weights = loop * b * np.array([0.5, 0.5])
    model = Model("m", TS_S, grid, np.tile([0.95, b, 0.0], (6, 1)), 0, 100, (plays,), weights)
    certificate = certify(model)
    assert certificate.loop == pytest.approx(loop, rel=1e-9)
    assert certificate.inverse_holds is certified
    k = np.arange(2000)
    with np.errstate(over="ignore"):
        u = run_inverse(model, 5.0 + 0.5 * np.sin(2e-3 * k))
        settled = bool(np.abs(np.diff(u[-100:])).max() < 1.0)
    assert settled is certified


@pytest.mark.parametrize(("ahead", "certified"), [(0.0, False), (1.0, True)])
def test_a_past_input_below_zero_lets_the_inverse_follow_plays_that_weigh_more_than_the_input(
    ahead: float, certified: bool
) -> None:
    # The same hysteresis twice: the input moves b, the plays 2 b. With half of that in the input, and taken from the
    # past input again, the steps of the inverse die out; without it they grow to where the input's range ends.
    grid, b = Grid(0.0, 10.0, 6), 0.005
    plays, weights = Memory((0.0, 0.01, 0.02)), b * np.array([-ahead, 1.0, 1.0])
    model = Model("m", TS_S, grid, np.tile([0.95, (1.0 + ahead) * b, 0.0], (6, 1)), 0, 100, (plays,), weights)
    certificate = certify(model)
    assert certificate.loop == pytest.approx(2.0 if ahead == 0.0 else 0.5)
    assert certificate.inverse_holds is certified
    with np.errstate(over="ignore", invalid="ignore"):
        u = run_inverse(model, 5.0 + 0.5 * np.sin(2e-3 * np.arange(2000)))
        settled = bool(np.abs(np.diff(u[-100:])).max() < 1.0)
    assert settled is certified


def test_zeros_of_the_inverse_are_where_a_linear_term_puts_them() -> None:
    # y+ = a y + b u + theta x, x+ = x + q (u - x): u = (y+ - a y - theta x)/b moves x by 1 - q - q theta/b.
    term = Creep((1e-3,))
    q = 1.0 - np.exp(-TS_S / 1e-3)
    b = 0.004
    for theta in (0.001, -0.002, -0.0045):
        model = Model("m", TS_S, Grid(0, 10, 3), np.tile([0.9, b, 0.0], (3, 1)), 0, 100, (term,), np.array([theta]))
        zero, loop = inverse_stability(model, b, b)
        system = term.linear(TS_S)
        assert system.A[0, 0] == pytest.approx(1.0 - q, rel=1e-12)
        assert zero == pytest.approx(abs(1.0 - q - q * theta / b), rel=1e-12)
        assert loop == 0.0
        assert certify(model).inverse_holds is (theta > -b)


def test_linear_and_nonlinear_terms_close_one_loop_with_the_filters_gain() -> None:
    b, theta = 0.004, 0.001
    creep, plays = Creep((1e-3,)), Memory((1.0, 2.0))
    model = Model(
        "m",
        TS_S,
        Grid(0, 10, 3),
        np.tile([0.9, b, 0.0], (3, 1)),
        0,
        100,
        (creep, plays),
        np.array([theta, 0.001, -0.0005]),
    )
    # Impulse response of (b + T)^-1 by the recurrence; its absolute sum is the gain around which the plays close.
    q, x, total = 1.0 - np.exp(-TS_S / 1e-3), 0.0, 0.0
    for k in range(4000):
        u = ((1.0 if k == 0 else 0.0) - theta * x) / b
        x += q * (u - x)
        total += abs(u)
    _, loop = inverse_stability(model, b, b)
    assert loop == pytest.approx(total * 0.001, rel=1e-6)


def test_certificates_are_plain_json_and_one_line_each() -> None:
    import json

    for name in ("appendix_a", "appendix_b"):
        certificate = certify(load_model(name))
        assert json.loads(json.dumps(certificate.to_json(), allow_nan=False)) == certificate.to_json()
        assert len(certificate.lines()) == 3
        assert not any("\n" in line for line in certificate.lines())
