"""Files of data loggers and tables, each by its own library, give the same record; a damaged one is one line."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from fixtures.record_of_files import TIME_S, TS_S, U_V, Y_UM, check
from fixtures.tools import library
from hysgen.errors import RecordError
from hysgen.record import load_record


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
        file.append([asammdf.Signal(samples=U_V[:15], timestamps=TIME_S[::20], name="temperature", unit="degC")])
        file.save(path, overwrite=True)


def parquet_of_dated_rows(path: Path) -> None:
    pandas = library("pandas")
    stamps = pandas.Timestamp("2026-11-23") + pandas.to_timedelta((TIME_S * 1e6).round(), unit="us")
    pandas.DataFrame({"voltage": U_V, "position": Y_UM}, index=stamps.rename("when")).to_parquet(path)


def excel_off_the_corner(path: Path) -> None:
    book = library("openpyxl").Workbook()
    for column, (name, values) in enumerate(
        {"position [um]": Y_UM, "drive voltage [V]": U_V, "time [s]": TIME_S}.items(), 3
    ):
        for row, cell in enumerate([name, *values.tolist()], 4):
            book.active.cell(row, column, cell)
    book.save(path)


WRITERS: dict[str, tuple[str, Callable[[Path], None]]] = {
    "TDMS": ("tdms", as_tdms),
    "MDF4": ("mf4", as_mdf),
    "UFF 58": ("uff", as_uff),
    "Excel": ("xlsx", as_excel),
    "Parquet": ("parquet", as_parquet),
    "Feather": ("feather", as_feather),
    "TDMS with a channel of dates": ("tdms", tdms_of_clock_times),
    "MDF4 with a group for each channel": ("mf4", mdf_of_three_groups),
    "Parquet with dates as index": ("parquet", parquet_of_dated_rows),
    "Excel, table off the corner": ("xlsx", excel_off_the_corner),
}


@pytest.mark.parametrize("form", WRITERS)
def test_a_file_of_another_library_is_read_without_options(form: str, tmp_path: Path) -> None:
    suffix, write = WRITERS[form]
    path = tmp_path / f"log.{suffix}"
    write(path)
    # UFF 58 stores 6 digits.
    check(load_record(path), rel=2e-5 if form == "UFF 58" else 1e-9)


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
