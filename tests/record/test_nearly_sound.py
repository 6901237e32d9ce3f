"""Files that are nearly sound: read right without options, or refused with row or field, fault and remedy."""

import json
import re
from pathlib import Path

import h5py
import numpy as np
import pytest

from hysgen.errors import RecordError
from hysgen.record import Record, load_record

N = 400
TIME_S = np.round(np.arange(N) * 1e-3, 3)
U_V = np.round(50.0 - 50.0 * np.cos(0.05 * np.arange(N)), 4)
Y_UM = np.round(3.5 - 3.5 * np.cos(0.05 * (np.arange(N) - 3)) + 1e-3 * np.random.default_rng(3).normal(size=N), 5)


def text(head: str, separator: str, *columns: np.ndarray) -> str:
    return "\n".join([head, *(separator.join(f"{value:.9g}" for value in row) for row in zip(*columns, strict=True))])


def read(folder: Path, content: str, columns: str = "", name: str = "log.txt") -> Record:
    path = folder / name
    path.write_text(content, encoding="utf-8")
    return load_record(path, columns)


OTHER_UNITS = re.findall(
    r"\S+",
    "inch in count counts cnt cts raw adc lsb lsb16 urad mrad mdeg px pix steps ticks dig norm a.u. au fringes deg "
    "percent Hz mils uin rev ppm Counts %",
)


@pytest.mark.parametrize("unit", OTHER_UNITS)
def test_a_unit_of_another_quantity_behind_a_name_is_refused_as_in_brackets(unit: str, tmp_path: Path) -> None:
    content = text(f"time_s,voltage_V,position_{unit}", ",", TIME_S, U_V, Y_UM)
    with pytest.raises(RecordError, match=rf"'position_{unit}' is in {unit}, which is no unit of a displacement; if"):
        read(tmp_path, content)
    as_um = read(tmp_path, content, f"displacement=position_{unit},displacement_unit=10um")
    np.testing.assert_allclose(as_um.y_um, 10.0 * Y_UM)


@pytest.mark.parametrize("unit", ["counts", "dac", "raw", "pct", "code", "nm"])
def test_a_voltage_in_another_unit_is_refused_by_that_unit(unit: str, tmp_path: Path) -> None:
    with pytest.raises(RecordError, match=rf"the voltage 'voltage_{unit}' is in {unit}, which is no unit of a voltage"):
        read(tmp_path, text(f"time_s,voltage_{unit},displacement_um", ",", TIME_S, U_V, Y_UM))


@pytest.mark.parametrize(
    ("name", "said"),
    [("position_" + end, "") for end in ("sensor", "x", "1", "filtered", "Z", "meas", "A2")]
    + [(f"position_{end}", f"if '{end}' is its unit") for end in ("N", "C", "furlong")],
)
def test_a_word_behind_a_name_passes_and_one_that_may_be_a_unit_is_said(name: str, said: str, tmp_path: Path) -> None:
    record = read(tmp_path, text(f"time_s,voltage_V,{name}", ",", TIME_S, U_V, Y_UM))
    np.testing.assert_array_equal(record.y_um, Y_UM)
    assert any("is read in um; if" in line for line in record.warnings) == bool(said)
    assert not said or said in " ".join(record.warnings)


@pytest.mark.parametrize("channel", [1, 2])
@pytest.mark.parametrize("rows", [1, 3])
@pytest.mark.parametrize("mark", ["9.9e37", "-9.91E37", "9.99999999e37", "-9999", "-2147483648", "99999.9", "32767"])
def test_a_value_that_means_no_reading_is_refused_with_its_row(
    mark: str, rows: int, channel: int, tmp_path: Path
) -> None:
    lines = text("time_s,voltage_V,displacement_um", ",", TIME_S, U_V, Y_UM).split("\n")
    for row in range(rows):
        cells = lines[71 + row].split(",")
        cells[channel] = mark
        lines[71 + row] = ",".join(cells)
    name = ("voltage_V", "displacement_um")[channel - 1]
    with pytest.raises(RecordError, match=rf"log.txt: line 72: {name} is [-+\d.e]+ \({rows} such values\)") as fault:
        read(tmp_path, "\n".join(lines))
    assert "displacement_unit" not in str(fault.value)


