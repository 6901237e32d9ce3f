"""Text as oscilloscopes, recorders and controllers export it: read, or refused with a line that reads it if pasted."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from hysgen.errors import RecordError
from hysgen.record import Columns, load_record

K = np.arange(300)
TIME_S = np.round(K * 1e-3, 3)
U_V = np.round(30.0 - 25.0 * np.cos(0.03 * K), 4)
Y_UM = np.round(2.0 - 1.5 * np.cos(0.03 * (K - 5)) + 1e-3 * np.random.default_rng(1).normal(size=K.size), 4)


def made(head: Sequence[str], row: str, tail: Sequence[str] = (), between: str = "\n") -> str:
    """Lines of a head, a row for each sample, lines after them."""
    start = datetime(2026, 11, 23, 10)
    rows = (
        row.format(
            k=k, t=t, ms=1e3 * t, us=f"{4_294_000_000 + 1000 * int(k)}", u=u, y=y, nm=1e3 * y, mm=1e-3 * y, A=1e4 * y,
            stamp=(start + timedelta(milliseconds=int(k))).strftime("%m/%d/%Y %H:%M:%S:%f")[:-3],
        )
        for k, t, u, y in zip(K, TIME_S, U_V, Y_UM, strict=True)
    )  # fmt: skip
    return between.join([*head, *rows, *tail, ""])


MSO = [
    "Model,MSO54",
    "Waveform Type,ANALOG",
    "Horizontal Units,s",
    "Horizontal Scale,0.06",
    "Sample Interval,0.001",
    "Gating,0.0% to 100.0%",
    "Probe Attenuation,10,1",
    "Vertical Units,V,um",
    "Vertical Offset,0,0",
    "Vertical Scale,5,1",
    "Vertical Position,0,0",
    ",,",
    "Label,Drive,Sensor",
    "TIME,CH1,CH2",
]
CATMAN = [
    "HBM_CATMAN_DATAFILE_4.0",
    "Datum:\t23.11.2026",
    "",
    "Zeit  1 - Standardmessrate\tMX410B_CH 1\tMX410B_CH 2",
    "Zeit  1 - Standardmessrate [s]\tAnsteuerung [V]\tWegaufnehmer [um]",
    "1000 Hz\t1000 Hz\t1000 Hz",
    "T0=23.11.2026 10:00:00\tT0\tT0",
]
CONTROLDESK = [
    "description,,",
    'measurement,"piezo",',
    'path,,"Platform()://ds1104/Model Root/drive","Platform()://ds1104/Model Root/sensor"',
    'data type,,"FloatIeee64","FloatIeee64"',
    'unit,"s","V","um"',
    "trace_values,,,",
]
TWINCAT = [
    "Name\tpiezo",
    "Starttime of export\t132456789012345678\tMonday\t10:00:00",
    "",
    "Name\tDrive\tName\tPosition",
    "SymbolComment\t\tSymbolComment\t",
    "Data-Type\tREAL64\tData-Type\tREAL64",
    "SampleTime[ms]\t1\tSampleTime[ms]\t1",
    "ScaleFactor\t1\tScaleFactor\t1",
    "",
]
YOKOGAWA = [
    "Header Size,16",
    "Model Name,DL850",
    "TraceName,Drive,Position",
    "BlockSize,300,300",
    "VUnit,V,um",
    "SampleRate,1.0E+03,1.0E+03",
    "HResolution,1.0E-03,1.0E-03",
    "HUnit,s,s",
    "Date,2026/11/23,2026/11/23",
    "Time,10:00:00,10:00:00",
    "",
]

READ: dict[str, str | bytes] = {
    "Keysight, math channel": made(["x-axis,1,Math1", "second,Volt,um"], "{t:+.8E},{u:+.4f},{y:+.4f}"),
    "Keysight 34972A": made(["Scan,Time,101 (VDC),102 (um)"], "{k},{stamp},{u},{y}"),
    "PicoScope": made(["Time,Channel A,Channel B", "(ms),(V),(\N{MICRO SIGN}m)", ""], "{ms:.5f},{u},{y}"),
    "Tektronix MSO": made(MSO, "{t:.6e},{u},{y}"),
    "catman": made(CATMAN, "{t:.3f}\t{u}\t{y}").replace(".", ","),
    "ControlDesk": made(CONTROLDESK, ",{t:.6f},{u},{y}"),
    "TwinCAT": made(TWINCAT, "{ms:g}\t{u}\t{ms:g}\t{y}"),
    "Yokogawa": made(YOKOGAWA, ",{u},{y}"),
    "Origin, with comments": made(["Time\tVoltage\tPosition", "s\tV\tnm", "run 1\tCH1\tCH2"], "{t:.3f}\t{u}\t{nm:.1f}"),
    "units above the names": made(["[s];[V];[nm]", "t;U;Weg"], "{t:.3f};{u};{nm:.1f}"),
    "Igor": made(
        ["IGOR", "WAVES/D\ttime_s, drive_V, pos_nm", "BEGIN"],
        "\t{t:.3f}\t{u}\t{nm:.1f}",
        ["END", 'X SetScale/P x 0,0.001,"s", time_s'],
        "\r",
    ),
    "rate in the preamble": made(["Sample rate: 1 kHz", "", "voltage_V,displacement_um"], "{u},{y}"),
    "period in the preamble": made(["delta t\t0,001000", "", "voltage_V\tdisplacement_um"], "{u}\t{y}"),
    "table of a wiki": made(
        ["Stage 3, monday.", "", "| Time (s) | Voltage (V) | Position (nm) |", "|:--|--:|--:|"],
        "| {t:.3f} | {u} | {nm:.1f} |",
    ),
    "cells as formulas": made(['="Time (s)",="Voltage (V)",="Position (um)"'], '="{t:.3f}",="{u}",="{y}"'),
    "quotes of one stroke": made(["'time','voltage','displacement'"], "'{t:.3f}','{u}','{y}'"),
    "Mathematica": made(['{"t","u","y"},'], "{{{t:.3f}, {u}, {mm:.7f}*^3}},"),
    "a time named by its unit": made(["us,voltage,position"], "{us},{u},{y}"),
    "two tables side by side": made(["Time [s],Voltage [V],Time [s],Position [um]"], "{t:.3f},{u},{t:.3f},{y}"),
    "UTF-16 without a mark": made(["time\tvoltage\tposition"], "{t:.3f}\t{u}\t{y}").encode("utf-16-be"),
    "Japanese": made(["時間(s),電圧(V),変位(um)"], "{t:.3f},{u},{y}").encode("shift-jis"),
    "Russian": made(
        ["Время (\N{CYRILLIC SMALL LETTER ES});Напряжение (\N{CYRILLIC CAPITAL LETTER VE});Перемещение (мкм)"],
        "{t:.3f};{u};{y}",
    ).encode("cp1251"),
    "Angstrom": made(["time,voltage,position (\N{LATIN CAPITAL LETTER A WITH RING ABOVE})"], "{t:.3f},{u},{A:.0f}"),
    "commas in names": made(['"Time, s","Voltage, V","Displacement, um"'], "{t:.3f},{u},{y}"),
}


def check(path: Path, columns: Columns | str = "") -> tuple[str, ...]:
    record = load_record(path, columns)
    (segment,) = record.segments
    assert record.Ts_s == pytest.approx(1e-3, rel=1e-6)
    np.testing.assert_allclose(segment.u_V, U_V, rtol=1e-9)
    np.testing.assert_allclose(segment.y_um, Y_UM, rtol=1e-9)
    return record.warnings


@pytest.mark.parametrize("kind", READ)
def test_a_file_of_an_instrument_is_read_without_options_and_the_option_said_repeats_it(
    kind: str, tmp_path: Path
) -> None:
    text = READ[kind]
    path = tmp_path / "log.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    for line in check(path):
        if 'read as --columns "' in line:
            check(path, line.partition('--columns "')[2].rpartition('"')[0])


TDS = ["Record Length,3.0e+02,", "Sample Interval,1.0e-03,", ",,", ",,", "Source,CH1,", "Vertical Units,V,"]
TDS += ["Horizontal Units,s,", "Yzero,0.0,"]
TDS_ROWS = [f"{t:+.9f},{u:+.5f}," for t, u in zip(TIME_S, U_V, strict=True)]
ONE_CHANNEL = "the file holds one channel; put voltage and displacement into one, as with paste -d,"

REFUSED: dict[str, tuple[str, str, str]] = {
    "Keysight, two voltages": (
        made(["x-axis,1,2", "second,Volt,Volt"], "{t:+.8E},{u:+.8E},{mm:+.8E}"),
        'choose one: --columns "time=x-axis,voltage=1,displacement=2"; of a sensor in Volt, add what one Volt is: ',
        "displacement_unit=1000um",
    ),
    "Rigol": (
        made(["X,CH1,CH2,Start,Increment,", "Sequence,Volt,Volt,0.0,1.0e-03"], "{k},{u:.6e},{mm:.7e},,"),
        'choose one: --columns "voltage=CH1 [Volt],displacement=CH2 [Volt],Ts_s=0.001"; of a sensor in Volt',
        "displacement_unit=1 mm/V",
    ),
    "Siglent": (
        made(["Record Length,Analog:300", "Source,C1,C2", "Second,Volt,Volt"], "{t:.9f},{u},{mm:.7f}"),
        'choose one: --columns "time=Source,voltage=C1,displacement=C2"; of a sensor in Volt',
        "displacement_unit=1000um",
    ),
    "a drive in percent": (
        made(["Time;Drive;Sensor;", "[s];[%];[um];"], "{t:.3f};{u};{y};"),
        "the voltage 'Drive' is in %, which is no unit of a voltage; if it is in V all the same, give "
        '--columns "voltage=Drive,voltage_unit=V"; if one % is 10 V, voltage_unit=10V',
        "",
    ),
    "a name twice": (
        made(["time,voltage,position,position"], "{t:.3f},{u},{u},{y}"),
        'the header names position twice; rename one of the two columns, or choose one: --columns "displacement='
        'position.1" is the second',
        "",
    ),
}


@pytest.mark.parametrize("kind", REFUSED)
def test_the_line_of_a_refusal_reads_the_file_when_it_is_pasted(kind: str, tmp_path: Path) -> None:
    text, said, added = REFUSED[kind]
    path = tmp_path / "log.csv"
    path.write_text(text)
    with pytest.raises(RecordError, match=r"^log\.csv: ") as caught:
        load_record(path)
    assert said in str(caught.value)
    pasted = str(caught.value).partition('--columns "')[2].partition('"')[0]
    check(path, f"{pasted},{added}" if added else pasted)


def test_words_of_a_preamble_are_no_names(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text(made(["Input amplifier,Sensor head,Time base", "", "a,b,c"], "{t:.3f},{u},{y}"))
    with pytest.raises(RecordError, match="the header names a, b, c; say which one it is"):
        load_record(tmp_path / "log.csv")
    check(tmp_path / "log.csv", "time=a,voltage=b,displacement=c")


def test_files_of_one_channel_are_refused_and_read_when_they_are_pasted_together(tmp_path: Path) -> None:
    drive = "\n".join(f"{TDS[k] if k < len(TDS) else ',,'},{row}" for k, row in enumerate(TDS_ROWS))
    sensor = re.sub(r"(?m),[^,]*,$", ",Y,", drive).replace("CH1", "CH2").replace("Units,V,,", "Units,um,,")
    sensor = sensor.replace("Vertical Units,V", "Vertical Units,um")
    values = iter(Y_UM)
    sensor = re.sub(r",Y,", lambda _: f",{next(values):.4f},", sensor)
    (tmp_path / "log.csv").write_text(drive)
    with pytest.raises(RecordError, match=re.escape(ONE_CHANNEL)):
        load_record(tmp_path / "log.csv")
    both = "\n".join(f"{a},{b}" for a, b in zip(drive.split("\n"), sensor.split("\n"), strict=True))
    (tmp_path / "both.csv").write_text(both)
    check(tmp_path / "both.csv")


def test_channels_with_times_of_their_own_are_refused(tmp_path: Path) -> None:
    rows = (f"{t},{u},{t + 6e-4},{y}" for t, u, y in zip(TIME_S, U_V, Y_UM, strict=True))
    (tmp_path / "log.csv").write_text("\n".join(["Time [s],Voltage [V],Time [s],Position [um]", *rows]))
    with pytest.raises(RecordError, match=r"Time \[s\] and Time \[s\]\.1 differ by up to 0\.0006: the channels"):
        load_record(tmp_path / "log.csv")


@pytest.mark.parametrize(
    ("factor", "said"), [(1e3, "if the time is in ms, give --columns time_unit=ms"), (1e7, "time=,Ts_s=SECONDS")]
)
def test_a_time_that_counts_is_said_with_a_rate_that_a_stage_has(factor: float, said: str, tmp_path: Path) -> None:
    rows = (f"{factor * t:.0f},{u},{y}" for t, u, y in zip(TIME_S, U_V, Y_UM, strict=True))
    (tmp_path / "log.csv").write_text("\n".join(["timestamp,voltage,position", *rows]))
    (line,) = [one for one in load_record(tmp_path / "log.csv").warnings if "is sampled at" in one]
    assert said in line
    remedy = "time_unit=ms" if factor == 1e3 else "time=,Ts_s=1e-3"
    check(tmp_path / "log.csv", remedy)


def test_the_remedy_for_an_inverted_sensor_works(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rows = (f"{t},{u},{-y}" for t, u, y in zip(TIME_S, U_V, Y_UM, strict=True))
    path.write_text("\n".join(["time_s,voltage_V,displacement_um", *rows]))
    (line,) = [one for one in load_record(path).warnings if "an inverted sensor?" in one]
    assert "--columns displacement_unit=-1um" in line
    assert check(path, "displacement_unit=-1um") == ()


def test_a_unit_may_say_what_one_in_the_file_is(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text(made(["time,monitor [V],sensor [V]"], "{t},{u},{mm:.7f}"))
    record = load_record(path, "voltage=monitor [V],voltage_unit=100V,displacement=sensor [V],displacement_unit=-1e3um")
    np.testing.assert_allclose(record.u_V, 100.0 * U_V, rtol=1e-12)
    np.testing.assert_allclose(record.y_um, -Y_UM, rtol=1e-9)
    with pytest.raises(RecordError, match=r"displacement_unit: '0um' is not known; choose from um, nm.*, as 10um"):
        Columns(displacement_unit="0um")
