"""The answer: its form, what it rests on, and the answers 'nothing', 'unknown' and 'this record cannot tell'."""

import dataclasses
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fixtures.bank_records import QUICK, hum_study, record_of
from hysgen.cli import main
from hysgen.diagnosis import DiagnoseSettings, Diagnosis, diagnose
from hysgen.diagnosis.evaluation import evaluate
from hysgen.diagnosis.procedure import name_causes
from hysgen.errors import RecordError
from hysgen.fitting import FitSettings
from hysgen.fitting.refit import compare
from hysgen.record import Record
from hysgen_lab.stage import Stage, run
from hysgen_lab.studies.bank.scenario import good

pytestmark = pytest.mark.slow
"""Every answer needs a diagnosis."""


@pytest.fixture(scope="module")
def hum(once_per_run: Callable[[str, Callable[[], Any]], Any]) -> tuple[Record, Diagnosis]:
    return record_of("periodic", 5), once_per_run("hum", hum_study).diagnosis


def test_ladder_begins_at_the_papers_model_and_ends_at_the_extended_one(hum: tuple[Record, Diagnosis]) -> None:
    found = hum[1]
    assert found.names == ("memory", "periodic")
    assert found.causes[0].step.before_um == found.base_rms_um
    assert found.causes[-1].step.after_um == found.extended_rms_um
    assert [block.kind for block in found.model.blocks] == ["hysteresis"]
    assert [term.kind for term in found.model.terms] == ["periodic"]
    # What is left of the power above the noise and the shares of the causes are one whole.
    assert sum(cause.share for cause in found.causes) + found.unexplained_fraction == pytest.approx(1.0, abs=1e-9)


def test_the_width_of_the_loop_is_that_which_diff_prints(hum: tuple[Record, Diagnosis]) -> None:
    memory, model = hum[1].causes[0], hum[1].model
    printed = {change.what: change.new for change in compare(model, model).changes}
    at = f"loop width at {memory.parameters['loop_Hz'].value:.3g} Hz, mean"
    width_um = memory.parameters["loop_um"]
    assert width_um.value == printed[at]
    # That the error is the spread over repeated noise is tested with the probe.
    assert 1e-4 < width_um.standard_error / width_um.value < 0.05


def test_a_named_cause_has_evidence_and_gain_and_a_refused_cause_a_reason(hum: tuple[Record, Diagnosis]) -> None:
    for cause in hum[1].causes:
        assert cause.evidence
        assert cause.probe_gain is not None
        assert cause.probe_gain > 1.0
        assert cause.alone is not None
        assert cause.alone.low_um > 0.0, "the 95 % interval of the fall of the free-run error"
    assert not {cause.name for cause in hum[1].causes} & {one.name for one in hum[1].refused}
    assert all(one.why for one in hum[1].refused)


def test_a_certificate_that_the_extended_model_lacks_is_reported(hum: tuple[Record, Diagnosis]) -> None:
    record, found = hum
    result = {name: {"holds": name != "inverse"} for name in ("gain", "contraction", "inverse")}
    lacking = dataclasses.replace(found, model=dataclasses.replace(found.model, certificates=result))
    assert lacking.missing_certificates == ("inverse",)
    assert lacking.to_json()["missing_certificates"] == ["inverse"]
    assert "not certified in the extended model: inverse" in str(evaluate(lacking, record, None, 0.65))


def test_held_out_displacement_changes_scores_only(hum: tuple[Record, Diagnosis]) -> None:
    record, found = hum
    segment = record.segments[0]
    y_um = segment.y_um.copy()
    y_um[round(0.65 * record.samples) :] *= 0.5
    other = diagnose(Record.from_arrays(segment.u_V, y_um, record.Ts_s), settings=QUICK)
    assert other.names == found.names
    assert found.remaining.sudden == ""
    np.testing.assert_array_equal(other.model.parameters, found.model.parameters)
    assert other.extended_rms_um > 2 * found.extended_rms_um


