"""Measured records are read as documented, and a million rows within seconds."""

import time
from pathlib import Path

import numpy as np
import pytest

from hysgen.record import Columns, Record, load_record

FSM = "voltage=u_{0}mV_train[:,{1},:,:],displacement=y_{0}mV_train[:,{1},:,:]"


def test_benchmark_in_newton_and_metres_is_read_by_option_with_its_exact_rate(measured: Path) -> None:
    columns = Columns.from_text("voltage=force_N,displacement=displacement_m,displacement_unit=m")
    record = load_record(measured / "boucwen" / "train.csv", columns)
    assert (record.samples, record.Ts_s) == (40960, 1 / 750)
    (line,) = record.warnings
    assert line == "train.csv: force_N is read in V; if 'N' is its unit, say what one is: voltage_unit=10V"
    assert record.y_range_um == pytest.approx((-2654.42039, 2258.44557), rel=1e-12)


@pytest.mark.parametrize("level_mV", [100, 300])
@pytest.mark.parametrize("drive", [0, 1, 2])
def test_mirror_realisations_and_periods_are_twelve_segments(measured: Path, level_mV: int, drive: int) -> None:
    path = measured / "fsm" / "fsm_train.npz"
    record = load_record(path, Columns.from_text(FSM.format(level_mV, drive)))
    assert (len(record.segments), record.samples, record.Ts_s) == (12, 12 * 8192, 1 / 6400)
    # Two of the axes answer their own drive with the other sign: -2.7, -3.3 and 1.6 at 2 to 40 Hz.
    assert ["an inverted sensor?" in line for line in record.warnings] == [True] * (drive != 2)
    with np.load(path) as arrays:
        np.testing.assert_array_equal(record.segments[7].y_um, arrays[f"y_{level_mV}mV_train"][:, drive, 3, 1])


@pytest.mark.slow
def test_a_million_rows_are_read_in_seconds(tmp_path: Path) -> None:
    rows = 1_000_000
    k = np.arange(rows)
    y_um = 4 + 3 * np.sin(2 * np.pi * (k - 5) / 500) + 5e-4 * np.random.default_rng(1).normal(size=rows)
    u_V = 50 + 40 * np.sin(2 * np.pi * k / 500)
    lines = (
        f"{t:.5f},{u:.5f},{y:.4f}" for t, u, y in zip((k * 2e-5).tolist(), u_V.tolist(), y_um.tolist(), strict=True)
    )
    path = tmp_path / "long.csv"
    path.write_text("\n".join(["time_s,voltage_V,displacement_um", *lines, ""]))
    begun = time.process_time()
    record: Record = load_record(path)
    # Processor time of this process: 1.4 s on the 2-core machine it was written on; twice that for a slower one.
    assert time.process_time() - begun < 3.0
    assert (record.samples, record.Ts_s) == (rows, 2e-5)
