"""Text files as laboratories write them, and files written by the libraries of other programs, give the same record."""

from __future__ import annotations

import bz2
import functools
import gzip
import lzma
import os
import warnings
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import scipy.io

from hysgen.errors import RecordError
from hysgen.record import Columns, Record, load_record

N = 400
TS_S = 2e-5
K = np.arange(N)
TIME_S = np.round(K * TS_S, 6)
U_V = np.round(30.0 + 20.0 * np.sin(0.03 * K), 4)
Y_UM = np.round(2.0 + 1.5 * np.sin(0.03 * (K - 5)) + 1e-3 * np.random.default_rng(1).normal(size=N), 4)
EXPECTED = Record.from_arrays(U_V, Y_UM, TS_S)


def rows(*columns: np.ndarray, separator: str = ",", comma: bool = False) -> list[str]:
    lines = [separator.join(f"{value:.12g}" for value in row) for row in zip(*columns, strict=True)]
    return [line.replace(".", ",") for line in lines] if comma else lines


ROWS = rows(TIME_S, U_V, Y_UM)
STAMPS = [str(np.datetime64("2024-05-01T12:00:00") + np.timedelta64(20 * int(k), "us")) for k in K]
LVM = [
    "LabVIEW Measurement\t",
    "Separator\tTab",
    "Decimal_Separator\t.",
    "X_Columns\tOne",
    "Time\t12:00:00.0",
    "***End_of_Header***\t",
    "",
    "Channels\t2\t\t\t",
    "Samples\t400\t400\t\t",
    "Y_Unit_Label\tVolts\tnm\t\t",
    "X0\t0.0E+0\t0.0E+0\t\t",
    "Delta_X\t2.0E-5\t2.0E-5\t\t",
    "***End_of_Header***\t\t\t\t",
    "X_Value\tVoltage\tPosition\tComment",
]
GCS = [
    "# TYPE = 1",
    "# SEPARATOR = 32",
    "# DIM = 2",
    "# SAMPLE_TIME = 0.00002",
    "# NAME0 = Voltage of output chan 1",
    "# NAME1 = Real Position of axis 1",
    "# END_HEADER",
]

TEXTS: dict[str, bytes] = {
    "units in brackets": "\n".join(["Time [s],Voltage [V],Sensor (um)", *ROWS]).encode(),
    "other capitals": "\n".join(["Time_s,Voltage_V,Displacement_um", *ROWS]).encode(),
    "one letter": "\n".join(["t,u,y", *ROWS]).encode(),
    "German, decimal commas, ms and nm": "\n".join(
        ["Zeit [ms];Spannung [V];Weg [nm]", *rows(1e3 * TIME_S, U_V, 1e3 * Y_UM, separator=";", comma=True)]
    ).encode(),
    "French in Latin-1": "\n".join(
        ["Temps (s)\tTension (V)\tDéplacement (µm)", *rows(TIME_S, U_V, Y_UM, separator="\t", comma=True)]
    ).encode("latin-1"),
    "Chinese": "\n".join(["时间 (s),电压 (V),位移 (um)", *ROWS]).encode(),
    "Chinese in GBK": "\n".join(["时间 (s),电压 (V),位移 (um)", *ROWS]).encode("gbk"),
    "no header": "\n".join(ROWS).encode(),
    "preamble": "\n".join(
        ["Scope 7, channel A", "Rate: 50000 Hz", "N.N.", "", "time,voltage,position", *ROWS]
    ).encode(),
    "sep= of Excel": "\n".join(["sep=;", "Time;Voltage;Position", *rows(TIME_S, U_V, Y_UM, separator=";")]).encode(),
    "row of units": "\n".join(["time,voltage,position", "s,V,nm", *rows(TIME_S, U_V, 1e3 * Y_UM)]).encode(),
    "percent comments": "\n".join(
        ["% stage 3", "% time voltage position", *rows(TIME_S, U_V, Y_UM, separator=" ")]
    ).encode(),
    "UTF-16": "\n".join(["time\tvoltage\tposition", *rows(TIME_S, U_V, Y_UM, separator="\t")]).encode("utf-16"),
    "time of day": "\n".join(
        ["timestamp,voltage,position", *(f"{s},{u},{y}" for s, u, y in zip(STAMPS, U_V, Y_UM, strict=True))]
    ).encode(),
    "thousands": "\n".join(
        [
            "time;voltage;position [nm]",
            *(f"{t:.5f};{u};{1e3 * y:,.1f}" for t, u, y in zip(TIME_S, U_V, Y_UM, strict=True)),
        ]
    ).encode(),
    "time rounded to 0.1 ms": "\n".join(["t,u,y", *rows(np.round(TIME_S, 4), U_V, Y_UM)]).encode(),
    "last line cut short": "\n".join(["t,u,y", *ROWS, "0.008,3"]).encode(),
    "LabVIEW LVM": "\n".join([*LVM, *rows(TIME_S, U_V, 1e3 * Y_UM, separator="\t")]).encode(),
    "GCS array": "\n".join([*GCS, *rows(U_V, Y_UM, separator=" ")]).encode(),
    "packed": gzip.compress("\n".join(["t,u,y", *ROWS]).encode()),
}


