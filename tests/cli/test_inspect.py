"""inspect says what a file holds, and which causes its excitation can show."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from hysgen.cli import main
from hysgen.record import Record, record_csv
from hysgen.record.bundled import bundled_csv
from hysgen.record.inspection import inspect

TS_S = 1e-4


def met(u_V: np.ndarray) -> dict[str, bool]:
    rng = np.random.default_rng(2)
    y_um = 0.05 * u_V + 0.001 * rng.normal(size=u_V.size)
    said = json.loads(json.dumps(inspect(Record.from_arrays(u_V, y_um, TS_S)).to_json()))
    return {one["cause"]: one["met"] for one in said["requirements"]}


def test_excitation_decides_which_causes_can_show() -> None:
    t = TS_S * np.arange(20_000)
    sine = met(50 + 40 * np.sin(2 * np.pi * 20 * t))
    assert not sine["memory"]
    assert not sine["creep"]
    assert not sine["delay"]
    assert not sine["coupling"]
    rich = met(np.where(t < 1.2, 50 + 40 * np.exp(-t) * np.sin(2 * np.pi * 20 * t) * np.sin(2 * np.pi * 97 * t), 70.0))
    assert rich["memory"]
    assert rich["creep"]
    assert rich["delay"]


def test_inspect_prints_rate_ranges_noise_and_requirements_and_writes_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("r.csv").write_text(bundled_csv())
    assert main(["inspect", "r.csv", "--rows", "0s:0.2s", "--json", "i.json", "--plot", "i.png"]) == 0
    shown = capsys.readouterr().out
    for phrase in ("10000 samples at 50 kHz, 0.2 s", "noise: 0.000", "swings of", "memory", "well excited"):
        assert phrase in shown
    told = json.loads(Path("i.json").read_text())
    assert (told["schema"], told["version"], told["samples"]) == ("hysgen-inspect", 1, 10_000)
    assert Path("i.png").read_bytes().startswith(b"\x89PNG")
    # A record that hysgen writes is read without a remark.
    Path("again.csv").write_text(record_csv(Record.from_arrays(np.arange(300.0) % 70, np.arange(300.0) % 60, TS_S)))
    assert main(["inspect", "again.csv"]) == 0
    assert "read as" not in capsys.readouterr().err
