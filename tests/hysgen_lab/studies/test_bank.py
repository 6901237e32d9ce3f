"""The bank: records with hidden effects, the causes that a diagnosis must name, limits of a run, and its log."""

import dataclasses
import io
import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hysgen.cli.console import Console
from hysgen.cli.main import parser
from hysgen.errors import HysgenError
from hysgen_lab.stage.families import FAMILIES
from hysgen_lab.studies.bank import BankResult, Judgement, run, scenario
from hysgen_lab.studies.bank.family_scenario import family_scenario
from hysgen_lab.studies.bank.judge_records import PARAMETERS
from hysgen_lab.studies.bank.log import JudgementLog, read_log
from hysgen_lab.studies.bank.scenario import CATEGORIES, EFFECTS, Scenario
from hysgen_lab.verbs import LABORATORY, studies

SWEEP = (("pair", 1), ("creep", 0), ("none", 3))
"""Category and seed of the records of the sweep. The pair plants saturation and resonance.

The tests of tests/diagnosis diagnose the other categories, and `python -m hysgen_lab bank` hundreds of records of each.
"""


@pytest.fixture(scope="module")
def sweep(once_per_run: Callable[[str, Callable[[], Any]], Any]) -> BankResult:
    judged = once_per_run("bank_sweep", lambda: [run([seed], [category]) for category, seed in SWEEP])
    return BankResult(tuple(record for result in judged for record in result.judgements), (0, 1, 3), len(SWEEP))


@pytest.mark.slow
def test_records_are_answered_with_the_planted_causes_and_no_other(sweep: BankResult) -> None:
    assert {each.category: (each.required, each.named) for each in sweep.judged() if not each.exact} == {}
    assert sweep.false_alarm_rate == 0.0


@pytest.mark.slow
def test_parameters_of_named_causes_lie_within_their_tolerances(sweep: BankResult) -> None:
    seen = sweep.parameter_errors()
    assert {key: error for key, (_, error, _) in seen.items() if error > PARAMETERS.get(key, np.inf)} == {}
    assert len(seen) >= 3


@pytest.mark.slow
def test_the_extended_model_comes_near_the_one_that_knows_the_planted_causes(sweep: BankResult) -> None:
    """Its held-out error is at most twice that of the model with the true extensions, the limit of the bank."""
    assert all(not each.over_truth > 2.0 for each in sweep.judged())


def test_same_seed_makes_the_same_scenario() -> None:
    for category in CATEGORIES:
        first, second = scenario(category, 7), scenario(category, 7)
        assert first.stage == second.stage
        np.testing.assert_array_equal(first.u_V, second.u_V)


def test_category_plants_the_effect_that_it_is_named_after() -> None:
    for effect in EFFECTS:
        assert effect in scenario(effect, 11).planted
    assert scenario("none", 11).planted == ()
    assert scenario("memory", 11).planted == ("memory",)
    assert "unknown" in scenario("unknown", 11).planted


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.slow
def test_stage_of_another_family_has_its_hysteresis_and_the_planted_effect(family: str) -> None:
    for category in ("aging", "coupling", "resonance", "unknown"):
        first, second = family_scenario(family, category, 11), family_scenario(family, category, 11)
        assert first.stage == second.stage
        assert isinstance(first.stage.memory, FAMILIES[family])
        assert category in first.planted
        np.testing.assert_array_equal(first.u_V, second.u_V)
    assert family_scenario(family, "none", 11).planted == ()


def test_record_of_another_family_lacks_its_past_and_has_the_steps_of_its_converter() -> None:
    hidden = family_scenario("bouc-wen", "creep", 5)
    measured = hidden.measure()
    record = hidden.record(measured)
    assert record.samples == len(hidden.u_V) - hidden.past
    codes = (
        np.diff(np.unique(record.segments[0].y_um)) / (2.0 * np.ptp(measured.displacement_um)) * 2**hidden.sensor.bits
    )
    assert np.median(codes) == pytest.approx(np.round(np.median(codes)), abs=1e-3)
    assert codes.min() > 0.99


def test_thermal_hysterons_may_be_named_creep_and_no_other_family() -> None:
    shown = {family: family_scenario(family, "memory", 1).allowed for family in FAMILIES}
    assert {family for family, names in shown.items() if names} == {"thermal"}
    made = judgement(("memory",), ("memory", "creep"), ("memory",), "memory")
    assert not made.exact
    assert dataclasses.replace(made, allowed=shown["thermal"]).exact


