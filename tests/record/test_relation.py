"""Records that are no stage, and columns that are no channel, are found and said in one line."""

import warnings
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter

import hysgen
from hysgen.errors import RecordError
from hysgen.record import Columns, Record, load_record, record_csv
from hysgen_lab.stage import Stage, run
from hysgen_lab.stage.signals import nested_amplitudes

TS_S = 1e-4
RNG = np.random.default_rng(5)
U_V = nested_amplitudes(TS_S, (50.0, 20.0), 40.0, 25.0, 2)
Y_UM = run(Stage.nominal(), U_V, TS_S, seed=7).displacement_um
N = U_V.size


@pytest.mark.parametrize(
    ("u_V", "y_um", "Ts_s", "said"),
    [
        (U_V, RNG.normal(size=N), TS_S, "displacement_um does not follow voltage_V: largest correlation 0.0"),
        (U_V[90:], Y_UM[:-90], TS_S, "runs 102 samples (0.0102 s) behind voltage_V"),
        (U_V, -Y_UM, TS_S, "falls as voltage_V rises slowly (correlation -"),
        (U_V, 1e3 * Y_UM, TS_S, "more than a piezo stage moves; if it is in nm, give --columns displacement_unit=nm"),
        (U_V, 1e-6 * Y_UM, TS_S, "less than the noise of a sensor"),
        (U_V, Y_UM, 0.02, "is sampled at 50 Hz; if the time is in ms, give --columns time_unit=ms"),
    ],
    ids=["no sensor", "logs apart", "inverted", "nm as um", "m as um", "ms as s"],
)
def test_a_record_that_is_no_stage_is_said_in_one_line(
    u_V: np.ndarray, y_um: np.ndarray, Ts_s: float, said: str
) -> None:
    (line,) = Record.from_arrays(u_V, y_um, Ts_s).warnings
    assert said in line
    assert Record.from_arrays(U_V, Y_UM, TS_S).warnings == ()


def test_a_rate_given_as_a_period_is_refused() -> None:
    with pytest.raises(
        RecordError, match=r"Ts_s = 50000 s; give the sampling period in s, 2e-05 for a rate of 50000 Hz"
    ):
        Record.from_arrays(U_V, Y_UM, 50_000)


def written(path: Path, **columns: np.ndarray) -> Path:
    lines = record_csv(Record.from_arrays(U_V, Y_UM, TS_S)).splitlines()
    for name, values in columns.items():
        lines = [f"{line},{name if k == 0 else values[k - 1]:}" for k, line in enumerate(lines)]
    path.write_text("\n".join(lines) + "\n")
    return path


SECOND_READINGS = {
    "raw": 1.02 * Y_UM + 0.1 + 0.005 * RNG.normal(size=N),
    "unfiltered": np.roll(Y_UM, -1),
    "filtered": np.convolve(Y_UM, np.ones(5) / 5, mode="full")[:N],
    "set_point": np.roll(Y_UM, -3) + 0.01,
    "position_error": np.roll(Y_UM, -3) - Y_UM,
    "monitor": U_V / 10 + 0.01 * RNG.normal(size=N),
    "late": np.concatenate([np.full(700, Y_UM[0]), Y_UM[:-700]]),
    "slow": lfilter([0.01], [1.0, -0.99], Y_UM - Y_UM[0]),
}


@pytest.mark.parametrize("name", SECOND_READINGS)
def test_a_second_reading_is_no_channel_unless_it_is_named(name: str, tmp_path: Path) -> None:
    path = written(tmp_path / "r.csv", **{name: SECOND_READINGS[name]})
    record = load_record(path)
    assert record.aux_names == ()
    assert any(f"column {name} is left out" in line and f"--columns aux={name}" in line for line in record.warnings)
    assert load_record(path, Columns(aux=(name,))).aux_names == (name,)


