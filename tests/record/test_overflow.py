"""Counters that overflow are continued, buffers that were not filled are left out, and both are said; others stay."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from hysgen.errors import RecordError
from hysgen.record import Columns, Record, load_record

N = 1500
K = np.arange(N)
DRIVE_V = 50.0 + 50.0 * np.sin(2 * np.pi * K / 250)
MOVE_UM = 4.0 + 3.0 * np.sin(2 * np.pi * K / 250 - 0.3) + 0.5 * np.sin(2 * np.pi * K / 97)


def read(
    folder: Path,
    time: np.ndarray,
    y: np.ndarray = MOVE_UM,
    u: np.ndarray = DRIVE_V,
    names: tuple[str, str] = ("s", "um"),
) -> Record:
    """A CSV file of these columns, read without options."""
    file = folder / "log.csv"
    rows = [f"time_{names[0]},voltage_V,displacement_{names[1]}"]
    rows += [f"{t:.15g},{a:.5f},{b:.10g}" for t, a, b in zip(time, u, y, strict=True)]
    file.write_text("\n".join(rows) + "\n")
    return load_record(file)


@pytest.mark.parametrize(
    ("unit", "modulus", "one_s"),
    [("ms", 2.0**16, 1e-3), ("us", 2.0**32, 1e-6), ("us", 2.0**31, 1e-6), ("ns", 2.0**32, 1e-9), ("s", 86_400.0, 1.0)],
)
def test_a_clock_that_begins_again_is_continued_and_said(
    unit: str, modulus: float, one_s: float, tmp_path: Path
) -> None:
    step = 1e-3 / one_s
    record = read(tmp_path, (modulus - 700 * step + step * K) % modulus, names=(unit, "um"))
    assert (record.Ts_s, len(record.segments), record.segments[0].samples) == (pytest.approx(1e-3), 1, N)
    # Row 700 of the samples is line 702 of the file: the first whose time is past the overflow.
    said = [line for line in record.warnings if "the overflow of a counter" in line]
    assert len(said) == 1
    assert f"line 702: time_{unit} jumps by {modulus * one_s:.10g} s" in said[0]


@pytest.mark.parametrize("fall", [0.9, 123.4])
def test_a_time_that_falls_by_no_overflow_is_refused(fall: float, tmp_path: Path) -> None:
    with pytest.raises(RecordError, match="line 702: time_s falls from"):
        read(tmp_path, 1000.0 + 1e-3 * K - np.where(K < 700, 0.0, fall))


@pytest.mark.parametrize("bits", [10, 12, 16])
def test_a_counter_of_displacement_is_continued_whichever_way_it_goes(bits: int, tmp_path: Path) -> None:
    """Encoder counts of 1 nm whose zero lies inside the stroke: they overflow upwards and downwards."""
    counts = np.rint(2.0**bits * (MOVE_UM - 4.0) / 7.0)
    truth_um = 1e-3 * counts
    record = read(tmp_path, 1e-3 * K, counts % 2**bits, names=("s", "nm"))
    y_um = record.segments[0].y_um
    assert np.array_equal(np.rint(1e3 * (y_um - y_um[0])), np.rint(1e3 * (truth_um - truth_um[0])))
    crossings = np.count_nonzero(np.diff(counts // 2**bits))
    said = [line for line in record.warnings if "the overflow of a counter" in line]
    assert len(said) == 1
    assert f"{crossings - 1} more rows" in said[0]


def test_a_jump_of_the_stage_is_no_overflow(tmp_path: Path) -> None:
    """Jumps far smaller than the range, jumps that are no power of two, and whole counts without any."""
    for jump in (0.0, 1024.0, 9000.0):
        counts = np.rint(1e3 * MOVE_UM) + np.where(K < 700, 0.0, jump)
        record = read(tmp_path, 1e-3 * K, counts, names=("s", "nm"))
        assert not any("overflow" in line for line in record.warnings)
        assert np.allclose(record.segments[0].y_um, 1e-3 * counts)


def test_a_step_or_a_noise_that_fills_the_range_of_a_counter_is_no_overflow(tmp_path: Path) -> None:
    """Both span 2^10 counts to within a few; the step is no whole turn, and the noise moves as far in every row."""
    step = np.rint(400.0 * K / N) + np.where(K < 700, 0.0, 622.0)
    noise = np.random.default_rng(1).integers(0, 1024, N).astype(float)
    for counts in (step, noise):
        record = read(tmp_path, 1e-3 * K, counts, names=("s", "nm"))
        assert not any("overflow" in line for line in record.warnings)
        assert np.allclose(record.segments[0].y_um, 1e-3 * counts)


def zeroed(values: np.ndarray, first: int, last: int) -> np.ndarray:
    return np.where((first > K) | (N - last <= K), 0.0, values)


@pytest.mark.parametrize(
    ("first", "last", "time_goes_on"), [(0, 200, True), (0, 200, False), (40, 0, True), (3, 3, True), (0, 3, False)]
)
def test_rows_of_a_buffer_that_was_not_filled_are_left_out_and_said(
    first: int, last: int, time_goes_on: bool, tmp_path: Path
) -> None:
    time = 1e-3 * (K + 1)
    record = read(
        tmp_path,
        time if time_goes_on else zeroed(time, first, last),
        zeroed(MOVE_UM, first, last),
        zeroed(DRIVE_V, first, last),
    )
    inside = slice(first, N - last)
    assert np.allclose(record.segments[0].y_um, MOVE_UM[inside])
    assert np.allclose(record.segments[0].u_V, DRIVE_V[inside], atol=1e-5)
    for count, end in ((first, "first"), (last, "last")):
        assert any(f"the {end} {count} rows are zero in all columns" in w for w in record.warnings) is (count > 0)


def test_a_rest_at_zero_is_no_unfilled_buffer(tmp_path: Path) -> None:
    """A stage that comes to rest at 0 V and 0 um without a jump has measured these rows."""
    wave = np.where(K < 1250, 1.0 - np.cos(2 * np.pi * K / 250), 0.0)
    record = read(tmp_path, 1e-3 * K, 3.0 * wave, 50.0 * wave)
    assert record.segments[0].samples == N
    assert not any("left out" in line for line in record.warnings)


@pytest.mark.parametrize(
    ("written", "quantum"),
    [
        (lambda t: np.floor(t / 0.0625) * 0.0625, "0.0625"),
        (lambda t: np.rint(t / 0.01) * 0.01, "0.01"),
        (lambda t: np.array([float(f"{x:.5g}") for x in 99.5 + t]), "0.01"),
        (lambda t: (20000.0 + t).astype(np.float32).astype(float), "0.00195"),
    ],
    ids=["sixteenths", "hundredths", "five-digits", "float32"],
)
def test_stamps_written_too_coarsely_give_the_mean_rate_and_are_said(
    written: Callable[[np.ndarray], np.ndarray], quantum: str, tmp_path: Path
) -> None:
    record = read(tmp_path, written(1e-3 * K))
    assert (record.Ts_s, len(record.segments)) == (pytest.approx(1e-3, rel=2e-3), 1)
    assert any(f"is rounded to {quantum}" in line for line in record.warnings)


def test_a_row_lost_or_written_twice_and_a_clock_that_changes_its_rate_are_no_rounding(tmp_path: Path) -> None:
    for time in (1e-3 * (K + (K > 700)), 1e-3 * (K - (K > 700)), 1e-3 * (K + np.maximum(K - 1000, 0))):
        with pytest.raises(RecordError, match=r"jumps from|repeats"):
            read(tmp_path, time)


def test_a_repeated_stamp_says_how_many_and_the_option_with_its_number(tmp_path: Path) -> None:
    time = 1e-3 * K - 1e-3 * (K > 700) - 1e-3 * (K > 900)
    with pytest.raises(RecordError, match=r"one of 2 such rows.*--columns time=,Ts_s=0\.000998"):
        read(tmp_path, time)


def test_options_keep_their_meaning_beside_what_is_mended(tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    lines = [f"{t:.6f},{u:.5f},{y:.6f}" for t, u, y in zip(1e-3 * K, DRIVE_V, MOVE_UM, strict=True)]
    file.write_text("time_s,voltage_V,displacement_um\n" + "\n".join([*lines, *["0,0,0"] * 50]) + "\n")
    record = load_record(file, Columns(shift=3))
    assert record.segments[0].samples == N - 3
