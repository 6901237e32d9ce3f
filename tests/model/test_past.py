"""A record that is cut keeps its past, and rows that an unknown past spoils are not scored."""

import dataclasses

import numpy as np
import pytest

from hysgen.diagnosis.prepare import prepare
from hysgen.fitting import FitSettings, PathSize, fit
from hysgen.model.model import Model
from hysgen.model.scores import score, unknown_past
from hysgen.record import Record
from hysgen_lab.stage import Stage, run
from hysgen_lab.stage.signals import nested_amplitudes

TS_S = 1e-4
CUT = 6240
"""A row in the middle of a swing, where the plays do not stand as a segment that starts there supposes."""


@pytest.fixture(scope="module")
def record() -> Record:
    u_V = nested_amplitudes(TS_S, (50.0, 20.0), 40.0, 25.0, 4)
    u_V = np.concatenate([u_V, u_V])
    return Record.from_arrays(u_V, run(Stage.nominal(), u_V, TS_S, seed=7).displacement_um, TS_S)


@pytest.fixture(scope="module")
def model(record: Record) -> Model:
    return fit(record.rows(0, CUT), FitSettings(memory=PathSize()))


def forgotten(record: Record) -> Record:
    """The same rows of a record without their past."""
    return Record.from_segments([dataclasses.replace(s, past=None) for s in record.segments], record.Ts_s)


@pytest.mark.slow
def test_a_part_of_a_record_is_scored_as_inside_the_whole_record(record: Record, model: Model) -> None:
    rest = record.rows(CUT, record.samples)
    whole = score(model, record, settle=CUT + 1).free_run.e_rms_um
    assert score(model, rest).free_run.e_rms_um == pytest.approx(whole, rel=1e-9)
    assert score(model, record.split_at(CUT)[1]).free_run.e_rms_um == pytest.approx(whole, rel=1e-9)
    assert score(model, record.rows(3000, record.samples).rows(CUT - 3000, record.samples - 3000), 0).free_run == (
        score(model, rest, 0).free_run
    )
    # The rows alone, started at rest, are wrong by many times more: without a past this is what was scored.
    assert score(model, forgotten(rest), settle=0).free_run.e_rms_um > 20.0 * whole


@pytest.mark.slow
def test_rows_that_depend_on_an_unknown_past_are_found_left_out_and_said(record: Record, model: Model) -> None:
    rest = forgotten(record.rows(CUT, record.samples))
    (rows,) = unknown_past(model, rest, 1e-3).rows
    assert 0 < rows < 0.3 * rest.samples
    scores, all_rows = score(model, rest), score(model, rest, settle=0)
    assert scores.unknown_past == unknown_past(model, rest, scores.noise.rms_um)
    # 0.043 um with these rows, 0.00125 um without them, 0.00122 um where the past is known.
    assert scores.free_run.e_rms_um < 0.1 * all_rows.free_run.e_rms_um
    assert scores.with_unknown_past_um == all_rows.free_run.e_rms_um
    assert scores.free_run.e_rms_um < 1.1 * score(model, record.rows(CUT, record.samples)).free_run.e_rms_um
    assert f"not scored: the first {rows} samples depend on the input before the record" in str(scores)
    assert unknown_past(model, record.rows(CUT, record.samples), 1e-3).rows == (0,)
    plain = fit(record.rows(0, CUT), FitSettings(method="batch"))
    assert unknown_past(plain, rest, 1e-3).rows == (0,)


def test_a_record_that_never_covers_the_range_of_the_model_is_said_to_depend_on_its_past(
    record: Record, model: Model
) -> None:
    small = forgotten(record.rows(8320, 9200))
    found = unknown_past(model, small, 1e-3)
    assert found.later_um > 0.01
    assert "the scored samples too depend on the input before the record" in str(score(model, small))


@pytest.mark.slow
def test_a_fit_to_later_rows_runs_through_the_rows_before_them(record: Record) -> None:
    later = record.rows(CUT, record.samples)
    settings = FitSettings(memory=PathSize(), method="batch")
    errors = [
        score(fit(part, settings), record, settle=CUT + 1).free_run.e_rms_um for part in (later, forgotten(later))
    ]
    assert errors[0] < 1.05 * errors[1]


def test_parts_of_a_split_are_diagnosed_like_the_whole_record(record: Record) -> None:
    known, unseen = record.split(0.6)
    whole, parts = prepare(record, identify=0.6), prepare(known, unseen)
    assert parts.cut == whole.cut
    np.testing.assert_array_equal(parts.use, whole.use)
    np.testing.assert_array_equal(parts.y_um, whole.y_um)
    # Held-out rows that do not follow the identification part: their past is simulated and not scored.
    apart = prepare(record.rows(0, 5000), record.rows(8000, 11000))
    assert apart.cut == 5000
    assert apart.held_rows[0] >= 5000 + 8000
    assert apart.held_rows.size == 3000
