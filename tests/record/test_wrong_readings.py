"""Single wrong readings are found in every row, said with row and value, and decide nothing; motions stay."""

import warnings
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import hysgen
from hysgen.cli.main import main
from hysgen.diagnosis.causes.outliers import OutliersCause
from hysgen.display import Quantities
from hysgen.record import Record, Segment
from hysgen.record.read import demo_record, record_csv
from hysgen.record.wrong_readings import wrong_readings

N, CUT = 1500, 1000
K = np.arange(N)
U_V = np.round(50.0 * (1.0 - np.cos(0.046 * K)) * (0.4 + 0.6 * np.cos(0.0021 * K) ** 2), 4)
STROKE_UM = 7.0


def stage(u_V: np.ndarray, seed: int = 7) -> np.ndarray:
    """(n,) displacement of two plays behind a lag of three samples, with 0.5 nm of noise."""
    plays, y = np.zeros(2), np.zeros(u_V.size)
    for k in range(1, u_V.size):
        plays = np.clip(plays, u_V[k - 1] - (8.0, 25.0), u_V[k - 1] + (8.0, 25.0))
        y[k] = y[k - 1] + 0.28 * (0.05 * u_V[k - 1] + 0.012 * plays.sum() - y[k - 1])
    return y + 5e-4 * np.random.default_rng(seed).normal(size=u_V.size)


Y_UM = stage(U_V)


def wrong_at(row: int, value_um: float, rows: int = N) -> Record:
    y_um = Y_UM[:rows].copy()
    y_um[row] = value_um
    return Record.from_arrays(U_V[:rows], y_um, 1e-3, source="log.csv")


@pytest.mark.parametrize("strokes", [-1.0, 2.0, 5.0])
@pytest.mark.parametrize("row", [0, 1, 2, 333, 600, N - 3, N - 2, N - 1])
def test_a_wrong_reading_is_found_in_any_row_and_bridged(row: int, strokes: float) -> None:
    record = wrong_at(row, strokes * STROKE_UM)
    sound = record.without_wrong_readings()
    (line,) = sound.warnings[len(record.warnings) :]
    assert line.startswith(f"log.csv: row {row}: the displacement is {strokes * STROKE_UM:g} um, ")
    np.testing.assert_allclose(sound.y_um, Y_UM, atol=0.12)
    assert np.flatnonzero(sound.y_um != record.y_um).tolist() == [row]


def test_a_dropout_inside_the_range_and_two_side_by_side_are_found() -> None:
    y_um = Y_UM.copy()
    y_um[[411, 902, 903]] = 0.0
    assert [one.row for one in wrong_readings(Segment("0", U_V, y_um))] == [411, 902, 903]


@pytest.mark.parametrize("size_V", [-60.0, -30.0, 40.0, 5000.0])
@pytest.mark.parametrize("rows", [(2,), (600,), (601, 602), (N - 3,)])
def test_a_wrong_voltage_that_the_stage_does_not_answer_is_bridged_and_one_that_it_answers_stays(
    rows: tuple[int, ...], size_V: float
) -> None:
    u_V = U_V + size_V * np.isin(K, rows)
    sound = Record.from_arrays(u_V, Y_UM, 1e-3, source="log.csv").without_wrong_readings()
    assert f"log.csv: row {rows[0]}: the voltage is {u_V[rows[0]]:.6g} V, " in " ".join(sound.warnings)
    np.testing.assert_allclose(sound.segments[0].u_V, U_V, atol=0.3)
    np.testing.assert_array_equal(sound.y_um, Y_UM)
    assert wrong_readings(Segment("0", u_V, stage(u_V))) == []


MOTIONS = {
    "steps": np.repeat(np.random.default_rng(1).uniform(0.0, 100.0, 20), 75),
    "a pulse": 100.0 * (K == 700),
    "a random binary input": 100.0 * np.random.default_rng(2).integers(0, 2, N),
    "a coarse triangle": 12.5 * np.abs(K % 16 - 8),
    "a burst": np.where((K > 500) & (K < 510), 100.0, 0.0),
}


@pytest.mark.parametrize("delay", [0, 10, 40])
@pytest.mark.parametrize("noise_um", [0.0, 1e-4, 1e-2])
@pytest.mark.parametrize("kind", MOTIONS)
def test_what_a_voltage_does_is_no_wrong_reading(kind: str, noise_um: float, delay: int) -> None:
    y_um = 0.07 * np.concatenate([np.full(delay + 1, MOTIONS[kind][0]), MOTIONS[kind]])[:N]
    y_um = y_um + noise_um * np.random.default_rng(3).normal(size=N)
    assert wrong_readings(Segment("0", MOTIONS[kind].astype(float), y_um)) == []


@pytest.mark.parametrize("lag", [0.3, 3.0])
@pytest.mark.parametrize("noise_um", [0.0, 1e-4])
def test_a_step_behind_a_lag_is_no_wrong_reading(lag: float, noise_um: float) -> None:
    u_V, y_um = np.repeat(np.random.default_rng(0).uniform(0.0, 100.0, 8), 200), np.zeros(1600)
    y_um[0] = 0.07 * u_V[0]
    for k in range(1, 1600):
        y_um[k] = y_um[k - 1] + (1.0 - np.exp(-1.0 / lag)) * (0.07 * u_V[k - 1] - y_um[k - 1])
    y_um += noise_um * np.random.default_rng(3).normal(size=1600)
    assert wrong_readings(Segment("0", u_V, y_um)) == []


