"""A record that was cut by hand into two files: the held-out file does not know its past, and is not scored on it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hysgen.diagnosis.prepare import prepare
from hysgen.diagnosis.procedure import DiagnoseSettings, diagnose
from hysgen.record import Record, load_record
from hysgen.record.bundled import bundled_csv


def alone(record: Record, start: int, stop: int) -> Record:
    """The rows as a file of its own has them: without what was before."""
    return Record.from_arrays(record.u_V[start:stop], record.y_um[start:stop], record.Ts_s)


def test_rows_of_a_held_out_file_that_its_unknown_past_spoils_are_not_scored() -> None:
    """The input comes to a large extreme after three fifths of the held-out file; before it, the plays are unknown."""
    k = np.arange(6000)
    u_V = 30.0 + np.where(k < 5000, 25.0, 5.0) * np.sin(0.01 * k)
    u_V[5600:5800] = 30.0 + 20.0 * np.sin(np.pi * (k[5600:5800] - 5600) / 100.0)
    y_um = 0.1 * u_V + 1e-3 * np.random.default_rng(1).normal(size=k.size)
    record = Record.from_arrays(u_V, y_um, 1e-4)
    known, unseen = alone(record, 0, 5000), alone(record, 5000, 6000)
    held = prepare(known, unseen).held_rows
    assert held.min() >= 5650
    # With its past, every row is scored.
    assert prepare(*record.split_at(5000)).held_rows.min() == 5000


@pytest.mark.proof
def test_memory_is_extended_on_a_record_that_was_cut_by_hand(tmp_path: Path) -> None:
    """Rows of the bundled record cut at 65 %, the rest a file of its own: with its first, memory seemed to do harm."""
    (tmp_path / "record.csv").write_text(bundled_csv())
    record = load_record(tmp_path / "record.csv")
    last = 24_000
    cut = round(0.65 * last)
    found = diagnose(alone(record, 0, cut), alone(record, cut, last), DiagnoseSettings())
    assert "memory" in {cause.name for cause in found.causes if cause.extended}
    assert found.extended_rms_um < 0.2 * found.base_rms_um