def check(record: Record, rel: float = 1e-9) -> None:
    assert len(record.segments) == 1
    assert record.Ts_s == pytest.approx(TS_S, rel=1e-9)
    np.testing.assert_allclose(record.segments[0].u_V, U_V, rtol=rel)
    np.testing.assert_allclose(record.segments[0].y_um, Y_UM, rtol=rel)


@pytest.mark.parametrize("kind", TEXTS)
def test_text_is_read_without_options_and_the_option_that_repeats_it_is_said(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "log.txt"
    path.write_bytes(TEXTS[kind])
    record = load_record(path)
    check(record)
    (line,) = [line for line in record.warnings if 'read as --columns "' in line]
    assert ("时间" in line) == kind.startswith("Chinese")
    again = load_record(path, Columns.from_text(line.partition('--columns "')[2].partition('"')[0]))
    assert again.digest == record.digest


def library(name: str) -> Any:
    """A library of hysgen[formats]; where it is missing the test says so, in CI it fails."""
    if os.environ.get("HYSGEN_REQUIRE_TOOLS"):
        return __import__(name, fromlist=["_"])
    return pytest.importorskip(name, reason=f"{name} is missing: pip install 'hysgen[formats]'")


def as_tdms(path: Path) -> None:
    tdms = library("nptdms")
    channels = [
        tdms.ChannelObject("run", name, values, properties={"wf_increment": TS_S, "unit_string": unit})
        for name, values, unit in (("Voltage", U_V, "V"), ("Position", 1e3 * Y_UM, "nm"))
    ]
    with tdms.TdmsWriter(path) as writer:
        writer.write_segment(channels)


def as_mdf(path: Path) -> None:
    asammdf = library("asammdf")
    with asammdf.MDF(version="4.10") as file:
        file.append(
            [
                asammdf.Signal(samples=values, timestamps=TIME_S, name=name, unit=unit)
                for name, values, unit in (("Drive voltage", U_V, "V"), ("Position", 1e3 * Y_UM, "nm"))
            ]
        )
        file.save(path, overwrite=True)


def as_uff(path: Path) -> None:
    pyuff = library("pyuff")
    for name, values, unit in (("Voltage", U_V, "V"), ("Displacement", Y_UM * 1e-6, "m")):
        pyuff.UFF(str(path)).write_sets(
            pyuff.prepare_58(
                binary=0, func_type=1, rsp_node=1, rsp_dir=1, ref_dir=1, ref_node=1, data=values, x=TIME_S, id1=name,
                rsp_ent_name=name, abscissa_spacing=1, orddenom_spec_data_type=0, z_axis_spec_data_type=0,
                abscissa_inc=TS_S, ordinate_axis_units_lab=unit,
            ),
            mode="add",
        )  # fmt: skip


def as_excel(path: Path) -> None:
    book = library("openpyxl").Workbook()
    sheet = book.active
    sheet.append(["Time [s]", "Voltage [V]", "Position [um]"])
    for row in zip(TIME_S.tolist(), U_V.tolist(), Y_UM.tolist(), strict=True):
        sheet.append(row)
    book.save(path)


def as_parquet(path: Path) -> None:
    arrow = library("pyarrow")
    library("pyarrow.parquet").write_table(
        arrow.table({"time": TIME_S, "voltage": U_V, "position_nm": 1e3 * Y_UM}), path
    )


def as_feather(path: Path) -> None:
    arrow = library("pyarrow")
    library("pyarrow.feather").write_feather(arrow.table({"time": TIME_S, "voltage": U_V, "position": Y_UM}), path)


def as_simulink(path: Path) -> None:
    signals = np.zeros(2, dtype=[("values", "O"), ("label", "O")])
    signals[0], signals[1] = (U_V[:, None], "voltage"), (Y_UM[:, None], "position")
    scipy.io.savemat(path, {"yout": {"time": TIME_S[:, None], "signals": signals}})


def as_dspace(path: Path) -> None:
    y = np.zeros(2, dtype=[("Name", "O"), ("Data", "O")])
    y[0], y[1] = ("Voltage", U_V), ("Sensor position", Y_UM)
    scipy.io.savemat(path, {"rec001": {"X": {"Name": "", "Data": TIME_S}, "Y": y, "Description": "run"}})


def as_timetable(path: Path, version: str = "v7") -> None:
    pandas, matio = library("pandas"), library("matio")
    table = pandas.DataFrame({"voltage": U_V, "position": Y_UM}, index=pandas.to_timedelta(TIME_S, unit="s"))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        matio.save_to_mat(str(path), {"log": table.rename_axis("Time")}, version=version)


def as_matrix(path: Path) -> None:
    scipy.io.savemat(path, {"data": np.column_stack([TIME_S, U_V, Y_UM])})


def as_npy(path: Path) -> None:
    np.save(path, np.column_stack([TIME_S, U_V, Y_UM]))


def as_compound(path: Path) -> None:
    table = np.zeros(N, dtype=[("time", "f8"), ("voltage", "f8"), ("position_nm", "f8")])
    table["time"], table["voltage"], table["position_nm"] = TIME_S, U_V, 1e3 * Y_UM
    with h5py.File(path, "w") as file:
        file["log/table"] = table


def as_hdf5_with_attributes(path: Path) -> None:
    with h5py.File(path, "w") as file:
        file.attrs["sample_rate"] = 1.0 / TS_S
        file["u"], file["y"] = U_V, 1e3 * Y_UM
        file["y"].attrs["unit"] = "nm"


def as_zip(path: Path) -> None:
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("log.csv", "\n".join(["t,u,y", *ROWS]))


WRITERS: dict[str, tuple[str, Callable[[Path], None]]] = {
    "TDMS": ("tdms", as_tdms),
    "MDF4": ("mf4", as_mdf),
    "UFF 58": ("uff", as_uff),
    "Excel": ("xlsx", as_excel),
    "Parquet": ("parquet", as_parquet),
    "Feather": ("feather", as_feather),
    "Simulink structure": ("mat", as_simulink),
    "dSPACE structure": ("mat", as_dspace),
    "MAT matrix": ("mat", as_matrix),
    "MATLAB timetable": ("mat", as_timetable),
    "MATLAB timetable, v7.3": ("mat", functools.partial(as_timetable, version="v7.3")),
    "NPY": ("npy", as_npy),
    "HDF5 compound": ("h5", as_compound),
    "HDF5 attributes": ("h5", as_hdf5_with_attributes),
    "zip": ("zip", as_zip),
}


def lvm_part(columns: str, start: int, stop: int) -> str:
    """A part of an LVM file with the rows start to stop - 1; columns: One, Multi or No, as X_Columns says."""
    names = "X_Value\tVoltage\tX_Value\tPosition" if columns == "Multi" else "X_Value\tVoltage\tPosition"
    rows = []
    for t, u, y in zip(TIME_S[: stop - start], U_V[start:stop], 1e3 * Y_UM[start:stop], strict=True):
        cells = {"One": (t, u, y), "Multi": (t, u, t, y), "No": ("", u, y)}[columns]
        rows.append("\t".join(map(str, cells)) + "\t")
    return "\n".join(
        ["Channels\t2", f"Samples\t{stop - start}\t{stop - start}", "Y_Unit_Label\tV\tnm", "X0\t0.0\t0.0",
         f"Delta_X\t{TS_S}\t{TS_S}", "***End_of_Header***", f"{names}\tComment", *rows, "", ""]
    )  # fmt: skip


@pytest.mark.parametrize("columns", ["One", "Multi", "No"])
def test_lvm_with_a_header_for_each_part_is_one_segment_a_part(columns: str, tmp_path: Path) -> None:
    path = tmp_path / "log.lvm"
    head = f"LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t.\nX_Columns\t{columns}\n***End_of_Header***\n\n"
    path.write_text(head + lvm_part(columns, 0, N))
    check(load_record(path))
    half = N // 2
    path.write_text(head + lvm_part(columns, 0, half) + lvm_part(columns, half, N))
    record = load_record(path)
    assert [segment.samples for segment in record.segments] == [half, N - half]
    np.testing.assert_allclose(np.concatenate([s.y_um for s in record.segments]), Y_UM, rtol=1e-9)
    path.write_text(head + lvm_part(columns, 0, half).replace(f"{U_V[7]}", "x", 1))
    with pytest.raises(RecordError, match=r"log.lvm: line \d+: is no row of \d numbers"):
        load_record(path)


@pytest.mark.parametrize("form", WRITERS)
def test_a_file_of_another_library_is_read_without_options(form: str, tmp_path: Path) -> None:
    suffix, write = WRITERS[form]
    path = tmp_path / f"log.{suffix}"
    write(path)
    # UFF 58 stores 6 digits.
    check(load_record(path), rel=2e-5 if form == "UFF 58" else 1e-9)


def tdms_of_clock_times(path: Path) -> None:
    tdms = library("nptdms")
    stamps = np.datetime64("2026-11-23T10:00:00") + (TIME_S * 1e6).round().astype("timedelta64[us]")
    channels = {"When": stamps, "Voltage": U_V, "Position": Y_UM}
    with tdms.TdmsWriter(path) as writer:
        writer.write_segment([tdms.ChannelObject("log", name, values) for name, values in channels.items()])


def mdf_of_three_groups(path: Path) -> None:
    asammdf = library("asammdf")
    with asammdf.MDF(version="4.10") as file:
        file.append([asammdf.Signal(samples=U_V, timestamps=TIME_S, name="voltage", unit="V")])
        file.append([asammdf.Signal(samples=Y_UM, timestamps=TIME_S, name="position", unit="um")])
        file.append([asammdf.Signal(samples=U_V[:20], timestamps=TIME_S[::20], name="temperature", unit="degC")])
        file.save(path, overwrite=True)


def parquet_of_dated_rows(path: Path) -> None:
    pandas = library("pandas")
    stamps = pandas.Timestamp("2026-11-23") + pandas.to_timedelta((TIME_S * 1e6).round(), unit="us")
    pandas.DataFrame({"voltage": U_V, "position": Y_UM}, index=stamps.rename("when")).to_parquet(path)


def hdf5_of_packed_integers(path: Path) -> None:
    with h5py.File(path, "w") as file:
        file["log/time"] = TIME_S
        file["log/drive"] = np.round((U_V - 5.0) / 1e-4).astype("i4")
        file["log/drive"].attrs.update({"scale_factor": 1e-4, "add_offset": 5.0, "Units": "V"})
        file["log/gauge"] = 1e3 * Y_UM
        file["log/gauge"].attrs["Unit"] = np.bytes_("nm")


def excel_off_the_corner(path: Path) -> None:
    book = library("openpyxl").Workbook()
    for column, (name, values) in enumerate(
        {"position [um]": Y_UM, "drive voltage [V]": U_V, "time [s]": TIME_S}.items(), 3
    ):
        for row, cell in enumerate([name, *values.tolist()], 4):
            book.active.cell(row, column, cell)
    book.save(path)


def zip_of_a_mac(path: Path) -> None:
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("log.csv", "\n".join(["t,u,y", *ROWS]))
        archive.writestr("__MACOSX/._log.csv", b"\0\5\26\7")


def lvm_of_units_in_full(path: Path) -> None:
    lines = [line.replace("Volts\tnm", "Volts\tMicrometers") for line in LVM]
    path.write_text("\n".join([*lines, *rows(TIME_S, U_V, Y_UM, separator="\t")]))


def gcs_with_a_target(path: Path) -> None:
    head = [line.replace("DIM = 2", "DIM = 3") for line in GCS[:-1]]
    text = [*head, "# NAME2 = Target Position of axis 1", "# END_HEADER", *rows(U_V, Y_UM, Y_UM + 0.01, separator=" ")]
    path.write_text("\n".join(text))


OTHERS: dict[str, tuple[str, Callable[[Path], None]]] = {
    "TDMS with a channel of dates": ("tdms", tdms_of_clock_times),
    "MDF4 with a group for each channel": ("mf4", mdf_of_three_groups),
    "Parquet with dates as index": ("parquet", parquet_of_dated_rows),
    "HDF5 with packed integers": ("h5", hdf5_of_packed_integers),
    "Excel, table off the corner": ("xlsx", excel_off_the_corner),
    "zip of a Mac": ("zip", zip_of_a_mac),
    "bzip2": ("csv.bz2", lambda path: path.write_bytes(bz2.compress("\n".join(["t,u,y", *ROWS]).encode())) and None),
    "xz": ("csv.xz", lambda path: path.write_bytes(lzma.compress("\n".join(["t,u,y", *ROWS]).encode())) and None),
    "LVM with units in full": ("lvm", lvm_of_units_in_full),
    "GCS array with a target": ("dat", gcs_with_a_target),
}


@pytest.mark.parametrize("form", OTHERS)
def test_a_file_as_other_users_of_its_library_write_it_is_read_without_options(form: str, tmp_path: Path) -> None:
    suffix, write = OTHERS[form]
    path = tmp_path / f"log.{suffix}"
    write(path)
    check(load_record(path))


def test_groups_of_an_hdf5_file_that_hold_the_same_names_are_segments(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "runs.h5", "w") as file:
        for name in ("run1", "run2"):
            file[f"{name}/time"], file[f"{name}/voltage"], file[f"{name}/position"] = TIME_S, U_V, Y_UM
    record = load_record(tmp_path / "runs.h5")
    assert [one.name for one in record.segments] == ["run1", "run2"]
    assert record.Ts_s == pytest.approx(TS_S)


def test_a_missing_library_is_named_with_the_extra_that_brings_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "a.tdms").write_bytes(b"TDSm" + bytes(40))
    monkeypatch.setitem(__import__("sys").modules, "nptdms", None)
    with pytest.raises(RecordError, match=r"a.tdms: TDMS files need nptdms; pip install 'hysgen\[formats\]'"):
        load_record(tmp_path / "a.tdms")


