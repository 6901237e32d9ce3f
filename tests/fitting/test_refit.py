"""Re-identification: same structure, new numbers; only parameter file, self-test and manifest change."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from hysgen.api.code import _as_before
from hysgen.codegen import generate, write
from hysgen.errors import ModelError
from hysgen.fitting import FitSettings, PathSize, fit
from hysgen.fitting.refit import compare, refit
from hysgen.record import Record
from hysgen_lab.stage import Stage, run
from hysgen_lab.stage.signals import nested_amplitudes

TS_S = 1e-4


def record_of(stage: Stage, seed: int) -> Record:
    u_V = nested_amplitudes(TS_S, (50.0, 20.0), 40.0, 25.0, 4)
    return Record.from_arrays(u_V, run(stage, u_V, TS_S, seed).displacement_um, TS_S, source=f"seed {seed}")


@pytest.fixture(scope="module")
def records() -> tuple[Record, Record]:
    """The stage, and the stage with an actuator that moves a tenth further."""
    stage = Stage.nominal()
    return record_of(stage, 1), record_of(dataclasses.replace(stage, stroke_um=1.1 * stage.stroke_um), 2)


@pytest.mark.slow
def test_refit_changes_only_the_numbers_of_the_generated_c(records: tuple[Record, Record]) -> None:
    old = fit(records[0], FitSettings(name="axis", memory=PathSize()))
    new, scores = refit(old, records[1])
    before, after = generate(old), generate(new)
    changed = {file for file in before if before[file] != after[file]}
    assert changed == {"axis_params.h", "axis_selftest_data.h", "axis.json", "MANIFEST.json"}
    assert before.keys() == after.keys()
    assert scores.free_run.of_span_percent < 3.0


@pytest.mark.slow
def test_refit_keeps_the_part_of_the_range_to_which_the_model_was_restricted(records: tuple[Record, Record]) -> None:
    old = fit(records[0], FitSettings(name="axis", memory=PathSize()))
    part = old.within((old.grid.y_min_um + 0.3, old.grid.y_max_um - 0.3))
    new, _ = refit(part, records[1])
    assert (new.grid.y_min_um, new.grid.y_max_um) == (part.grid.y_min_um, part.grid.y_max_um)
    assert new.grid.ends_um == refit(old, records[1])[0].grid.ends_um
    before, after = generate(part), generate(new)
    assert before["axis.c"] == after["axis.c"]


@pytest.mark.slow
def test_refit_fits_the_whole_record_and_keeps_a_restricted_input_range(records: tuple[Record, Record]) -> None:
    old = fit(records[0], FitSettings(name="axis", memory=PathSize()))
    part = old.within(None, (0.5 * old.u_max_V, 0.75 * old.u_max_V))
    new, _ = refit(part, records[1])
    assert (new.u_min_V, new.u_max_V) == (part.u_min_V, part.u_max_V)
    np.testing.assert_array_equal(new.parameters, refit(old, records[1])[0].parameters)


@pytest.mark.slow
def test_refit_generates_again_over_the_ranges_that_the_folder_had(
    records: tuple[Record, Record], tmp_path: Path
) -> None:
    old = fit(records[0], FitSettings(name="axis", memory=PathSize()))
    part = old.within((old.grid.y_min_um + 0.3, old.grid.y_max_um - 0.3), (old.u_min_V, 0.9 * old.u_max_V))
    write(generate(part), tmp_path)
    new, _ = refit(old, records[1])
    again, _ = _as_before(new, tmp_path)
    assert (again.grid.y_min_um, again.grid.y_max_um) == (part.grid.y_min_um, part.grid.y_max_um)
    assert (again.u_min_V, again.u_max_V) == (part.u_min_V, part.u_max_V)
    assert generate(again)["axis.c"] == generate(part)["axis.c"]


@pytest.mark.slow
def test_compare_finds_the_gain_that_moved_by_a_tenth(records: tuple[Record, Record]) -> None:
    old = fit(records[0], FitSettings(name="axis", memory=PathSize()))
    new, _ = refit(old, records[1])
    moved = {change.what: change.percent for change in compare(old, new, records).changes}
    # Ten percent were planted; noise and the fit's own freedom are worth a percent.
    assert moved["DC gain, mid-range"] == pytest.approx(10.0, abs=1.5)
    scores = compare(old, new, records).scores
    assert scores[1][2] < 0.2 * scores[1][1]


def test_models_of_different_structure_are_not_compared_number_by_number(records: tuple[Record, Record]) -> None:
    old, new = (fit(records[0], FitSettings(rules=rules, method="batch")) for rules in (4, 5))
    with pytest.raises(ModelError, match=r"structures differ \(4 rules, no terms against 5 rules, no terms\)"):
        compare(old, new)


def test_a_record_at_another_rate_is_refused(records: tuple[Record, Record]) -> None:
    old = fit(records[0], FitSettings(method="batch"))
    half = Record.from_arrays(records[1].segments[0].u_V[::2], records[1].segments[0].y_um[::2], 2 * TS_S)
    with pytest.raises(ModelError, match="record at the model's rate"):
        refit(old, half)
    assert np.isfinite(old.parameters).all()
