"""Certificates: no point of the range violates them, and they are tight."""

import dataclasses
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import chebyshev

from fixtures.generated_models import path, relaxing
from fixtures.random_models import TS_S, random_drive, random_model
from hysgen.certify.certificates import certify
from hysgen.certify.enclosure import gain, gain_extrema, slope, slope_extremum
from hysgen.certify.path_inverse import bounded_slopes, path_inverse, sampled_slopes
from hysgen.codegen import generate
from hysgen.errors import CertificateError
from hysgen.model.disturbances import Drive
from hysgen.model.file import load_model
from hysgen.model.intervals import Interval
from hysgen.model.model import Model
from hysgen.model.path.creep import Creep
from hysgen.model.path.hysteresis import Hysteresis
from hysgen.model.path.modes import Modes
from hysgen.model.regression import rule_regressors
from hysgen.model.simulate import simulate

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
@settings(max_examples=60)
@pytest.mark.slow
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
@settings(max_examples=60)
@pytest.mark.slow
def test_enclosures_are_as_narrow_as_asked_and_met_where_they_say(seed: int, rules: int, wild: float) -> None:
    model = random_model(seed, rules, wild)
    steepest = slope_extremum(model)
    # The bound includes rounding, which passes the width that is asked only where many rules or wild ones cancel.
    width = 1e-6 * (1 + 1e-6) if rules < 6 and wild < 100.0 else 1e-3 * max(1.0, steepest.value)
    assert 0.0 <= steepest.bound - steepest.value <= width
    assert steepest.w is not None
    met = abs(float(slope(model, np.array([steepest.y_um]), np.array([steepest.w]))[0]))
    # The series ends at order 12: what is left is far below 1e-6, but y in um is known to 1e-16 of 100 um only.
    assert met == pytest.approx(steepest.value, abs=1e-6)
    for extremum in gain_extrema(model):
        assert float(gain(model, np.array([extremum.y_um]))[0]) == pytest.approx(extremum.value, rel=1e-6, abs=1e-9)


@given(seeds, sizes)
@settings(max_examples=30)
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
    assert a.contracting == (-20.0, 120.0)
    assert b.gain_holds
    assert not b.contraction_holds
    assert b.contracting is not None
    low, high = b.contracting
    model, y = load_model("appendix_b"), dense(load_model("appendix_b"))
    for u in (low, high):
        assert np.abs(slope(model, y, np.full_like(y, u))).max() < 1.0
    # The interval ends where contraction does, to 0.01 V.
    for u in (low - 0.01, high + 0.01):
        assert np.abs(slope(model, y, np.full_like(y, u))).max() > 1.0
    assert f"certified for {low:.4g} .. {high:.4g} V only" in b.lines()[1]


@given(seeds, wildness)
@settings(max_examples=40)
def test_contraction_holds_for_every_input_that_is_said_to_contract(seed: int, wild: float) -> None:
    model = random_model(seed, wild=wild)
    inputs = certify(model).contracting
    if inputs is not None:
        y = dense(model, 1001)
        for u in np.linspace(*inputs, 5):
            assert np.abs(slope(model, y, np.full_like(y, u))).max() < 1.0


def test_a_gain_that_changes_sign_or_fades_is_not_certified() -> None:
    model = random_model(3, wild=0.05)
    assert certify(model).gain_holds
    for factor, holds in ((-1.0, True), (1.0, True)):
        turned = model.consequents * [1.0, factor, 1.0]
        certificate = certify(dataclasses.replace(model, consequents=turned))
        assert certificate.gain_holds is holds
        negative = certificate.gain_highest.bound < 0.0
        assert certificate.lines()[0].endswith("falls as u rises; check the record's signs" if negative else "holds")
    for weakest in (0.0, -0.5, 1e-4):
        fading = model.consequents.copy()
        fading[:3, 1] *= weakest
        certificate = certify(dataclasses.replace(model, consequents=fading))
        assert not certificate.gain_holds
        assert not certificate.inverse_holds
        assert "NOT certified" in certificate.lines()[0]


HYSTERESIS = next(block for block in path().blocks if isinstance(block, Hysteresis))