def test_clocks_and_counters_are_no_channels_and_another_quantity_is(tmp_path: Path) -> None:
    k = np.arange(N)
    other_axis = np.interp(k, np.arange(0, N + 100, 100), RNG.normal(size=N // 100 + 2)[: len(range(0, N + 100, 100))])
    warming = 20.0 + 1.0 - np.exp(-3.0 * k / N) + 0.02 * RNG.normal(size=N)
    others = {"axis2_um": other_axis, "temperature": warming, "slow_sine": np.sin(2.0 * np.pi * k / N)}
    path = written(tmp_path / "r.csv", count=k, byte=k % 256, clock_ms=1e3 * TS_S * k, **others)
    record = load_record(path)
    assert set(record.aux_names) == set(others)
    assert sum("a clock or a sample counter" in line for line in record.warnings) == 3
    # With a given period, the time column is no channel either.
    timed = load_record(written(tmp_path / "t.csv"), Columns(time="", Ts_s=TS_S))
    assert timed.aux_names == ()


def test_the_same_file_twice_is_said(tmp_path: Path) -> None:
    path = written(tmp_path / "r.csv")
    record = load_record([path, path])
    assert any("holds the same samples as r.csv" in line for line in record.warnings)


def test_the_interface_warns_of_poor_excitation_before_a_fit() -> None:
    k = np.arange(3000)
    alike = Record.from_arrays(50 + 30 * np.sin(0.01 * k), 4 + 2 * np.sin(0.01 * k - 0.1), TS_S)
    with pytest.warns(hysgen.RecordWarning, match="swings of the voltage are alike"):
        hysgen.fit(alike, hysgen.FitSettings(method="batch", rules=3))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        hysgen.fit(Record.from_arrays(U_V, Y_UM, TS_S), hysgen.FitSettings(method="batch", rules=3))


def test_a_model_that_explains_nothing_or_leaves_its_range_is_said_first() -> None:
    known = Record.from_arrays(U_V, Y_UM, TS_S)
    model = hysgen.fit(known.rows(0, N // 2), hysgen.FitSettings(method="batch"))
    beyond = Record.from_arrays(1.3 * U_V, 1.3 * Y_UM, TS_S)
    lines = str(hysgen.score(model, beyond)).splitlines()
    assert "warning:" in lines[1]
    leaving = [line for line in lines if "leaves the identified" in line]
    assert ["the model is clamped there" in line for line in leaving] == [True, False], "its grid is wider than y was"
    noise = Record.from_arrays(U_V, 4 + 0.5 * RNG.normal(size=N), TS_S)
    assert "explains next to nothing" in str(hysgen.score(hysgen.fit(noise), noise)).splitlines()[1]


@pytest.mark.parametrize(
    ("kind", "sign"),
    [(kind, sign) for kind in ("sweep through a mode", "steps", "slow sine") for sign in (1.0, -1.0)]
    + [("across a mode", 1.0)],
)
def test_an_inverted_sensor_is_judged_by_the_slow_response(kind: str, sign: float) -> None:
    """A mode at 40 Hz of 1 kHz: most of a sweep to 400 Hz lies above it, where a sound displacement falls."""
    t = np.arange(8000) * 1e-3
    u_V = (
        50.0
        + 40.0
        * {
            "sweep through a mode": np.sin(2.0 * np.pi * (1.0 + 25.0 * t) * t),
            "across a mode": np.sin(2.0 * np.pi * (20.0 + 2.5 * t) * t),
            "steps": np.sign(np.sin(2.0 * np.pi * 0.7 * t)),
            "slow sine": np.sin(2.0 * np.pi * 2.0 * t),
        }[kind]
    )
    w, damping = 2.0 * np.pi * 0.04, 0.03
    a1, a2 = 2.0 * np.exp(-damping * w) * np.cos(w), -np.exp(-2.0 * damping * w)
    y_um = np.full(t.size, 0.07 * u_V[0])
    for k in range(2, t.size):
        y_um[k] = a1 * y_um[k - 1] + a2 * y_um[k - 2] + (1.0 - a1 - a2) * 0.07 * u_V[k - 1]
    y_um = sign * y_um + 1e-3 * np.random.default_rng(5).normal(size=t.size)
    inverted = [line for line in Record.from_arrays(u_V, y_um, 1e-3).warnings if "an inverted sensor?" in line]
    assert bool(inverted) == (sign < 0.0)


def test_a_second_displacement_and_a_further_channel_are_hinted_at(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text(
        "\n".join(["time_s,voltage_V,sensor A [um],sensor B [um]", *(f"{k},{k % 7},{k % 5},{k % 3}" for k in range(9))])
    )
    with pytest.raises(RecordError, match=r"another may be a further channel: aux=sensor B \[um\]"):
        load_record(path)
    with pytest.raises(RecordError, match="give each further channel its own aux=NAME, as aux=a,aux=b"):
        load_record(path, Columns(displacement="sensor A [um]", aux=("sensor B;C",)))


@pytest.mark.parametrize("seed", range(8))
def test_noise_is_no_inverted_sensor(seed: int) -> None:
    y_um = np.random.default_rng(seed).normal(size=N)
    (line,) = Record.from_arrays(U_V, y_um, TS_S).warnings
    assert "does not follow" in line


def test_where_only_the_other_axis_follows_the_voltage_it_is_read_unless_one_is_named(tmp_path: Path) -> None:
    path, rows = tmp_path / "xy.csv", np.column_stack([TS_S * np.arange(N), U_V, 0.1 * U_V, RNG.normal(size=N)])
    for names in ("x_um,y_um", "x,y", "sensor [um],position [um]"):
        np.savetxt(path, rows, delimiter=",", header=f"time_s,voltage_V,{names}", comments="")
        x, y = names.split(",")
        found = load_record(path)
        assert np.array_equal(found.y_um, rows[:, 2])
        assert f"xy.csv: {y} does not follow voltage_V, {x} does: read as displacement={x}" in found.warnings
        asked = load_record(path, f"displacement={y}")
        assert np.array_equal(asked.y_um, rows[:, 3])
        (line,) = (one for one in asked.warnings if "does not follow" in one)
        assert line.endswith(f"; {x} follows it: --columns displacement={x}")


ROWS, STEP_S, RATE = 4000, 1e-3, 0.2
STEPS_V = np.repeat(np.random.default_rng(3).uniform(0.0, 100.0, 40), ROWS // 40)
SMOOTH_V = 50.0 - 40.0 * np.cos(2.0 * np.pi * np.arange(ROWS) / 400.0)


def answer(u_V: np.ndarray, early: int, noise_um: float = 1e-3) -> np.ndarray:
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
def test_an_answer_in_the_row_of_the_step_is_said(u_V: np.ndarray, early: int, noise_um: float, said: bool) -> None:
    record = Record.from_arrays(u_V, answer(u_V, early, noise_um), STEP_S)
    lines = [line for line in record.warnings if "in their own rows" in line]
    assert len(lines) == said
    assert all("--columns shift=1" in line for line in lines)


def test_shift_pairs_each_voltage_with_the_row_that_answers_it(tmp_path: Path) -> None:
    path, y_um, channel = tmp_path / "early.csv", answer(STEPS_V, 1), np.arange(float(ROWS)) ** 2
    rows = zip(STEP_S * np.arange(ROWS), STEPS_V, y_um, channel, strict=True)
    path.write_text("time_s,voltage_V,displacement_um,axis2\n" + "".join(f"{t},{u},{y},{c}\n" for t, u, y, c in rows))
    assert any("--columns shift=1" in line for line in load_record(path).warnings)
    later = load_record(path, "shift=1,aux=axis2")
    np.testing.assert_array_equal(later.u_V, STEPS_V[1:])
    np.testing.assert_array_equal(later.y_um, y_um[:-1])
    np.testing.assert_array_equal(later.segments[0].aux["axis2"], channel[1:])
    assert later.segments[0].start_s == STEP_S
    assert not any("shift" in line for line in later.warnings)
    earlier = load_record(path, {"shift": -2})
    np.testing.assert_array_equal(earlier.u_V, STEPS_V[:-2])
    np.testing.assert_array_equal(earlier.y_um, y_um[2:])


@pytest.mark.parametrize("gains", [(3.0, 0.3), (0.0, 1.5)], ids=["PI", "integral"])
@pytest.mark.parametrize("noise_um", [1e-4, 1e-2])
def test_a_voltage_that_reacts_to_the_displacement_is_said(gains: tuple[float, float], noise_um: float) -> None:
    """A controller of the lag above; the voltage that it put out, played again, reacts to nothing."""
    rng, (kp, ki), wanted_um = np.random.default_rng(6), gains, 0.1 * SMOOTH_V
    u_V, y_um, stage, sum_um = np.zeros(ROWS), np.zeros(ROWS), 1.0, 1.0
    for k in range(ROWS):
        y_um[k] = stage + noise_um * rng.standard_normal()
        sum_um += ki * (wanted_um[k] - y_um[k])
        u_V[k] = kp * (wanted_um[k] - y_um[k]) + sum_um
        stage += RATE * (0.1 * u_V[k] - stage)
    said = [any("reacts" in line for line in Record.from_arrays(u_V, y, 1e-3).warnings) for y in (y_um, answer(u_V, 0))]
    assert said == [True, False]
