"""A step of a long computation is kept until the whole is done, for the same inputs and the same code only."""

from __future__ import annotations

from pathlib import Path

import pytest

from hysgen.diagnosis import DiagnoseSettings, procedure
from hysgen.machine import native
from hysgen.machine.checkpoint import forget, resumed
from hysgen.record import Record
from hysgen.stage import Stage, run
from hysgen.stage.signals import nested_amplitudes


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    native._usable.cache_clear()
    monkeypatch.setenv("HYSGEN_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_a_step_is_computed_once_for_its_inputs_and_code(tmp_path: Path) -> None:
    made: list[int] = []

    def compute() -> int:
        made.append(1)
        return len(made)

    (tmp_path / "code.py").write_text("a = 1")
    assert [resumed(("x",), tmp_path, compute) for _ in range(2)] == [1, 1]
    assert resumed(("y",), tmp_path, compute) == 2
    (tmp_path / "code.py").write_text("a = 2")
    assert resumed(("x",), tmp_path, compute) == 3
    forget(("x",), tmp_path)
    assert resumed(("x",), tmp_path, compute) == 4
    assert callable(resumed(("z",), tmp_path, lambda: lambda: 0))  # what cannot be kept is returned all the same


@pytest.mark.slow
def test_an_interrupted_diagnosis_goes_on_after_its_search(monkeypatch: pytest.MonkeyPatch, cache: Path) -> None:
    u_V = nested_amplitudes(1e-3, (5.0,), 40.0, 25.0, 3)
    record = Record.from_arrays(u_V, run(Stage.nominal(), u_V, 1e-3, seed=7).displacement_um, 1e-3)
    searches: list[int] = []
    found = procedure.search
    monkeypatch.setattr(procedure, "search", lambda *given: (searches.append(1), found(*given))[1])

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    forms = procedure.with_best_forms
    monkeypatch.setattr(procedure, "with_best_forms", interrupted)
    with pytest.raises(KeyboardInterrupt):
        procedure.diagnose(record, settings=DiagnoseSettings(resume=True))
    assert len(list(cache.glob("step-*"))) == 1
    monkeypatch.setattr(procedure, "with_best_forms", forms)
    resumed_one = procedure.diagnose(record, settings=DiagnoseSettings(resume=True))
    assert len(searches) == 1
    assert not list(cache.glob("step-*"))
    assert resumed_one.to_json() == procedure.diagnose(record).to_json()
