"""The limits of a run of the bank, and that an interrupted run is resumed from its log."""

from __future__ import annotations

import dataclasses
import io
import json
import math
from pathlib import Path

import pytest

from hysgen.cli.console import Console
from hysgen.cli.main import parser
from hysgen.errors import HysgenError
from hysgen_lab.studies.bank import BankResult, Judgement, limits, run
from hysgen_lab.studies.bank.limits import PARAMETERS, QUIET, RECORDS
from hysgen_lab.studies.bank.log import JudgementLog, read_log
from hysgen_lab.studies.bank.scenario import Scenario
from hysgen_lab.verbs import LABORATORY, studies

LABORATORY_PARSER = parser(LABORATORY.names, LABORATORY)


def right(category: str, seed: int) -> Judgement:
    """A judgement that is right in everything: memory and, but for quiet records, creep; every parameter close."""
    planted = ("memory",) if category == "memory" else ("memory", category)
    errors = {key: 0.5 * most for key, most in PARAMETERS.items() if key.startswith(category)}
    relative = dict.fromkeys(planted, 2.0)
    return Judgement(category, seed, 1e3, "good", planted, planted, planted, relative, errors, 0.1, "", 15.0, 1.0)


def full() -> list[Judgement]:
    """As many records as the limits speak of."""
    hiding = sorted({key.split(".")[0] for key in PARAMETERS})
    loud = [right(hiding[i % len(hiding)], i) for i in range(RECORDS - QUIET)]
    return loud + [right("memory", i) for i in range(QUIET)]


def judged(judgements: list[Judgement]) -> dict[str, str]:
    """Marks of all limits by name."""
    return {limit.name: limit.mark for limit in limits(BankResult(tuple(judgements), (0,), len(judgements)))}


def test_a_run_without_error_meets_every_limit() -> None:
    assert set(judged(full()).values()) == {"met"}


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
