"""Text files as laboratories write them, also packed, give the same record."""

from __future__ import annotations

import bz2
import gzip
import lzma
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from fixtures.record_of_files import ROWS, TIME_S, TS_S, U_V, Y_UM, K, N, check, rows
from hysgen.errors import RecordError
from hysgen.record import Columns, load_record

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
    "words put together": "\n".join(["Zeitachse,DriveVoltage,Wegsensor", *ROWS]).encode(),
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
    with pytest.raises(RecordError, match=r"log.lvm: line \d+: Voltage is 'x', not a number; correct it"):
        load_record(path)


def as_zip(path: Path) -> None:
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("log.csv", "\n".join(["t,u,y", *ROWS]))


def zip_of_a_mac(path: Path) -> None:
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("log.csv", "\n".join(["t,u,y", *ROWS]))
        archive.writestr("__MACOSX/._log.csv", b"\0\5\26\7")


def lvm_of_units_in_full(path: Path) -> None:
    lines = [line.replace("Volts\tnm", "Volts\tMicrometers") for line in LVM]
    path.write_text("\n".join([*lines, *rows(TIME_S, U_V, Y_UM, separator="\t")]))


def lvm_of_a_german_computer(path: Path) -> None:
    head = [line.replace("Separator\t.", "Separator\t,").replace("Volts\tnm", "Volt\tµm") for line in LVM]
    head[-1] = "X_Value\tSpannung\tWegsensor\tComment"
    path.write_text("\n".join([*head, *rows(TIME_S, U_V, Y_UM, separator="\t", comma=True)]), encoding="latin-1")


def gcs_with_a_target(path: Path) -> None:
    head = [line.replace("DIM = 2", "DIM = 3") for line in GCS[:-1]]
    text = [*head, "# NAME2 = Target Position of axis 1", "# END_HEADER", *rows(U_V, Y_UM, Y_UM + 0.01, separator=" ")]
    path.write_text("\n".join(text))


WRITERS: dict[str, tuple[str, Callable[[Path], None]]] = {
    "zip": ("zip", as_zip),
    "zip of a Mac": ("zip", zip_of_a_mac),
    "bzip2": ("csv.bz2", lambda path: path.write_bytes(bz2.compress("\n".join(["t,u,y", *ROWS]).encode())) and None),
    "xz": ("csv.xz", lambda path: path.write_bytes(lzma.compress("\n".join(["t,u,y", *ROWS]).encode())) and None),
    "LVM with units in full": ("lvm", lvm_of_units_in_full),
    "LVM of a German computer": ("lvm", lvm_of_a_german_computer),
    "GCS array with a target": ("dat", gcs_with_a_target),
}


@pytest.mark.parametrize("form", WRITERS)
def test_a_packed_file_and_a_text_with_other_words_are_read_without_options(form: str, tmp_path: Path) -> None:
    suffix, write = WRITERS[form]
    path = tmp_path / f"log.{suffix}"
    write(path)
    check(load_record(path))
