"""Least squares inside the certified set: certified, optimal there, and untouched where nothing is violated."""

from typing import Any, get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fixtures.random_models import TS_S, lag_record, random_drive
from hysgen.certify.certificates import certify
from hysgen.errors import FitError
from hysgen.fitting import FitSettings, Method, fit, least_squares, refine
from hysgen.fitting.identify import linear_gain, structure_for
from hysgen.fitting.least_squares import (
    CertifiedSet,
    Information,
    certified_set,
    disagreement,
    information,
    least_squares_inside,
)
from hysgen.fitting.refine import free_run_error
from hysgen.model.disturbances.periodic import Periodic
from hysgen.model.regression import memberships
from hysgen.record import Record, Segment


def narrow_record(seed: int = 0, noise_um: float = 0.03, loops: float = 1.0) -> Record:
    """One noisy loop at one amplitude: the record does not determine the model beside the loop."""
    rng = np.random.default_rng(seed)
    k = np.arange(3000)
    u = 50.0 + 40.0 * np.sin(2 * np.pi * 100 * TS_S * k)
    y = np.empty(k.size)
    y[0] = 4.0
    for n in range(k.size - 1):
        y[n + 1] = y[n] + 0.02 * (0.08 * u[n] + loops * 0.8 * np.sin(0.08 * u[n]) - y[n])
    return Record.from_segments([Segment("0", u, y + noise_um * rng.normal(size=k.size))], TS_S, "loop")


def problem(record: Record, settings_: FitSettings) -> tuple[Information, CertifiedSet]:
    """The least-squares problem of a fit and its certified set."""
    structure = structure_for(record, settings_)
    one_step = information(record, structure)
    return one_step, certified_set(structure, linear_gain(structure, one_step), settings_.slope_limit)


@pytest.mark.parametrize("rules", [4, 9, 20])
@pytest.mark.parametrize("seed", range(3))
def test_batch_is_certified_where_plain_least_squares_is_not(seed: int, rules: int) -> None:
    record = narrow_record(seed)
    plain = fit(record, FitSettings(method="batch", rules=rules, certified=False))
    inside = fit(record, FitSettings(method="batch", rules=rules))
    assert not (certify(plain).contraction_holds and certify(plain).gain_holds)
    assert certify(inside).contraction_holds
    assert certify(inside).gain_holds
    assert certify(inside).slope.value <= 0.999 + 1e-4
    assert inside.history["outcome"]["least_squares_certified"] is False


def test_batch_is_plain_least_squares_where_that_is_certified() -> None:
    record = lag_record(samples=4000)
    plain = fit(record, FitSettings(method="batch", certified=False))
    inside = fit(record, FitSettings(method="batch"))
    assert certify(plain).contraction_holds
    assert certify(plain).gain_holds
    np.testing.assert_array_equal(plain.parameters, inside.parameters)
    assert inside.history["outcome"]["least_squares_certified"] is True


@pytest.mark.parametrize("terms", [(), (Periodic((70.0,)),)])
def test_the_solution_is_the_best_of_the_certified_set(terms: Any) -> None:
    one_step, allowed = problem(narrow_record(1), FitSettings(terms=terms))
    free = one_step.solve()
    best = least_squares_inside(one_step.R, one_step.d, allowed.violated, 0.0 * free).x
    assert one_step.square(best) > one_step.square(free)
    # Convex: moving from the solution towards any other certified point must not help.
    rng = np.random.default_rng(0)
    for _ in range(15):
        target = free + rng.normal(size=best.size) * np.abs(free - best)
        other = least_squares_inside(np.eye(best.size), target, allowed.violated, 0.0 * free).x
        assert allowed.violated(other).floor.size == 0
        for part in (1e-3, 0.1, 1.0):
            # 1e-6 of a limit may be violated, so a neighbour may be better by about as little.
            assert one_step.square(best + part * (other - best)) >= one_step.square(best) * (1.0 - 1e-6)


def test_active_half_spaces_of_one_solution_save_rounds_in_a_similar_task(monkeypatch: pytest.MonkeyPatch) -> None:
    one_step, allowed = problem(narrow_record(1), FitSettings(rules=12))
    origin = np.zeros(one_step.d.size)
    edges = least_squares_inside(one_step.R, one_step.d, allowed.violated, origin).edges
    assert 0 < edges.floor.size <= one_step.d.size
    nearby = one_step.d * (1.0 + 1e-3 * np.random.default_rng(0).normal(size=one_step.d.size))
    rounds = []
    violated = CertifiedSet.violated
    monkeypatch.setattr(CertifiedSet, "violated", lambda this, q: rounds.append(q) or violated(this, q))
    alone = least_squares_inside(one_step.R, nearby, allowed.violated, origin).x
    cold = len(rounds)
    warm = least_squares_inside(one_step.R, nearby, allowed.violated, origin, edges).x
    assert len(rounds) - cold < 0.85 * cold
    # And it leads to the same place; 1e-6 of a limit may be violated.
    np.testing.assert_allclose(one_step.R @ warm, one_step.R @ alone, atol=1e-5 * np.linalg.norm(one_step.d))