def test_nines_within_a_stroke_of_the_others_are_readings(tmp_path: Path) -> None:
    y_nm = np.where(np.arange(N) == 70, 9999.0, np.round(1e3 * Y_UM, 1))
    np.testing.assert_allclose(
        read(tmp_path, text("time_s,voltage_V,x_nm", ",", TIME_S, U_V, y_nm)).y_um, 1e-3 * y_nm, rtol=1e-12
    )


@pytest.mark.parametrize("attribute", ["_FillValue", "missing_value"])
def test_a_fill_value_is_none_whether_packed_or_not(attribute: str, tmp_path: Path) -> None:
    path = tmp_path / "log.h5"
    for scaled in (False, True):
        stored = np.rint(1e3 * Y_UM).astype(np.int16)
        stored[200] = -32768
        with h5py.File(path, "w") as file:
            file["time_s"], file["voltage_V"], file["displacement_nm"] = TIME_S, U_V, stored
            file["displacement_nm"].attrs[attribute] = np.int16(-32768)
            if scaled:
                file["displacement_nm"].attrs["scale_factor"] = 2.0
        with pytest.raises(RecordError, match=r"index 200: displacement_nm is nan \(1 such values: nan, null, a fill"):
            load_record(path)


def test_null_in_json_is_refused_with_its_row(tmp_path: Path) -> None:
    values = {"dt": 1e-3, "voltage": U_V.tolist(), "displacement_um": [*Y_UM[:70].tolist(), None, *Y_UM[71:].tolist()]}
    with pytest.raises(RecordError, match=r"log.json: index 70: displacement_um is nan \(1 such values: nan, null"):
        read(tmp_path, json.dumps(values), name="log.json")


HEADS: dict[str, tuple[str, str]] = {
    "label": ("# columns: time position voltage", "\t"),
    "label, units, remarks": ("# a\n# Fields: time; position; voltage\n# units: s; um; V\n# 400", "\t"),
    "rule": ("# time\tposition\tvoltage\n#-------------------", "\t"),
    "short and long names, count": ('# t\tz\tV\n# "Time (s)"\t"Position (um)"\t"Gate voltage (V)"\n# 400', "\t"),
    "a line a column, from 0": ("# [0] time [s]\n# [1] position [um]\n# [2] voltage [V]", "\t"),
    "a line a column, from 1": ("# Column 1: time, s\n# Column 2: position, um\n# Column 3: voltage, V\n#", "\t"),
    "blank comment": ("# time position voltage\n#", "\t"),
    "prose before and after": ("# my piezo stage\n# time position voltage\n# measured on Monday", "\t"),
    "percent": ("% Model: x.mph\n% Time (s)  Position (um)  Voltage (V)", " "),
    "slashes": ("// time, position, voltage\n// ---------------", "\t"),
    "own names": ("# columns: time_s, displacement_um, voltage_V\n# 400 rows", "\t"),
    "far above": ("# columns: time position voltage" + "".join(f"\n# setting{k}: {k}" for k in range(30)), "\t"),
}


@pytest.mark.parametrize("kind", HEADS)
def test_names_in_comments_are_found(kind: str, tmp_path: Path) -> None:
    head, separator = HEADS[kind]
    record = read(tmp_path, text(head, separator, TIME_S, Y_UM, U_V))
    np.testing.assert_array_equal(record.u_V, U_V)
    np.testing.assert_array_equal(record.y_um, Y_UM)


def test_prose_above_a_table_is_no_header(tmp_path: Path) -> None:
    record = read(tmp_path, text("# my piezo stage", "\t", TIME_S, U_V, Y_UM))
    assert any("has no header" in line for line in record.warnings)


@pytest.mark.parametrize("names", ["", "time,voltage,displacement", "time_s,voltage_V,displacement_um"])
def test_the_remedy_for_exchanged_columns_works_when_pasted(names: str, tmp_path: Path) -> None:
    content = text(names, ",", TIME_S, Y_UM, U_V).lstrip()
    with pytest.raises(RecordError, match="seem to be exchanged") as fault:
        read(tmp_path, content)
    record = read(tmp_path, content, str(fault.value).partition('--columns "')[2].partition('"')[0])
    np.testing.assert_array_equal(record.u_V, U_V)
    np.testing.assert_array_equal(record.y_um, Y_UM)