@pytest.mark.parametrize("suffix", ["tdms", "parquet", "mf4", "h5", "npy", "feather", "xlsx", "csv.gz"])
def test_a_damaged_file_is_one_line(suffix: str, tmp_path: Path) -> None:
    magic = {"tdms": b"TDSm", "parquet": b"PAR1", "mf4": b"MDF     ", "h5": b"\x89HDF\r\n\x1a\n", "npy": b"\x93NUMPY"}
    magic |= {"feather": b"ARROW1", "xlsx": b"PK\x03\x04", "csv.gz": b"\x1f\x8b"}
    path = tmp_path / f"a.{suffix}"
    path.write_bytes(magic[suffix] + bytes(range(200)))
    with pytest.raises(RecordError) as caught:
        load_record(path)
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith(path.name)


def test_the_tdms_of_the_tutorial_is_read_without_options(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The first step of docs/export.md, as it stands there."""
    library("nptdms")
    page = (Path(__file__).parents[2] / "docs" / "export.md").read_text(encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    exec(page.partition("```python\n")[2].partition("```")[0], {})
    record = load_record(tmp_path / "stage.tdms")
    assert (record.samples, record.Ts_s) == (67_248, pytest.approx(2e-5))
    assert record.u_range_V == pytest.approx((5.7764, 54.2236))
