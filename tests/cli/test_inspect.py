"""inspect says what a file holds, and which causes its excitation can show."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from hysgen.cli import main
from hysgen.record import Record, record_csv
from hysgen.record.bundled import bundled_csv

TS_S = 1e-4


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