@pytest.mark.parametrize(("names", "end"), [("", ","), ("", ", "), (",", ","), (",,", ",,")])
def test_separators_behind_every_row_are_no_column(names: str, end: str, tmp_path: Path) -> None:
    head, *rows = text("time_s,voltage_V,displacement_um", ",", TIME_S, U_V, Y_UM).split("\n")
    content = "\n".join([head + names, *(row + end for row in rows)])
    np.testing.assert_array_equal(read(tmp_path, content).y_um, Y_UM)


@pytest.mark.parametrize("header", ["", "note,time,voltage,input,position", "voltage,time,input,sensor,position"])
def test_a_column_that_is_empty_in_every_row_is_no_column(header: str, tmp_path: Path) -> None:
    rows = [f"{t},{u},{y}" for t, u, y in zip(TIME_S, U_V, Y_UM, strict=True)]
    places = {"": ",{}", "note,time,voltage,input,position": ",{0},,{1},{2}"}
    form = places.get(header, ",{0},{1},,{2}")
    body = [form.format(*row.split(",")) if header else form.format(row) for row in rows]
    record = read(tmp_path, "\n".join([*([header] if header else []), *body]))
    np.testing.assert_array_equal(record.u_V, U_V)
    np.testing.assert_array_equal(record.y_um, Y_UM)


def test_an_empty_column_that_is_named_is_refused(tmp_path: Path) -> None:
    rows = [f"{t},,{y}" for t, y in zip(TIME_S, Y_UM, strict=True)]
    with pytest.raises(RecordError, match="voltage column voltage_V is empty in every row; name another: voltage=NAME"):
        read(tmp_path, "\n".join(["time_s,voltage_V,displacement_um", *rows]))


def test_channels_one_below_the_other_are_refused_by_the_column_that_numbers_them(tmp_path: Path) -> None:
    lines = [f"{chunk};{t};{v}" for chunk, c in enumerate((U_V, Y_UM)) for t, v in zip(TIME_S, c, strict=True)]
    with pytest.raises(RecordError, match=r"column chunk numbers what each row holds \(0, 1\): the channels stand one"):
        read(tmp_path, "\n".join(["chunk;timestamp;value", *lines]))


def test_channels_one_below_the_other_are_refused_by_a_time_that_begins_again(tmp_path: Path) -> None:
    lines = [f"0;{t};{v}" for channel in (U_V, Y_UM) for t, v in zip(TIME_S, channel, strict=True)]
    with pytest.raises(RecordError, match=rf"column timestamp repeats every {N} rows: the channels stand one below"):
        read(tmp_path, "\n".join(["chunk;timestamp;value", *lines]))


@pytest.mark.parametrize(("value", "rows"), [(-8888.0, 6), (-8888.0, 3), (2.125, 5)])
def test_a_value_at_which_the_displacement_stands_between_two_jumps_is_refused(value: float, rows: int) -> None:
    y_um = Y_UM.copy()
    y_um[[*range(60, 60 + rows), *range(180, 180 + rows)]] = value
    with pytest.raises(
        RecordError, match=rf"index 60: displacement_um is {value:g} \({2 * rows} such values\), which st"
    ):
        Record.from_arrays(U_V, y_um, 1e-3)


