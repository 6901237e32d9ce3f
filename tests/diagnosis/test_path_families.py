"""The benchmark of the five families: its chains hold the causes that a stage has, and a fit of them predicts."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

from hysgen.diagnosis.prepare import prepare
from hysgen.diagnosis.probe import Chain, refine, rms
from hysgen.diagnosis.score import present
from hysgen.diagnosis.search import thinned
from hysgen_lab.stage.families import SCENARIOS, plant, records

SCRIPT = Path(__file__).parents[2] / "benchmarks" / "path_families.py"


@pytest.fixture(scope="module")
def benchmark() -> ModuleType:
    spec = importlib.util.spec_from_file_location("path_families", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_the_true_chain_holds_the_causes_of_the_scenario(benchmark: ModuleType, scenario: str) -> None:
    for seed in range(4):
        chain = benchmark.true_chain(plant("bouc-wen", scenario, seed))
        assert set(present(chain)) == {"memory", *SCENARIOS[scenario]}


def test_the_true_chain_predicts_a_record_that_it_was_not_fitted_to(
    benchmark: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(benchmark, "records", lambda hidden: records(hidden, (6000, 4000)))
    hidden = plant("preisach", "delay", 1)
    record, other = benchmark.measured(hidden)
    prepared = prepare(record, other)
    scored = prepared.held_rows - record.samples
    errors = []
    for chain in (benchmark.true_chain(hidden), Chain(hidden.stage.lag_s)):
        fit = refine(thinned(prepared.scene()), chain, rounds=3)
        error_um = benchmark.predicted(fit, prepared, other) - other.segments[0].y_um
        errors.append(rms(error_um[scored]) / hidden.stroke_um)
    # Measured: 7.5e-4 of the stroke, and 1.1e-2 without the delay; the noise is 2.5e-4.
    assert errors[0] < 1e-3
    assert errors[1] > 5 * errors[0]


@pytest.mark.slow
def test_the_command_prints_a_row_for_each_stage(
    benchmark: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr(benchmark, "records", lambda hidden: records(hidden, (6000, 4000)))
    log = tmp_path / "log.jsonl"
    arguments = ["--seeds", "1", "--families", "bouc-wen", "--scenarios", "memory", "--log", str(log)]
    monkeypatch.setattr(sys, "argv", ["path_families.py", *arguments])
    benchmark.main()
    shown = capsys.readouterr().out
    assert shown.count("bouc-wen") == 2  # its row, and its line of the summary
    assert "memory" in shown
    assert len(log.read_text(encoding="utf-8").splitlines()) == 1
