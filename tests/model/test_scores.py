"""Scores: the paper's definitions, persistence, noise floor, and the scored samples.

The paper's rivals: definitions, and recovery of each one's own parameters.
"""

import json

import numpy as np
import pytest

from fixtures.random_models import TS_S, lag_record, random_drive
from hysgen.errors import FitError, RecordError
from hysgen.fitting import FitSettings, fit
from hysgen.model.rivals import (
    PrandtlIshlinskii,
    fit_arx,
    fit_prandtl_ishlinskii,
    fit_proportional,
    fit_rivals,
    score_rivals,
)
from hysgen.model.scores import persistence, score, score_lines, score_prediction
from hysgen.model.simulate import free_run, one_step
from hysgen.record import Record, Segment


def record_of(*columns: tuple[list[float], list[float]]) -> Record:
    """A record from (u, y) lists."""
    return Record.from_segments(
        [Segment(str(i), np.asarray(u), np.asarray(y)) for i, (u, y) in enumerate(columns)], TS_S
    )


def test_errors_are_the_papers_e_rms_and_maximum_e_r() -> None:
    record = record_of(([0.0] * 5, [1.0, 2.0, 4.0, 3.0, 2.0]), ([0.0] * 3, [1.0, 1.0, 0.0]))
    guess = [np.array([9.0, 2.5, 4.0, 2.0, 2.0]), np.array([9.0, 1.0, 0.5])]
    found = score_prediction(record, guess)
    # Sample 0 of each segment is given: errors 0.5, 0, -1, 0 and 0, 0.5; the displacement spans 0 to 4.
    assert found.samples == 6
    assert found.e_rms_um == pytest.approx(np.sqrt((0.25 + 1.0 + 0.25) / 6), rel=1e-15)
    assert found.largest_um == 1.0
    assert found.e_r_percent == pytest.approx(25.0, rel=1e-15)
    assert found.of_span_percent == pytest.approx(100 * found.e_rms_um / 4.0, rel=1e-15)


@pytest.mark.parametrize(("settle", "said"), [(4, "leave none of 6 to score"), (-5, "-5 is no number of samples")])
def test_a_score_of_no_sample_is_refused(settle: int, said: str) -> None:
    record = record_of(([0.0] * 4, [5.0, 9.0, 1.0, 1.0]), ([0.0] * 2, [5.0, 9.0]))
    with pytest.raises(RecordError, match=said):
        score_prediction(record, [np.zeros(4), np.zeros(2)], settle=settle)


def test_e_r_does_not_depend_on_the_zero_of_the_sensor_and_has_no_value_where_nothing_moves() -> None:
    y = np.array([1.0, 2.0, 4.0, 3.0])
    errors = [
        score_prediction(record_of(([0.0] * 4, (y + zero).tolist())), [y + zero + 0.3]).e_r_percent
        for zero in (0.0, -10.0, 1000.0)
    ]
    assert errors == pytest.approx([10.0] * 3, rel=1e-9)
    found = score_prediction(record_of(([0.0] * 3, [2.0] * 3)), [np.full(3, 2.5)])
    assert found.e_r_percent is None
    assert "-" in score_lines([("x", found)])[2].split()
    json.dumps(found.to_json(), allow_nan=False)


def test_a_score_shows_one_step_horizon_and_free_run_beside_persistence() -> None:
    record = lag_record(samples=3000, segments=2)
    model = fit(record, FitSettings(method="batch"))
    scores = score(model, record, settle=20)
    assert scores.one_step == score_prediction(record, [run.y_um for run in one_step(model, record)], 20)
    assert scores.free_run == score_prediction(record, [run.y_um for run in free_run(model, record)], 20)
    assert scores.persistence == score_prediction(record, persistence(record), 20)
    assert scores.persistence.samples == scores.one_step.samples == 2 * 2980
    for segment, guess in zip(record.segments, persistence(record), strict=True):
        np.testing.assert_array_equal(guess[1:], segment.y_um[:-1])
    assert scores.horizon.steps[0] == 1
    assert scores.horizon.rms_um[-1] == pytest.approx(scores.free_run.e_rms_um, rel=0.5)
    data = json.loads(json.dumps(scores.to_json(), allow_nan=False))
    assert data["free_run"]["e_rms_um"] == scores.free_run.e_rms_um
    assert data["settle"] == 20
    assert data["record"]["digest"] == record.digest
    for phrase in ("free run", "one step", "persistence", "noise floor", "rms um after ", "5960 samples scored"):
        assert phrase in scores.table()


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
    for rival, found in zip(rivals, named.values(), strict=True):
        errors = np.concatenate(
            [(run - s.y_um)[10:] for run, s in zip(rival.free_run(record), record.segments, strict=True)]
        )
        assert found.e_rms_um == pytest.approx(float(np.sqrt(np.mean(errors**2))), rel=1e-12)
        assert found.samples == errors.size


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
