"""Least squares one step ahead: Eq. (10) as printed, the batch optimum that it converges to, and the partition."""

import itertools
from typing import Any

import numpy as np
import pytest

from fixtures.random_models import TS_S, lag_record, random_drive
from hysgen.errors import FitError
from hysgen.fitting import FitSettings, PathSize, fit, least_squares
from hysgen.fitting.identify import partition, structure_for
from hysgen.fitting.least_squares import Weighting, information, recursive_least_squares
from hysgen.model.disturbances.periodic import Periodic
from hysgen.model.regression import Structure, regression_rows
from hysgen.model.simulate import free_run
from hysgen.record import Record, Segment
from hysgen_lab.stage import Stage, run
from hysgen_lab.studies.bank.scenario import good

WITH_HUM = FitSettings(terms=(Periodic((130.0, 310.0)),))


def stacked(record: Record, structure: Structure) -> tuple[Any, Any]:
    """All regressors and targets of a record."""
    rows = list(regression_rows(record, structure))
    return np.vstack([part.regressors for part in rows]), np.concatenate([part.target_um for part in rows])


@pytest.mark.parametrize("epsilon", [0.0, 0.3])
@pytest.mark.parametrize("forgetting", [1.0, 0.995])
def test_rls_is_equation_10_sample_by_sample(forgetting: float, epsilon: float) -> None:
    record = lag_record(samples=300, segments=2)
    structure = structure_for(record, WITH_HUM)
    q, P = np.full(structure.size, epsilon), 1e4 * np.eye(structure.size)
    for x, y in zip(*stacked(record, structure), strict=True):
        K = P @ x / (forgetting + x @ P @ x)
        q = q + K * (y - x @ q)
        P = (np.eye(q.size) - np.outer(K, x)) @ P / forgetting
    kernel = recursive_least_squares(record, structure, Weighting(forgetting, 1e4, epsilon))
    # The same products in another order: rounding of P, 1e4 * 1e-16, times squared regressors up to 1e4, enters K each
    # of the 600 times, and forgetting lets it grow by 0.995^-600 = 20: 1e-5 in all.
    np.testing.assert_allclose(kernel, q, atol=1e-5, rtol=0)


@pytest.mark.parametrize("forgetting", [1.0, 0.998])
def test_batch_is_the_weighted_ridge_optimum(forgetting: float) -> None:
    record = lag_record(samples=800, segments=2)
    structure = structure_for(record, WITH_HUM)
    X, y = stacked(record, structure)
    weight = forgetting ** np.arange(y.size - 1, -1, -1.0)
    prior = forgetting**y.size / 1e2
    batch = information(record, structure, Weighting(forgetting, 1e2, 0.5))
    rows = np.vstack([np.sqrt(weight)[:, None] * X, np.sqrt(prior) * np.eye(X.shape[1])])
    target = np.concatenate([np.sqrt(weight) * y, np.full(X.shape[1], np.sqrt(prior) * 0.5)])
    expected = np.linalg.lstsq(rows, target, rcond=None)[0]
    # Both are backward stable; the solutions differ by the condition of the rows, about 1e6, times 1e-16.
    np.testing.assert_allclose(batch.solve(), expected, atol=1e-8 * np.abs(expected).max(), rtol=0)
    away = rows @ expected - target
    assert batch.square(expected) == pytest.approx(float(away @ away), rel=1e-9)


def test_samples_without_trust_do_not_count_whatever_they_hold() -> None:
    clean = lag_record(samples=1500)
    segment = clean.segments[0]
    y, trust = segment.y_um.copy(), np.ones(1500)
    bad = np.array([100, 700, 701, 1300])
    y[bad], trust[bad] = segment.y_um[bad] + 0.5, 0.0
    spoilt = Record.from_segments([Segment("0", segment.u_V, y)], TS_S)
    structure = structure_for(clean, FitSettings())
    X, target = stacked(clean, structure)
    counted = (trust[:-1] * trust[1:]) > 0
    prior = 1e-3 * np.eye(X.shape[1])
    rows = np.vstack([X[counted], prior])
    expected = np.linalg.lstsq(rows, np.concatenate([target[counted], np.zeros(len(prior))]), rcond=None)[0]
    scale = np.abs(expected).max()
    batch = information(spoilt, structure, Weighting(trust=[trust])).solve()
    np.testing.assert_allclose(batch, expected, atol=1e-7 * scale, rtol=0)
    recursive = recursive_least_squares(spoilt, structure, Weighting(trust=[trust]))
    np.testing.assert_allclose(X[counted] @ recursive, X[counted] @ expected, atol=1e-6, rtol=0)