def test_a_step_from_rest_on_a_coarse_sensor_is_no_wrong_reading() -> None:
    u_V = np.where(K > 700, 80.0, 0.0)
    y_um = 0.07 * 80.0 * -np.expm1(-np.maximum(K - 701, 0) / 3.0)
    assert wrong_readings(Segment("0", u_V, np.rint(y_um / 0.05) * 0.05)) == []


@pytest.mark.parametrize("size_um", [0.3, 0.5, 1.0, 2.0, 4.0])
def test_a_jump_is_no_wrong_reading(size_um: float) -> None:
    smooth_um = 3.5 - 3.5 * np.cos(0.046 * K)
    for y_um in (smooth_um, Y_UM):
        assert wrong_readings(Segment("0", U_V, y_um + size_um * (K > 700))) == []


def test_coarse_readings_switching_many_rows_and_the_bundled_record_have_no_wrong_readings() -> None:
    """Many rows that stand alone are the character of a signal."""
    for y_um in (np.rint(Y_UM / 0.4) * 0.4, Y_UM + 1.0 * (K // 37 % 2), Y_UM + 2.0 * (K % 60 == 7)):
        assert wrong_readings(Segment("0", U_V, y_um)) == []
    assert (record := demo_record()).without_wrong_readings() is record


def test_rows_of_later_segments_and_of_parts_count_from_the_start_of_the_record() -> None:
    y_um = Y_UM.copy()
    y_um[[200, 900]] = 20.0
    first, second = Record.from_arrays(U_V, y_um, 1e-3, source="log.csv").split_at(700)
    both = Record.from_segments([*first.segments, *second.segments], 1e-3, "log.csv")
    for record, rows in ((both, (200, 900)), (second, (900,)), (second.rows(100, 500), (900,))):
        said = record.without_wrong_readings().warnings
        assert [line.split(": the")[0] for line in said] == [f"log.csv: row {row}" for row in rows]
    other = [replace(segment, quantities=Quantities("current", "A", "angle", "mrad")) for segment in first.segments]
    assert "the angle is 20 mrad" in Record.from_segments(other, 1e-3).without_wrong_readings().warnings[0]


@pytest.mark.parametrize(
    ("rows", "samples", "gate"),
    [((100, 101, 102), 1000, False), ((100, 900), 1000, True), ((199, 201), 1000, False), ((100, 9000), 10_000, False)],
)
def test_the_cause_outliers_gates_the_firmware_above_one_in_a_thousand_and_in_tenths_that_do_not_touch(
    rows: tuple[int, ...], samples: int, gate: bool
) -> None:
    corrupted = np.isin(np.arange(samples), rows)
    extension = OutliersCause().extension(SimpleNamespace(corrupted=corrupted))  # type: ignore[arg-type]
    assert extension.gate is gate
    assert extension.trust is not None
    np.testing.assert_array_equal(extension.trust, ~corrupted)


@pytest.fixture(scope="module")
def clean_rms_um() -> dict[bool, float]:
    known, unseen = Record.from_arrays(U_V, Y_UM, 1e-3).split_at(CUT)
    return {m: hysgen.score(hysgen.fit(known, memory=m), unseen).free_run.e_rms_um for m in (False, True)}


@pytest.mark.parametrize("memory", [False, True])
@pytest.mark.parametrize(("row", "strokes"), [(0, -1.0), (0, 5.0), (600, 0.0), (600, 2.0), (CUT - 1, 5.0)])
def test_a_wrong_reading_does_not_decide_the_model(
    row: int, strokes: float, memory: bool, clean_rms_um: dict[bool, float]
) -> None:
    known = wrong_at(row, strokes * STROKE_UM).rows(0, CUT)
    unseen = Record.from_arrays(U_V, Y_UM, 1e-3).rows(CUT, N)
    with pytest.warns(hysgen.RecordWarning, match=rf"log\.csv: row {row}: the displacement is"):
        model = hysgen.fit(known, memory=memory)
    assert model.grid.y_max_um == pytest.approx(Y_UM[:CUT].max(), rel=0.02)
    assert hysgen.score(model, unseen).free_run.e_rms_um < 1.05 * clean_rms_um[memory]


def test_a_wrong_reading_in_the_scored_rows_or_their_past_changes_no_score(clean_rms_um: dict[bool, float]) -> None:
    model = hysgen.fit(Record.from_arrays(U_V, Y_UM, 1e-3).rows(0, CUT), memory=True)
    for row in (CUT - 1, CUT, 1200):
        part = wrong_at(row, 20.0).rows(CUT, N)
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            rms_um = hysgen.score(model, part).free_run.e_rms_um
        assert rms_um < 1.02 * clean_rms_um[True]
        assert any(f"row {row}: " in str(one.message) for one in said) == (row >= CUT)


def test_a_diagnosis_leaves_rare_ones_out_and_keeps_frequent_ones() -> None:
    rare, frequent = wrong_at(600, 20.0), wrong_at(600, 20.0)
    y_um = frequent.y_um.copy()
    y_um[1200] = 0.0
    frequent = Record.from_arrays(U_V, y_um, 1e-3)
    assert rare.without_wrong_readings(gated=True).y_range_um[1] < 8.0
    assert frequent.without_wrong_readings(gated=True) is frequent
    assert frequent.without_wrong_readings().y_range_um[1] < 8.0


def test_a_verb_says_row_and_value_and_shows_the_range_without_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "log.csv"
    path.write_text(record_csv(wrong_at(600, 12_345.6)))
    assert main(["inspect", str(path)]) == 0
    shown = capsys.readouterr()
    assert "log.csv: row 600: the displacement is 12345.6 um" in shown.err
    assert "displacement_unit" not in shown.err
    assert "12345" not in shown.out