@pytest.mark.parametrize("kind", ["pulses", "frozen", "slow sensor"])
def test_a_displacement_that_stands_for_a_cause_passes(kind: str) -> None:
    """Pulses of the voltage under a coarse sensor; a sensor that stands, without a jump; one read every 20th row."""
    y_um = Y_UM.copy()
    u_V = U_V.copy()
    if kind == "pulses":
        u_V[200:206], y_um = 0.0, np.round(0.07 * u_V, 1)
        y_um[200:206] = 0.0
    elif kind == "frozen":
        y_um[100:140] = y_um[100]
    else:
        y_um = y_um[np.arange(N) // 20 * 20]
    assert Record.from_arrays(u_V, y_um, 1e-3).samples == N


def test_units_of_one_column_that_differ_are_refused_and_times_with_a_zone_or_as_dates_are_read(tmp_path: Path) -> None:
    rows = text("s,V,um", ",", TIME_S, U_V, Y_UM)
    with pytest.raises(RecordError, match=r"position \[nm\] is in nm by its name and in um by the row of units; corr"):
        read(tmp_path, "time [s],voltage [V],position [nm]\n" + rows)
    with h5py.File(tmp_path / "log.h5", "w") as file:
        file["time_s"], file["voltage_V"], file["position_nm"] = TIME_S, U_V, Y_UM
        file["position_nm"].attrs["units"] = "um"
    with pytest.raises(RecordError, match="position_nm is in nm by its name and in um by the file; correct one"):
        load_record(tmp_path / "log.h5")
    dates = np.datetime64("2026-03-04T10:00") + np.arange(N) * np.timedelta64(1, "ms")
    lines = [f"{date}+02:00,{u:.9g},{y:.9g}" for date, u, y in zip(dates, U_V, Y_UM, strict=True)]
    np.savez(tmp_path / "log.npz", time=dates, voltage_V=U_V, displacement_um=Y_UM)
    for record in (
        read(tmp_path, "\n".join(["timestamp,voltage_V,displacement_um", *lines])),
        load_record(tmp_path / "log.npz"),
    ):
        assert record.Ts_s == pytest.approx(1e-3)
        np.testing.assert_array_equal(record.y_um, Y_UM)


@pytest.mark.parametrize(("every", "row"), [(2, "2nd"), (3, "3rd"), (10, "10th")])
def test_a_sensor_slower_than_the_log_is_said_with_the_row_step(every: int, row: str) -> None:
    k = np.arange(4000)
    u = 50.0 - 50.0 * np.cos(0.01 * k)
    y = 0.07 * u + 1e-3 * np.random.default_rng(4).normal(size=k.size)
    record = Record.from_arrays(u, y[k // every * every], 1e-3)
    (line,) = [line for line in record.warnings if "the sensor is read every" in line]
    assert f"every {1e-3 * every:g} s; take every {row} row, from index {every} on" in line


@pytest.mark.parametrize("kind", ["eight bits", "rests"])
def test_coarse_readings_and_rests_are_no_slow_sensor(kind: str) -> None:
    k = np.arange(4000)
    u = 50.0 - 50.0 * np.cos(0.003 * k)
    u = 0.025 * np.abs(k % 800 - 400) if kind == "eight bits" else u[k // 10 * 10]
    y = np.rint(0.07 * u / 0.007) * 0.007 if kind == "eight bits" else 0.07 * u
    assert not [line for line in Record.from_arrays(u, y, 1e-3).warnings if "the sensor is read" in line]


@pytest.mark.parametrize("offset", [0.0, 100.0])
@pytest.mark.parametrize("separator", [";", "\t"])
@pytest.mark.parametrize("head", ["Zeit{0}Spannung{0}Weg", "time_s{0}voltage_V{0}displacement_um"])
def test_three_decimals_behind_a_comma_are_no_thousands(
    head: str, separator: str, offset: float, tmp_path: Path
) -> None:
    rows = (separator.join(f"{x + offset:.3f}" for x in row) for row in zip(TIME_S, U_V, Y_UM, strict=True))
    record = read(tmp_path, "\n".join([head.format(separator), *rows]).replace(".", ","))
    assert record.Ts_s == pytest.approx(1e-3)
    np.testing.assert_allclose(record.y_um, Y_UM + offset, atol=6e-4)


def test_a_voltage_or_a_sensor_that_stands_alone_and_two_meanings_of_a_comma_are_said(tmp_path: Path) -> None:
    k = np.arange(N)
    u_V, packet_um = np.where((k > 69) & (k < 76), 5.0, U_V), np.where((k > 149) & (k < 170), Y_UM[150], Y_UM)
    for drive_V, y_um, line in (
        (u_V, Y_UM, "index 70: voltage_V is 5 V (6 such rows), and displacement_um does not answer: wrong?"),
        (U_V, np.where(k > 150, Y_UM[150], Y_UM), f"index 150: displacement_um stands at {Y_UM[150]:.6g} um for 250"),
        (U_V, packet_um, f"index 150: displacement_um stands at {Y_UM[150]:.6g} um for 20 rows without its noise"),
    ):
        assert line in " ".join(Record.from_arrays(drive_V, y_um, 1e-3).warnings)
    rows = (",".join(f"{x:.4f}".replace(".", ",") for x in row) for row in zip(TIME_S, U_V, Y_UM, strict=True))
    with pytest.raises(RecordError, match="line 2: has 6 fields, the header half as many; if its decimal signs are"):
        read(tmp_path, "\n".join(["Zeit,Spannung,Weg", *rows]))