def test_the_partition_is_the_range_of_the_displacement_over_all_segments() -> None:
    record = lag_record(samples=500, segments=3)
    low = min(float(segment.y_um.min()) for segment in record.segments)
    high = max(float(segment.y_um.max()) for segment in record.segments)
    grid = partition(record, 7)
    assert (grid.y_min_um, grid.y_max_um, grid.rules) == (low, high, 7)
    wider = partition(record, 7, margin=0.1)
    assert wider.y_min_um == pytest.approx(low - 0.1 * (high - low), rel=1e-14)
    assert wider.y_max_um == pytest.approx(high + 0.1 * (high - low), rel=1e-14)


def test_the_papers_settings_are_the_defaults_and_stand_in_the_models_history() -> None:
    record = lag_record(samples=1500)
    model = fit(record, FitSettings(method="rls"))
    assert (
        model.history["fit"] | {"rules": 6, "forgetting": 1.0, "alpha": 1e6, "epsilon": 0.0, "margin": 0.0}
        == (model.history["fit"])
    )
    assert model.history["record"]["digest"] == record.digest
    assert (model.u_min_V, model.u_max_V) == record.u_range_V
    assert model.certificates["contraction"]["slope"]["bound"] > 0


REFUSED: dict[str, dict[str, Any]] = {
    "method: 'lms' is unknown": {"method": "lms"},
    "forgetting: 0.0 is out of range": {"forgetting": 0.0},
    "forgetting: 1.1 is out of range": {"forgetting": 1.1},
    "alpha: 0.0 is out of range": {"alpha": 0.0},
    "alpha: nan is out of range": {"alpha": float("nan")},
    "epsilon: inf is out of range": {"epsilon": float("inf")},
    "margin: -0.1 is out of range": {"margin": -0.1},
    "slope_limit: 1.0 is out of range": {"slope_limit": 1.0},
    "iterations: 0 is out of range": {"iterations": 0},
    "settle: -1 is out of range": {"settle": -1},
}


@pytest.mark.parametrize(("message", "bad"), REFUSED.items(), ids=list(REFUSED))
def test_settings_out_of_their_domain_are_refused_by_name(message: str, bad: dict[str, Any]) -> None:
    with pytest.raises(FitError) as refusal:
        FitSettings(**bad)
    assert message in str(refusal.value)


def test_too_few_samples_for_the_structure_are_refused() -> None:
    record = Record.from_segments([Segment("0", random_drive(15, 0), np.arange(15.0))], TS_S)
    with pytest.raises(FitError, match="14 pairs of samples cannot determine 18 parameters"):
        fit(record)


def test_rls_with_a_negative_variance_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    record = lag_record(samples=200)
    structure = structure_for(record, FitSettings(rules=3))
    monkeypatch.setattr(least_squares, "rls_updates", lambda rows, target, forgetting, q, P: P.fill(-1e-12))
    with pytest.raises(FitError, match="lost its covariance"):
        recursive_least_squares(record, structure)


def test_rls_that_lost_its_covariance_is_refused() -> None:
    # A constant input leaves directions without information, and forgetting blows their covariance up.
    u = np.full(40_000, 30.0)
    y = 5.0 + 1e-3 * np.random.default_rng(0).normal(size=u.size)
    record = Record.from_segments([Segment("0", u, y)], TS_S)
    structure = structure_for(record, FitSettings(input_range_V=(0.0, 60.0)))
    with pytest.raises(FitError, match="lost its covariance; forget less, or fit in batch"):
        recursive_least_squares(record, structure, Weighting(forgetting=0.9))


def test_windows_hold_at_most_their_samples_and_reach_both_ends() -> None:
    found = least_squares.windows(600_000, 1_000_000)
    assert sum(at.stop - at.start for at in found) <= 0.6 * least_squares.MOST_SAMPLES
    assert (found[0].start, found[-1].stop) == (0, 600_000)
    assert all(before.stop <= after.start for before, after in itertools.pairwise(found))


def test_a_short_record_is_one_window() -> None:
    assert least_squares.windows(5000, least_squares.MOST_SAMPLES) == [slice(0, 5000)]


@pytest.mark.slow
def test_a_path_fitted_to_windows_is_as_good_as_one_fitted_to_all_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    u_V = good(np.random.default_rng(2), 60_000, 0.0, 100.0)
    stage = Stage.nominal().with_effects(creep=(0.02, 0.05, 1e4))
    record = Record.from_arrays(u_V, run(stage, u_V, 1e-3, seed=2).displacement_um, 1e-3)
    settings = FitSettings(memory=PathSize(plays=4, hats=4, states=2))
    levels = []
    for most in (100_000, 40_000):
        monkeypatch.setattr(least_squares, "MOST_SAMPLES", most)
        found = free_run(fit(record, settings), record)[0]
        levels.append(float(np.sqrt(np.mean((found.y_um - record.segments[0].y_um)[5000:] ** 2))))
    assert levels[1] < 1.1 * levels[0]