def test_refinement_steps_along_the_edge_of_the_certified_set_and_needs_none() -> None:
    record = narrow_record(1)
    free, inside = (fit(record, FitSettings(rules=9, certified=certified)) for certified in (False, True))
    rms_um = [model.history["outcome"]["free_run_rms_um"]["refined"] for model in (free, inside)]
    assert rms_um[0] <= rms_um[1]
    assert not certify(free).contraction_holds
    structure = structure_for(record, FitSettings(rules=9))
    _, allowed = problem(record, FitSettings(rules=9))
    now, parameters = free_run_error(record, structure).criterion(inside), inside.parameters
    least, _ = refine._step(now, 1e-6, None, parameters, None)
    within, _ = refine._step(now, 1e-6, allowed, parameters, None)
    assert allowed.violated(parameters + least).floor.size > 0
    assert allowed.violated(parameters + within).floor.size == 0
    # Nor is it the same way, made shorter.
    assert least @ within < 0.9 * np.linalg.norm(least) * np.linalg.norm(within)


def test_the_gain_is_bounded_away_from_zero_where_the_record_shows_none() -> None:
    # A stage at its stop, badly measured: at the upper end of y the input moves nothing.
    u = random_drive(6000, 7)
    y = np.empty(u.size)
    y[0] = 1.0
    for n in range(u.size - 1):
        y[n + 1] = y[n] + 0.2 * (min(0.08 * u[n], 4.0) - y[n])
    record = Record.from_segments([Segment("0", u, y + 0.1 * np.random.default_rng(0).normal(size=u.size))], TS_S)
    assert not certify(fit(record, FitSettings(method="batch", certified=False))).gain_holds
    for method in get_args(Method)[1:]:
        certificate = certify(fit(record, FitSettings(method=method)))
        assert certificate.gain_holds
        assert certificate.contraction_holds


@pytest.mark.slow
@given(st.integers(0, 10_000), st.sampled_from([0.3, 0.9, 0.999]))
@settings(max_examples=8)
def test_every_certified_fit_holds_its_certificates(seed: int, limit: float) -> None:
    rng = np.random.default_rng(seed)
    record = narrow_record(seed, noise_um=float(10.0 ** rng.uniform(-3, -0.5)), loops=float(rng.uniform(0, 2)))
    model = fit(record, FitSettings(rules=int(rng.integers(2, 15)), slope_limit=limit, iterations=5))
    certificate = certify(model)
    # The half-spaces stand 16 to a rule and may be missed by 1e-6; between them the slope rises by what is left here.
    assert certificate.slope.bound <= limit + 5e-4
    assert certificate.gain_holds


def test_a_displacement_that_does_not_depend_on_the_voltage_is_refused() -> None:
    with pytest.raises(FitError, match="does not answer to the voltage"):
        certified_set(structure_for(lag_record(samples=500), FitSettings()), 0.0, 0.999)


def test_disagreement_is_the_variance_of_the_rules_over_the_range() -> None:
    record = lag_record(samples=500)
    structure = structure_for(record, FitSettings(rules=5, terms=(Periodic((70.0,)),)))
    q = np.random.default_rng(0).normal(size=structure.size)
    y = np.linspace(structure.grid.y_min_um, structure.grid.y_max_um, 8 * 4 + 1)
    p = memberships(y, structure.grid)
    expected = 0.0
    for u in (structure.u_min_V, structure.u_max_V):
        v = q[0:15:3] * y[:, None] + q[1:15:3] * u + q[2:15:3]
        f = (p * v).sum(axis=1, keepdims=True)
        expected += float((p * (v - f) ** 2).sum(axis=1).mean()) / 2.0
    assert disagreement(structure).square(q) == pytest.approx(expected, rel=1e-10)


@pytest.mark.slow
def test_refinement_keeps_rules_in_agreement_where_the_record_does_not_determine_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    record = narrow_record(2, noise_um=0.001)
    held = fit(record)
    monkeypatch.setattr(least_squares, "DISAGREEMENT_SHARE", 0.0)
    free = fit(record)
    structure = structure_for(record, FitSettings())
    deviations = [np.sqrt(disagreement(structure).square(model.parameters)) for model in (held, free)]
    errors = [model.history["outcome"]["free_run_rms_um"]["refined"] for model in (held, free)]
    assert deviations[0] < 0.5 * deviations[1]
    assert errors[0] < 1.05 * errors[1]
