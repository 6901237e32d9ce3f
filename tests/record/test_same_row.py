"""A displacement written in the row of the voltage that it answers: said with the option that mends it, and mended."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from hysgen.errors import RecordError
from hysgen.record import Record, load_record

Floats = NDArray[np.float64]

ROWS, TS_S, RATE = 4000, 1e-3, 0.2
STEPS_V = np.repeat(np.random.default_rng(3).uniform(0.0, 100.0, 40), ROWS // 40)
SMOOTH_V = 50.0 - 40.0 * np.cos(2.0 * np.pi * np.arange(ROWS) / 400.0)


def answer(u_V: Floats, early: int, noise_um: float = 1e-3) -> Floats:
    """A lag of 10 um / 100 V: y(k+1) - y(k) = RATE (0.1 u(k) - y(k)), written `early` rows early."""
    y_um = np.zeros(len(u_V) + 1)
    for k, u in enumerate(u_V):
        y_um[k + 1] = y_um[k] + RATE * (0.1 * u - y_um[k])
    written = y_um[early : early + len(u_V)]
    return np.asarray(written + noise_um * np.random.default_rng(4).standard_normal(len(written)))


@pytest.mark.parametrize(
    ("u_V", "early", "noise_um", "said"),
    [
        (STEPS_V, 1, 1e-3, True),
        (100.0 - STEPS_V, 1, 0.05, True),
        (STEPS_V, 0, 1e-3, False),
        (STEPS_V, 0, 1.0, False),
        (SMOOTH_V, 1, 1e-3, False),
    ],
    ids=["early", "early, noisy", "in time", "in time, noisy", "no steps"],
)
def test_an_answer_in_the_row_of_the_step_is_said(u_V: Floats, early: int, noise_um: float, said: bool) -> None:
    record = Record.from_arrays(u_V, answer(u_V, early, noise_um), TS_S)
    lines = [line for line in record.warnings if "in their own rows" in line]
    assert len(lines) == said
    assert all("--columns shift=1" in line for line in lines)


def test_shift_pairs_each_voltage_with_the_row_that_answers_it(tmp_path: Path) -> None:
    path, y_um, channel = tmp_path / "early.csv", answer(STEPS_V, 1), np.arange(float(ROWS)) ** 2
    rows = zip(TS_S * np.arange(ROWS), STEPS_V, y_um, channel, strict=True)
    path.write_text("time_s,voltage_V,displacement_um,axis2\n" + "".join(f"{t},{u},{y},{c}\n" for t, u, y, c in rows))
    assert any("--columns shift=1" in line for line in load_record(path).warnings)
    later = load_record(path, "shift=1,aux=axis2")
    np.testing.assert_array_equal(later.u_V, STEPS_V[1:])
    np.testing.assert_array_equal(later.y_um, y_um[:-1])
    np.testing.assert_array_equal(later.segments[0].aux["axis2"], channel[1:])
    assert later.segments[0].start_s == TS_S
    assert not any("shift" in line for line in later.warnings)
    earlier = load_record(path, {"shift": -2})
    np.testing.assert_array_equal(earlier.u_V, STEPS_V[:-2])
    np.testing.assert_array_equal(earlier.y_um, y_um[2:])


@pytest.mark.parametrize(
    ("shift", "message"), [("1.5", "no whole number"), ("4000", "leaves no row"), ("-5000", "leaves no row")]
)
def test_a_shift_that_is_none_is_refused(tmp_path: Path, shift: str, message: str) -> None:
    path = tmp_path / "early.csv"
    rows = zip(TS_S * np.arange(ROWS), STEPS_V, answer(STEPS_V, 0), strict=True)
    path.write_text("time_s,voltage_V,displacement_um\n" + "".join(f"{t},{u},{y}\n" for t, u, y in rows))
    with pytest.raises(RecordError, match=message):
        load_record(path, f"shift={shift}")
