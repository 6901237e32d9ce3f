"""Scores: the paper's definitions, persistence, noise floor, and the scored samples."""

from __future__ import annotations

import json

import numpy as np
import pytest

from fixtures.random_models import TS_S, lag_record
from hysgen.errors import RecordError
from hysgen.fitting import FitSettings, fit
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


def test_settling_samples_are_left_out_of_every_score() -> None:
    record = record_of(([0.0] * 4, [5.0, 9.0, 1.0, 1.0]), ([0.0] * 2, [5.0, 9.0]))
    found = score_prediction(record, [np.zeros(4), np.zeros(2)], settle=2)
    assert (found.samples, found.e_rms_um, found.e_r_percent) == (2, 1.0, 12.5)


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


def test_percentages_of_a_cut_record_refer_to_the_stroke_of_the_whole_one() -> None:
    """`hysgen score --rows` and `hysgen diagnose` state the same error as the same share of the stroke."""
    whole = record_of(([0.0] * 6, [0.0, 8.0, 2.0, 3.0, 4.0, 3.0]))
    found = score_prediction(whole.rows(2, 6), [np.array([2.0, 3.4, 4.0, 3.0])])
    assert found.e_r_percent == pytest.approx(100 * 0.4 / 8.0)
    assert found.of_span_percent == pytest.approx(100 * found.e_rms_um / 8.0)


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
    for phrase in (
        "free run",
        "one step",
        "persistence",
        "noise floor",
        "rms um after ",
        "5960 samples scored",
    ):
        assert phrase in scores.table()
