"""The paper's rivals: definitions, and recovery of each one's own parameters."""

from __future__ import annotations

import numpy as np
import pytest

from fixtures.random_models import TS_S, lag_record, random_drive
from hysgen.errors import FitError
from hysgen.model.rivals import (
    PrandtlIshlinskii,
    fit_arx,
    fit_prandtl_ishlinskii,
    fit_proportional,
    fit_rivals,
    score_rivals,
)
from hysgen.record import Record, Segment


def test_prandtl_ishlinskii_is_the_papers_twenty_plays_and_finds_itself() -> None:
    # A first sweep over the whole range moves every play, so that none is a mere constant.
    sweep = 100.0 - np.abs(np.linspace(-100.0, 100.0, 400))
    u = np.concatenate([sweep, random_drive(4000, 1)])
    thresholds = np.linspace(0.0, u.max() / 2, 20)
    weights = 0.01 / (1 + np.arange(20))
    y, z = np.empty(u.size), np.full(20, u[0])
    for k, value in enumerate(u):
        z = np.maximum(value - thresholds, np.minimum(value + thresholds, z))
        y[k] = 1.5 + weights @ z
    record = Record.from_segments([Segment("0", u, y)], TS_S)
    found = fit_prandtl_ishlinskii(record)
    np.testing.assert_allclose(found.thresholds_V, thresholds, rtol=1e-15)
    assert found.thresholds_V.size == 20
    fresh_u = np.concatenate([sweep, random_drive(1000, 2)])
    fresh = Record.from_segments([Segment("0", fresh_u, np.zeros(1400))], TS_S)
    truth = PrandtlIshlinskii(thresholds, weights, 1.5)
    # Neighbouring plays are nearly alike, so weights are ill determined and the prediction is what can be compared.
    np.testing.assert_allclose(found.free_run(record)[0], y, atol=1e-9, rtol=0)
    np.testing.assert_allclose(found.free_run(fresh)[0], truth.free_run(fresh)[0], atol=1e-6, rtol=0)


def test_proportional_is_the_straight_line_and_its_own_inverse() -> None:
    u = random_drive(500, 3)
    record = Record.from_segments([Segment("0", u, 0.08 * u + 2.0)], TS_S)
    line = fit_proportional(record)
    assert line.K_V_per_um == pytest.approx(12.5, rel=1e-9)
    assert line.offset_um == pytest.approx(2.0, rel=1e-9)
    np.testing.assert_allclose(line.inverse(line.free_run(record)[0]), u, atol=1e-9, rtol=0)


@pytest.mark.parametrize("delay", [0, 3])
def test_arx_finds_itself_and_runs_free_from_the_first_measured_samples(delay: int) -> None:
    a, b, c = np.array([1.2, -0.35]), np.array([0.004, 0.002, -0.001]), 0.3
    u = random_drive(2000, 4)
    y = np.zeros(u.size)
    y[: 3 + delay] = np.linspace(1.0, 1.3, 3 + delay)
    for k in range(3 + delay, u.size):
        past_u = [u[k - 1 - delay], u[k - 2 - delay], u[k - 3 - delay]]
        y[k] = a @ [y[k - 1], y[k - 2]] + b @ past_u + c
    record = Record.from_segments([Segment("0", u, y), Segment("1", u, y)], TS_S)
    found = fit_arx(record, 2, 3, delay)
    # Noise-free, so the weights are known to rounding times the condition of the regressors, about 1e5.
    np.testing.assert_allclose(found.a, a, atol=1e-8, rtol=0)
    np.testing.assert_allclose(found.b_um_per_V, b, atol=1e-8, rtol=0)
    assert found.first == 3 + delay
    for run in found.free_run(record):
        np.testing.assert_allclose(run, y, atol=1e-7, rtol=0)


def test_rivals_are_scored_in_free_run_by_the_models_own_score() -> None:
    record = lag_record(samples=2000, segments=2)
    rivals = fit_rivals(record)
    named = dict(score_rivals(rivals, record, settle=10))
    assert list(named) == ["Prandtl-Ishlinskii, 20 plays", "proportional", "ARX(2,2,0)"]
    for rival, score in zip(rivals, named.values(), strict=True):
        errors = np.concatenate(
            [(run - s.y_um)[10:] for run, s in zip(rival.free_run(record), record.segments, strict=True)]
        )
        assert score.e_rms_um == pytest.approx(float(np.sqrt(np.mean(errors**2))), rel=1e-12)
        assert score.samples == errors.size


def test_records_that_no_rival_fits_are_refused() -> None:
    down = Record.from_segments([Segment("0", -np.arange(50.0), np.arange(50.0))], TS_S)
    with pytest.raises(FitError, match="the voltage is never positive"):
        fit_prandtl_ishlinskii(down)
    still = Record.from_segments([Segment("0", np.arange(50.0), np.zeros(50))], TS_S)
    with pytest.raises(FitError, match="does not follow the voltage"):
        fit_proportional(still)
    with pytest.raises(FitError, match="choose na >= 1"):
        fit_arx(down, 0, 1)
    with pytest.raises(FitError, match="too short"):
        fit_arx(down, 20, 20)
