"""Files of arrays (MAT, HDF5, NPY), each written by its own library, give the same record."""

import functools
import json
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import scipy.io
import scipy.io.wavfile

from fixtures.record_of_files import TIME_S, TS_S, U_V, Y_UM, K, N, check
from fixtures.tools import library
from hysgen.errors import RecordError
from hysgen.record import load_record
from hysgen.record.columns import Columns
from hysgen.trajectory.reference import load_series


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


def as_mat_v4(path: Path) -> None:
    scipy.io.savemat(path, {"time": TIME_S, "voltage": U_V, "position_um": Y_UM}, format="4")


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


def hdf5_of_packed_integers(path: Path) -> None:
    with h5py.File(path, "w") as file:
        file["log/time"] = TIME_S
        file["log/drive"] = np.round((U_V - 5.0) / 1e-4).astype("i4")
        file["log/drive"].attrs.update({"scale_factor": 1e-4, "add_offset": 5.0, "Units": "V"})
        file["log/gauge"] = 1e3 * Y_UM
        file["log/gauge"].attrs["Unit"] = np.bytes_("nm")


COLUMNS = {"time": TIME_S.tolist(), "voltage": U_V.tolist(), "position_nm": (1e3 * Y_UM).tolist()}


def json_of(path: Path, content: Any) -> None:
    path.write_text(json.dumps(content))


def json_rows(path: Path) -> None:
    json_of(path, [dict(zip(COLUMNS, row, strict=True)) for row in zip(*COLUMNS.values(), strict=True)])


def json_split(path: Path) -> None:
    json_of(path, {"columns": list(COLUMNS), "index": K.tolist(), "data": list(zip(*COLUMNS.values(), strict=True))})


def json_of_pandas(path: Path) -> None:
    json_of(path, {name: {str(k): value for k, value in enumerate(values)} for name, values in COLUMNS.items()})


def json_with_a_period(path: Path) -> None:
    json_of(path, {"u": COLUMNS["voltage"], "pos_nm": COLUMNS["position_nm"], "fs": 1.0 / TS_S, "note": "run 1"})


WRITERS: dict[str, tuple[str, Callable[[Path], None]]] = {
    "Simulink structure": ("mat", as_simulink),
    "dSPACE structure": ("mat", as_dspace),
    "MAT matrix": ("mat", as_matrix),
    "MATLAB timetable": ("mat", as_timetable),
    "MATLAB timetable, v7.3": ("mat", functools.partial(as_timetable, version="v7.3")),
    "NPY": ("npy", as_npy),
    "MAT v4": ("mat", as_mat_v4),
    "HDF5 compound": ("h5", as_compound),
    "HDF5 attributes": ("h5", as_hdf5_with_attributes),
    "HDF5 with packed integers": ("h5", hdf5_of_packed_integers),
    "JSON, arrays": ("json", lambda path: json_of(path, COLUMNS)),
    "JSON, rows": ("json", json_rows),
    "JSON, split": ("json", json_split),
    "JSON of pandas": ("json", json_of_pandas),
    "JSON, numbers in quotes": ("json", lambda path: json_of(path, {k: list(map(str, v)) for k, v in COLUMNS.items()})),
    "JSON, arrays and a rate": ("json", json_with_a_period),
}


@pytest.mark.parametrize("form", WRITERS)
def test_a_file_of_arrays_is_read_without_options(form: str, tmp_path: Path) -> None:
    suffix, write = WRITERS[form]
    path = tmp_path / f"log.{suffix}"
    write(path)
    check(load_record(path))


@pytest.mark.parametrize(
    "text", ['{"schema": "hysgen-model", "rules": {"q": [1, 2]}}', "[1, 2]", "{", '{"a": [1, [2]]}']
)
def test_json_without_columns_is_refused(text: str, tmp_path: Path) -> None:
    (tmp_path / "log.json").write_text(text)
    with pytest.raises(RecordError, match=r"log\.json: is (JSON without columns of numbers|no whole JSON)"):
        load_record(tmp_path / "log.json")


def test_a_dataframe_in_hdf5_is_refused_with_two_cures(tmp_path: Path) -> None:
    """The layout that `DataFrame.to_hdf` writes, without PyTables, which is no dependency of the tests."""
    with h5py.File(tmp_path / "log.h5", "w") as file:
        group = file.create_group("run")
        group.attrs["pandas_type"] = np.bytes_("frame")
        group["block0_items"] = np.array([b"time", b"voltage", b"position_nm"])
        group["block0_values"] = np.column_stack([TIME_S, U_V, 1e3 * Y_UM])
    with pytest.raises(RecordError, match=r"log\.h5: holds a DataFrame \(run\).*CSV or Parquet.*from_dataframe\("):
        load_record(tmp_path / "log.h5")


def test_groups_of_an_hdf5_file_that_hold_the_same_names_are_segments(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "runs.h5", "w") as file:
        for name in ("run1", "run2"):
            file[f"{name}/time"], file[f"{name}/voltage"], file[f"{name}/position"] = TIME_S, U_V, Y_UM
    record = load_record(tmp_path / "runs.h5")
    assert [one.name for one in record.segments] == ["run1", "run2"]
    assert record.Ts_s == pytest.approx(TS_S)


def test_a_wav_file_holds_channels_by_number_and_a_rate(tmp_path: Path) -> None:
    """Floats as they are; whole numbers as shares of full scale, which is said."""
    rate_Hz, named = round(1.0 / TS_S), Columns(voltage="channel 1", displacement="channel 2")
    scipy.io.wavfile.write(tmp_path / "two.wav", rate_Hz, np.column_stack([U_V, Y_UM]))
    record = load_record(tmp_path / "two.wav", columns=named)
    np.testing.assert_array_equal(record.y_um, Y_UM)
    assert record.Ts_s == pytest.approx(1.0 / rate_Hz)
    shares = np.array([-32768, -16384, 0, 16384], dtype=np.int16)
    scipy.io.wavfile.write(tmp_path / "one.wav", rate_Hz, shares)
    series = load_series(tmp_path / "one.wav", "displacement", Columns(displacement="channel 1"))
    assert series.values.tolist() == [-1.0, -0.5, 0.0, 0.5]
    assert any("shares of full scale" in remark for remark in series.remarks)
    assert series.time_s[1] == pytest.approx(1.0 / rate_Hz)
