"""A format is one file: written into a copy of the tree, its files are recognised, read, and read when packed."""

import gzip
import os
import shutil
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from openpyxl import Workbook

from hysgen.record import load_record

ROOT = Path(__file__).resolve().parents[2]
FILE = "generator/hysgen/record/formats/waves.py"
ADDED = '''
"""WAVES: a count, then so many float32 of voltage and of displacement in nm, at 1 kHz."""

import numpy as np

from hysgen.record.formats.base import FileArrays, Format


def read_waves(path):
    values = np.frombuffer(path.read_bytes()[5:], dtype="<f4").reshape(2, -1)
    return FileArrays({"drive": values[0], "sensor": values[1]}, {"drive": "V", "sensor": "nm"}, 1e-3)


FORMAT = Format("waves", lambda path, head: head.startswith(b"WAVES"), read_waves)
'''
PROGRAM = (
    "import sys; from hysgen.record import load_record; r = load_record(sys.argv[1]); print(r.Ts_s, *r.y_range_um)"
)


@pytest.mark.parametrize("packed", [False, True])
def test_a_new_format_requires_one_file(packed: bool, tmp_path: Path) -> None:
    shutil.copytree(ROOT / "generator" / "hysgen", tmp_path / "generator" / "hysgen")
    assert not (tmp_path / FILE).exists()
    (tmp_path / FILE).write_text(ADDED)
    drive_V = 50.0 - 50.0 * np.cos(0.1 * np.arange(300))
    data = b"WAVES" + struct.pack("<600f", *drive_V, *(70.0 * np.concatenate([[0.0], drive_V[:-1]])))
    path = tmp_path / "log.bin"
    path.write_bytes(gzip.compress(data) if packed else data)
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, str(path)],
        env={**os.environ, "PYTHONPATH": str(tmp_path / "generator")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    period_s, low_um, high_um = map(float, done.stdout.split())
    assert (period_s, low_um) == (1e-3, 0.0)
    assert high_um == pytest.approx(7.0, rel=1e-3)


def test_the_sheet_that_holds_the_table_is_read_and_said(tmp_path: Path) -> None:
    book = Workbook()
    parameters = book.active
    assert parameters is not None
    parameters.title = "Setup"
    for row in (("Parameter", "Value"), ("gain", 10.0), ("range", 100.0), ("rate", 1000.0), ("channels", 2)):
        parameters.append(row)
    data = book.create_sheet("Log")
    data.append(["Time (s)", "Voltage (V)", "Position (um)"])
    for k in range(300):
        data.append([1e-3 * k, 50.0 - 50.0 * np.cos(0.1 * k), 3.5 - 3.5 * np.cos(0.1 * (k - 1))])
    book.save(tmp_path / "log.xlsx")
    record = load_record(tmp_path / "log.xlsx")
    assert record.samples == 300
    assert "log.xlsx: sheet 'Log' is read, not 'Setup'" in record.warnings