def judgement(required: tuple[str, ...], named: tuple[str, ...], planted: tuple[str, ...], category: str) -> Judgement:
    return Judgement(category, 0, 1e3, "good", planted, required, named, dict.fromkeys(planted, 2.0), {}, 0.1, "")


LABORATORY_PARSER = parser(LABORATORY.names, LABORATORY)


def right(category: str, seed: int) -> Judgement:
    """A judgement that is right in everything: memory and, but for quiet records, creep; every parameter close."""
    planted = ("memory",) if category == "memory" else ("memory", category)
    errors = {key: 0.5 * most for key, most in PARAMETERS.items() if key.startswith(category)}
    relative = dict.fromkeys(planted, 2.0)
    return Judgement(category, seed, 1e3, "good", planted, planted, planted, relative, errors, 0.1, "", 15.0, 1.0)


def counted(monkeypatch: pytest.MonkeyPatch, stop_at: int | None = None) -> list[tuple[str, int]]:
    """Puts made-up judgements in place of the bank's records; returns the list of what was judged, growing."""
    begun: list[tuple[str, int]] = []

    def one(hidden: Scenario) -> Judgement:
        if len(begun) == stop_at:
            raise KeyboardInterrupt
        begun.append((hidden.category, hidden.seed))
        return dataclasses.replace(right(hidden.category, hidden.seed), fall=math.nan)

    monkeypatch.setattr("hysgen_lab.studies.bank.judge_records.judge", one)
    return begun


def test_an_interrupted_run_is_resumed_from_its_log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log = tmp_path / "bank.jsonl"
    counted(monkeypatch)
    whole = run([1, 2, 3], ["memory", "creep"])
    counted(monkeypatch, stop_at=4)
    part = run([1, 2, 3], ["memory", "creep"], log=log)
    assert not part.complete
    assert [(v.category, v.seed) for v in part.judgements] == [("memory", 1), ("creep", 1), ("memory", 2), ("creep", 2)]
    log.write_bytes(log.read_bytes() + b'{"category": "me')  # the machine went down while it wrote
    begun = counted(monkeypatch)
    again = run([1, 2, 3], ["memory", "creep"], log=log)
    assert begun == [("memory", 3), ("creep", 3)]
    assert again.complete
    assert again.to_json() == whole.to_json()
    assert [(v.category, v.seed) for v in read_log(log)] == [(v.category, v.seed) for v in whole.judgements]


def test_a_log_of_another_state_of_the_package_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log = tmp_path / "bank.jsonl"
    JudgementLog(log).add(right("creep", 1))
    monkeypatch.setattr("hysgen_lab.studies.bank.log.sources_digest", lambda: "0" * 64)
    with pytest.raises(HysgenError, match="judged by another state of hysgen; remove it"):
        read_log(log)


@pytest.mark.parametrize("text", ["not JSON\n", "[1]\n", '{"category": "creep"}\n'])
def test_a_file_that_is_no_log_is_refused_by_its_name(tmp_path: Path, text: str) -> None:
    log = tmp_path / "other.txt"
    log.write_text(text)
    with pytest.raises(HysgenError, match=r"other\.txt: row 1: "):
        read_log(log)
    assert log.read_text() == text


@pytest.mark.parametrize(("fall", "code"), [(15.0, 0), (3.0, 1)])
def test_exit_code_says_whether_the_limits_are_met(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, fall: float, code: int
) -> None:
    def one(hidden: Scenario) -> Judgement:
        return dataclasses.replace(right(hidden.category, hidden.seed), fall=fall)

    monkeypatch.setattr("hysgen_lab.studies.bank.judge_records.judge", one)
    out, told = io.StringIO(), tmp_path / "bank.json"
    words = ["bank", "--seeds", "1:3", "--categories", "memory", "creep", "--jobs", "1", "--json", str(told)]
    assert studies.run_bank(LABORATORY_PARSER.parse_args(words), Console(str(told), out, io.StringIO())) == code
    assert ("MISSED" in out.getvalue()) == bool(code)
    found = {limit["name"]: limit["holds"] for limit in json.loads(told.read_text())["limits"]}
    assert found["fall by the memory extension"] is not bool(code)
