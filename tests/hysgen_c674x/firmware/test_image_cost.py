"""What `hysgen firmware` says of the image: sections, cycles by state, timing."""

from __future__ import annotations

import re
from types import SimpleNamespace
from typing import Any

import pytest

from hysgen.cli import main
from hysgen.cli.console import Console
from hysgen.errors import TargetError
from hysgen_c674x.firmware import image_cost


def test_the_table_of_cycles_has_a_row_for_each_state() -> None:
    run: Any = SimpleNamespace(
        interrupt={"TRACK": (1000, 3750)},
        idle=(10, 75),
        equal=True,
        differing=0,
        samples=9,
        commits=2,
        selftest=0,
        boot=77,
    )
    text = image_cost.cycles_table(run)
    assert "interrupt, TRACK  1000 .. 3750   50.0 %" in text
    assert "idle loop             10 .. 75    1.0 %" in text
    assert "9 samples, 2 commits: the host's bits; self-test at boot: 0 mismatches, 77 cycles" in text
    run.equal, run.differing = False, 4
    assert "9 samples, 2 commits: NOT THE HOST'S BITS in 4;" in image_cost.cycles_table(run)


def test_firmware_states_sections_bounds_and_cycles_and_what_the_simulator_lacks(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    run = SimpleNamespace(
        interrupt={},
        idle=(1, 2),
        equal=True,
        differing=0,
        samples=9,
        commits=0,
        selftest=0,
        boot=1,
        to_json=lambda: "run",
    )
    section = SimpleNamespace(name=".text", address=0x11800000, memory="L2", size=77)
    built = SimpleNamespace(sections=[section], used={"L2": 77}, compiler="gcc 12", to_json=lambda: "built")
    results: list[Any] = []
    monkeypatch.setattr(image_cost, "MEMORIES", {"L2": (0, 262_144)})
    monkeypatch.setattr(image_cost, "link_image", lambda name, texts: built)
    monkeypatch.setattr(image_cost, "compile_image", lambda texts: "compiled")
    monkeypatch.setattr("hysgen.cli.verbs.firmware.firmware_model", lambda model, aligned: {"model.h": model.name})
    monkeypatch.setattr(image_cost, "static_bounds", lambda name, compiled: {"f": (3, 5), "g": None, compiled: (1, 1)})
    monkeypatch.setattr(image_cost, "simulate", lambda model, texts, compiled, samples: run if samples == 9 else 1 / 0)
    monkeypatch.setattr(image_cost, "timings", lambda model, compiled: {compiled: SimpleNamespace(to_json=lambda: "t")})
    monkeypatch.setattr(image_cost, "timing_rows", lambda timed, budget: [[str(budget)] * len(image_cost.TIMING_HEADS)])
    monkeypatch.setattr(Console, "write_json", lambda _, result: results.append(result))
    assert main(["firmware", "appendix_a", "--samples", "9"]) == 0
    out = capsys.readouterr().out
    for line in (
        r"\.text +0x11800000  L2 +77",
        r"L2: 77 of 262144 bytes",
        r"gcc 12",
        r"f +3 \.\. 5",
        r"g +not bounded",
    ):
        assert re.search(f"^{line}$", out, re.M), line
    assert "7500" in out.rpartition("nothing ran on silicon")[2], "the timing stands last, with the period's cycles"
    assert results[-1]["simulated"] == "run"
    assert results[-1]["timing"] == {"compiled": "t"}

    def lacks(*_: object) -> None:
        raise TargetError("no such instruction")

    monkeypatch.setattr(image_cost, "simulate", lacks)
    assert main(["firmware", "appendix_a", "--samples", "9"]) == 0
    assert capsys.readouterr().err == "warning: cycles are missing: no such instruction\n"
    assert (results[-1]["target"], results[-1]["simulated"], results[-1]["timing"]) == ("built", None, None)