def test_a_hysteresis_that_falls_back_after_a_turn_has_no_certified_inverse() -> None:
    whole = certify(path())
    assert whole.inverse_holds
    assert whole.w_unit == "um"
    assert whole.path.slopes is not None
    low, high = HYSTERESIS.slope_range()
    assert low <= HYSTERESIS.mean_slope * whole.path.slopes.least
    assert HYSTERESIS.mean_slope * whole.path.slopes.largest <= high
    # A Duhem state that lowers h after every turn by more than curve and plays raise it.
    fallen = dataclasses.replace(HYSTERESIS, duhem_um=(-1.2, 0.0, 0.0, 0.0))
    blocks = tuple(fallen if block == HYSTERESIS else block for block in path().blocks)
    certificate = certify(dataclasses.replace(path(), blocks=blocks))
    assert certificate.gain_holds
    assert certificate.path.slopes is not None
    assert certificate.path.slopes.least < 0.0
    assert not certificate.inverse_holds
    assert "NOT certified" in certificate.lines()[2]
    with pytest.raises(CertificateError, match="slope of the hysteresis"):
        generate(dataclasses.replace(path(), blocks=blocks))


def test_the_slopes_of_a_stage_that_falls_with_the_voltage_are_those_of_its_mirror_image() -> None:
    turned = dataclasses.replace(
        HYSTERESIS,
        curve_um=tuple(-c for c in HYSTERESIS.curve_um),
        plays_um=tuple(-c for c in HYSTERESIS.plays_um),
        duhem_um=tuple(-c for c in HYSTERESIS.duhem_um),
    )
    one, other = (sampled_slopes(block, Interval(-20.0, 120.0)) for block in (HYSTERESIS, turned))
    assert (one.least, one.largest) == (other.least, other.largest)
    assert one.mean_um_per_V == pytest.approx(-other.mean_um_per_V, rel=1e-8)


def test_slopes_of_plays_that_relax_are_bounded_for_every_past_while_their_densities_are_not_negative() -> None:
    block = relaxing()
    turned = dataclasses.replace(
        block,
        curve_um=tuple(-c for c in block.curve_um),
        plays_um=tuple(-c for c in block.plays_um),
        duhem_um=tuple(-c for c in block.duhem_um),
    )
    x = np.linspace(-1.0, 1.0, 50_001)
    curve = chebyshev.chebval(x, chebyshev.chebder(np.array(block.curve_um))).min() / block.mean_slope
    for one in (block, turned):
        found = bounded_slopes(one)
        assert curve - 1e-6 < found.least <= curve
        sampled = sampled_slopes(one, Interval(-20.0, 120.0))
        assert found.least <= sampled.least
        assert sampled.largest <= found.largest
        proved = path_inverse(dataclasses.replace(path(), blocks=(one,))).slopes
        assert proved == found
        assert found.proved
    # One play whose density is negative by more than the slope of the curve: no bound, so the sample is shown.
    fallen = dataclasses.replace(block, plays_um=(-3.0, *block.plays_um[1:]))
    assert bounded_slopes(fallen).least < 0.0
    shown = path_inverse(dataclasses.replace(path(), blocks=(fallen,))).slopes
    assert shown is not None
    assert not shown.proved


def test_zero_is_the_largest_of_the_blocks_that_the_inverse_solves_and_others_are_left_out() -> None:
    creep = Creep(0.02, (1e-3, 1.0))
    stiff, light = Modes((730.0,), (0.05,), (0.3,), 4e-4), Modes((730.0,), (0.001,), (1.0,), 4e-4)
    assert stiff.solves(TS_S)
    assert not light.solves(TS_S)
    for modes, left_out in ((stiff, ()), (light, ("modes",))):
        found = certify(dataclasses.replace(path(), blocks=(HYSTERESIS, creep, modes)))
        zeros = [block.zero(TS_S) for block in (creep, modes) if block.solves(TS_S)]
        assert found.path.zero == pytest.approx(max(zeros), rel=1e-9)
        assert max(zeros) <= found.path.zero < 1.0
        assert found.path.left_out == left_out
        assert found.inverse_holds
        assert ("left out" in found.lines()[2]) is bool(left_out)
