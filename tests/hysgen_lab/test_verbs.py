"""What the laboratory's verbs read, hand on and answer."""

import shlex
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from hysgen.cli import main
from hysgen.cli.console import Console
from hysgen.cli.main import parser
from hysgen_lab.verbs import LABORATORY, studies

CALLS = {
    "track --seconds 0.5": {"seconds": 0.5},
    "bank": {"seeds": "1000:1010", "family": None, "log": None},
    "endurance": {"samples": 1e6, "others": 0},
}


@pytest.mark.parametrize("call", CALLS, ids=str)
def test_every_option_is_read_and_has_the_default_that_its_help_states(call: str) -> None:
    words = shlex.split(call)
    given = vars(parser(words[:1], LABORATORY).parse_args(words))
    assert {name: given[name] for name in CALLS[call]} == CALLS[call]


@pytest.mark.parametrize(
    ("words", "samples", "others"),
    [
        ("--samples 1000", 1000, 0),
        ("--samples 0 --others 1e3", 0, 1000),
        ("--samples 1e12 --others 1e12", 10**12, 10**12),
    ],
)
def test_endurance_takes_whole_numbers_from_a_thousand_on(
    words: str, samples: int, others: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[tuple[int, int]] = []
    monkeypatch.setattr(studies, "endurance_tests", lambda *given: asked.append(given) or [])
    monkeypatch.setattr(studies, "endure", lambda tests, _: [])
    assert main(["endurance", *words.split()], LABORATORY) == 0
    assert asked == [(samples, others)]


@pytest.mark.parametrize("words", ["--samples 999", "--samples 0", "--others 1", "--samples 1e13", "--samples 1000.5"])
def test_fewer_samples_than_test_endurance_are_refused(words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["endurance", *words.split()], LABORATORY) == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize(
    ("complete", "holds", "code"), [(True, True, 0), (True, None, 0), (True, False, 1), (False, False, 130)]
)
def test_the_banks_code_is_its_limits_or_that_of_an_interrupt(
    complete: bool, holds: bool | None, code: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    given: list[Any] = []

    def judged(name: str, category: str, exact: bool) -> Any:
        return SimpleNamespace(
            name=name, category=category, exact=exact, named=("a", "b")[: exact + 1], difference=lambda: "creep"
        )

    def judge(*arguments: Any) -> Any:
        given.extend(arguments)
        for place, one in enumerate(
            (judged("p", "poor", False), judged("q", "good", False), judged("r", "good", True))
        ):
            arguments[4]((place + 1) / 4, one)
        return SimpleNamespace(table=lambda: "table", to_json=dict, complete=complete, judgements=[1, 2], asked=3)

    monkeypatch.setattr(studies, "judge_bank", judge)
    monkeypatch.setattr(studies, "limits", lambda _: [studies_limit(holds)])
    monkeypatch.setattr(studies, "limits_table", lambda _: "limits")
    monkeypatch.setattr(studies.dataclasses, "asdict", vars)
    monkeypatch.setattr(Console, "write_json", lambda *_: None)
    assert main(["-v", "bank", "--seeds", "5:8", "--jobs", "2", "--log", "l", "--family", "all"], LABORATORY) == code
    assert (given[0], given[2], given[3], given[5]) == (range(5, 8), tuple(studies.FAMILIES), 2, Path("l"))
    captured = capsys.readouterr()
    assert captured.out == "wrong: q: creep\ntable\n\nlimits\n", "a poor record may be judged wrong"
    assert "25.0 %  p: a (1 judged, 1 wrong)\n" in captured.err
    assert "75.0 %  r: a, b (3 judged, 2 wrong)\n" in captured.err
    assert ("interrupted: 2 of 3 records" in captured.err) == (not complete)
    for seeds in ("5:5", "6:5", "a:b", "5"):
        assert main(["bank", "--seeds", seeds], LABORATORY) == 2


def studies_limit(holds: bool | None) -> Any:
    return SimpleNamespace(holds=holds)