def test_the_command_holds_rows_out_of_one_record(tmp_path: Path) -> None:
    """What the identified rows leave in the stage goes on in those held out: --rows cuts no record in two."""
    record = record_of("none", 2)
    fitted_rows = record.samples // 2
    found = diagnose(record, settings=DiagnoseSettings(identify=fitted_rows / record.samples))
    csv, result = tmp_path / "record.csv", tmp_path / "result.json"
    columns = (record.Ts_s * np.arange(record.samples), record.segments[0].u_V, record.segments[0].y_um)
    lines = [f"{t:.9g},{u!r},{y!r}" for t, u, y in zip(*(column.tolist() for column in columns), strict=True)]
    csv.write_text("\n".join(["time_s,voltage_V,displacement_um", *lines]) + "\n")
    assert main(["diagnose", str(csv), "--rows", f"0:{fitted_rows}", "--json", str(result)]) == 0
    extended_um = json.loads(result.read_text())["free_run_rms"]["extended"]
    assert extended_um == pytest.approx(found.extended_rms_um, rel=1e-6)


def test_separate_holdout_is_scored_and_not_fitted() -> None:
    record = record_of("memory", 3)
    whole, late = record.split(0.65)
    found = diagnose(whole, late, QUICK)
    assert found.names == ("memory",)
    assert found.held_rows.min() >= whole.samples


def test_a_stage_without_a_planted_cause_is_diagnosed_with_none_and_settings_reach_the_models() -> None:
    u_V = good(np.random.default_rng(2), 8000, 0.0, 100.0)
    straight = run(dataclasses.replace(Stage.nominal(), memory=None), u_V, 1e-3, seed=2)
    record = Record.from_arrays(u_V, straight.displacement_um, 1e-3)
    found = diagnose(record, settings=dataclasses.replace(QUICK, fit=FitSettings(rules=3, certified=False)))
    assert found.names == ()
    assert found.model.grid.rules == 3
    assert "no cause" in repr(evaluate(found, record, None, 0.65))


def test_a_knock_is_told_with_time_and_size_and_spoils_no_model() -> None:
    """The fall is compared with that of the same record without the knock."""
    record = record_of("memory", 3)
    (segment,) = record.segments
    span_um, at = float(np.ptp(segment.y_um)), segment.samples // 3
    knocked_um = segment.y_um + 0.02 * span_um * (np.arange(segment.samples) >= at)
    sound = diagnose(record, settings=QUICK)
    found = diagnose(Record.from_arrays(segment.u_V, knocked_um, record.Ts_s), settings=QUICK)
    assert found.names == (*sound.names, "unknown")
    assert found.unknown is not None
    told = re.search(r"jumps by ([+-][0-9.]+) um at ([0-9.]+) s", found.unknown)
    assert told is not None
    assert float(told[1]) == pytest.approx(0.02 * span_um, rel=0.05)
    assert float(told[2]) == pytest.approx(at * record.Ts_s, rel=0.01)
    assert found.extended_rms_um < 1.2 * sound.extended_rms_um


def test_stick_slip_is_unknown_and_described() -> None:
    naming = name_causes(record_of("unknown", 0))
    assert naming.names[-1] == "unknown"
    assert naming.unknown is not None
    assert "left" in naming.unknown


def test_poor_excitation_is_answered_with_the_next_experiment() -> None:
    naming = name_causes(record_of("poor", 0))
    assert naming.next_experiment.startswith("drive with")


def test_short_record_is_refused_in_one_line() -> None:
    u_V = np.sin(np.linspace(0, 20, 300))
    with pytest.raises(RecordError, match="a diagnosis needs 400; record longer"):
        diagnose(Record.from_arrays(u_V, 0.1 * u_V, 1e-3))


@pytest.mark.parametrize("beyond_V", [35.0, 0.0])
def test_rows_beyond_the_range_that_was_identified_are_the_reason_for_what_is_left(beyond_V: float) -> None:
    u_V = good(np.random.default_rng(3), 9000, 0.0, 60.0)
    u_V[6500:] += np.linspace(0.0, beyond_V, 2500)
    y_um = run(Stage.nominal(), u_V, 1e-3, seed=4).displacement_um
    left = diagnose(Record.from_arrays(u_V, y_um, 1e-3), settings=QUICK).remaining
    assert bool(re.search(r"the fitted ones through [\d.]+ \.\. 60 V", left.reason)) == bool(beyond_V)
