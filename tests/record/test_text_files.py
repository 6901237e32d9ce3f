"""Text files beside the samples: files of one channel, several parts, remedies that work when pasted, packed files."""

import bz2
import gzip
import io
import lzma
import re
import tracemalloc
import zipfile
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io

from fixtures.record_of_files import ROWS, TIME_S, TS_S, U_V, Y_UM, N, check, rows
from hysgen.errors import RecordError
from hysgen.record import Columns, load_record

HEADER = "time_s,voltage_V,displacement_um"


def text(head: str, form: str) -> str:
    return "\n".join([head, *rows(form), ""])


def test_words_of_a_preamble_are_no_names(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text(text("Input amplifier,Sensor head,Time base\n\na,b,c", "{t:.3f},{u},{y}"))
    with pytest.raises(RecordError, match="the header names a, b, c; say which one it is"):
        load_record(tmp_path / "log.csv")
    check(load_record(tmp_path / "log.csv", "time=a,voltage=b,displacement=c"))


TDS = ["Record Length,3.0e+02,", "Sample Interval,1.0e-03,", ",,", ",,", "Source,CH1,", "Vertical Units,V,"]
TDS += ["Horizontal Units,s,", "Yzero,0.0,"]
TDS_ROWS = rows("{t:+.9f},{u:+.5f},")
ONE_CHANNEL = "the file holds one channel; put voltage and displacement into one, as with paste -d,"


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
    check(load_record(tmp_path / "both.csv"))


def test_channels_with_times_of_their_own_are_refused(tmp_path: Path) -> None:
    lines = (f"{t},{u},{t + 6e-4},{y}" for t, u, y in zip(TIME_S, U_V, Y_UM, strict=True))
    (tmp_path / "log.csv").write_text("\n".join(["Time [s],Voltage [V],Time [s],Position [um]", *lines]))
    with pytest.raises(RecordError, match=r"Time \[s\] and Time \[s\]\.1 differ by up to 0\.0006: the channels"):
        load_record(tmp_path / "log.csv")


@pytest.mark.parametrize(
    ("factor", "said"), [(1e3, "if the time is in ms, give --columns time_unit=ms"), (1e7, "time=,Ts_s=SECONDS")]
)
def test_a_time_that_counts_is_said_with_a_rate_that_a_stage_has(factor: float, said: str, tmp_path: Path) -> None:
    lines = (f"{factor * t:.0f},{u},{y}" for t, u, y in zip(TIME_S, U_V, Y_UM, strict=True))
    (tmp_path / "log.csv").write_text("\n".join(["timestamp,voltage,position", *lines]))
    (line,) = [one for one in load_record(tmp_path / "log.csv").warnings if "is sampled at" in one]
    assert said in line
    remedy = "time_unit=ms" if factor == 1e3 else "time=,Ts_s=1e-3"
    check(load_record(tmp_path / "log.csv", remedy))


def test_the_remedy_for_an_inverted_sensor_works(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    lines = (f"{t},{u},{-y}" for t, u, y in zip(TIME_S, U_V, Y_UM, strict=True))
    path.write_text("\n".join(["time_s,drive,position", *lines]))
    angle = "voltage=drive,displacement=position,input=field [mT],output=angle [deg],"
    for stated, unit in (("", "um"), (angle, "deg")):
        (line,) = [one for one in load_record(path, stated[:-1]).warnings if "an inverted sensor?" in one]
        assert f"--columns displacement_unit=-1{unit} " in line
        check(load_record(path, f"{stated}displacement_unit=-1{unit}"))


def test_a_unit_may_say_what_one_in_the_file_is(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text(text("time,monitor [V],sensor [V]", "{t},{u},{mm:.7f}"))
    record = load_record(path, "voltage=monitor [V],voltage_unit=100V,displacement=sensor [V],displacement_unit=-1e3um")
    np.testing.assert_allclose(record.u_V, 100.0 * U_V, rtol=1e-12)
    np.testing.assert_allclose(record.y_um, -Y_UM, rtol=1e-9)
    with pytest.raises(RecordError, match=r"displacement_unit: '0um' is not known; choose from um, nm.*, as 10um"):
        Columns(displacement_unit="0um")


def test_logs_put_together_are_segments(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    anew = [f"{t},{u},{y}" for t, u, y in zip(TIME_S, U_V[150:], Y_UM[150:], strict=False)]
    path.write_text("\n".join([HEADER, *ROWS[:150], "Max,55,3.5", "stage 3, run 2", HEADER, *anew]))
    first, second = load_record(path).segments
    np.testing.assert_array_equal(first.u_V, U_V[:150])
    np.testing.assert_array_equal(second.u_V, U_V[150:])


def test_zero_bytes_between_rows_and_a_table_on_its_side_are_refused(tmp_path: Path) -> None:
    path, half = tmp_path / "log.csv", len(ROWS) // 2
    path.write_bytes("\n".join([HEADER, *ROWS[:half], ""]).encode() + bytes(512) + "\n".join(ROWS[half:]).encode())
    with pytest.raises(RecordError, match=r"line 152: holds zero bytes.*tr -d.*--split-at-gaps"):
        load_record(path)
    columns = zip(HEADER.split(","), *(row.split(",") for row in ROWS), strict=True)
    path.write_text("\n".join(",".join(row) for row in columns))
    with pytest.raises(RecordError, match=r"line 1: has 301 fields, and there are 3 lines.*transpose the table"):
        load_record(path)


NO_NUMBERS = (
    "1.#INF",
    "-1.#INF",
    "1.#IND",
    "-1.#IND",
    "1.#QNAN",
    "1.#SNAN",
    "1,#INF",
    "45%",
    "45 %",
    "#DIV/0!",
    "#N/A",
)


@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
@pytest.mark.parametrize("place", [0, 1, 2])
@pytest.mark.parametrize("word", NO_NUMBERS)
def test_a_word_for_no_number_is_refused_in_every_column_with_its_line(
    word: str, place: int, separator: str, tmp_path: Path
) -> None:
    lines = [[f"{k}e-3", f"{k % 37}", f"{0.1 * (k % 37):.4f}"] for k in range(300)]
    lines[70][place] = word
    path = tmp_path / "log.csv"
    names = separator.join(["time_s", "voltage_V", "displacement_um"])
    path.write_text("\n".join([names, *map(separator.join, lines)]))
    with pytest.raises(RecordError, match=r"log\.csv: line 72: ") as fault:
        load_record(path)
    assert word in str(fault.value) or "fields" in str(fault.value)


def lvm_part(columns: str, start: int, stop: int) -> str:
    """A part of an LVM file with the rows start to stop - 1; columns: One, Multi or No, as X_Columns says."""
    names = "X_Value\tVoltage\tX_Value\tPosition" if columns == "Multi" else "X_Value\tVoltage\tPosition"
    lines = []
    for t, u, y in zip(TIME_S[: stop - start], U_V[start:stop], 1e3 * Y_UM[start:stop], strict=True):
        cells = {"One": (t, u, y), "Multi": (t, u, t, y), "No": ("", u, y)}[columns]
        lines.append("\t".join(map(str, cells)) + "\t")
    return "\n".join(
        ["Channels\t2", f"Samples\t{stop - start}\t{stop - start}", "Y_Unit_Label\tV\tnm", "X0\t0.0\t0.0",
         f"Delta_X\t{TS_S}\t{TS_S}", "***End_of_Header***", f"{names}\tComment", *lines, "", ""]
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


def zipped(*extra: str) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name in ("log.csv", *extra):
            archive.writestr(name, "\n".join(["t,u,y", *ROWS]) if name == "log.csv" else b"\0\5\26\7")
    return stream.getvalue()


TEXT = "\n".join(["t,u,y", *ROWS]).encode()
PACKED = {"zip": zipped(), "mac.zip": zipped("__MACOSX/._log.csv"), "csv.bz2": bz2.compress(TEXT)}
PACKED |= {"csv.xz": lzma.compress(TEXT), "csv.gz": gzip.compress(TEXT, mtime=0)}
np.savez(ARRAYS := io.BytesIO(), time_s=TIME_S, voltage_V=U_V, displacement_um=Y_UM)
PACKED |= {"npz": ARRAYS.getvalue()}


@pytest.mark.parametrize("suffix", PACKED)
def test_a_packed_file_is_read(suffix: str, tmp_path: Path) -> None:
    (tmp_path / f"log.{suffix}").write_bytes(PACKED[suffix])
    check(load_record(tmp_path / f"log.{suffix}"))


@pytest.mark.parametrize("suffix", ["csv.gz", "csv.bz2", "csv.xz", "csv.gz.gz", "zip", "npz", "xlsx", "mat", "h5"])
def test_a_bomb_is_refused_before_it_is_unpacked(suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, size = tmp_path / f"log.{suffix}", 1 << 25
    text, many = b"t,u,y\n" + bytes(size), np.zeros(size // 8)
    if suffix == "mat":
        scipy.io.savemat(path, {"voltage": many, "position": many}, do_compression=True)
    elif suffix == "h5":
        with h5py.File(path, "w") as file:
            file.create_dataset("voltage", shape=(1 << 50,), dtype="f8", chunks=(1 << 16,), compression="gzip")
    elif "." in suffix:
        packers: dict[str, Callable[[bytes], bytes]] = {"gz": gzip.compress, "bz2": bz2.compress, "xz": lzma.compress}
        packed = packers[suffix.split(".")[1]](text)
        path.write_bytes(gzip.compress(packed) if suffix.endswith(".gz.gz") else packed)
    else:
        inside = {"zip": "log.csv", "npz": "voltage.npy", "xlsx": "xl/workbook.xml"}[suffix]
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr(inside, text)
    monkeypatch.setattr("hysgen.record.formats.base.AT_ONCE", size // 16)
    monkeypatch.setattr("hysgen.record.formats.packed.AT_ONCE", size // 16)
    tracemalloc.start()
    with pytest.raises(RecordError, match=r"unpacks to more than 100 times its size|is more than 2 GiB unpacked"):
        load_record(path)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert suffix == "mat" or most < size, most  # SciPy unpacks 128 kB of a MAT file at once
