"""Every format gives the same numbers and digest; accepted variants of the formats."""

import dataclasses
import tempfile
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io
from hypothesis import given, settings
from hypothesis import strategies as st

from hysgen.errors import RecordError
from hysgen.record import Columns, Record, load_record, record_csv
from hysgen.record.checks import ACCEPTABLE

HEADER = "time_s,voltage_V,displacement_um"
K = np.arange(60)
U_V = np.round(50 + 40 * np.sin(2 * np.pi * K / 20), 6)
Y_UM = np.round(5 + 3 * np.sin(2 * np.pi * (K - 1) / 20), 6)
SOUND = Record.from_arrays(U_V, Y_UM, 1e-3)


def channels(record: Record) -> dict[str, np.ndarray]:
    """What a logger would write: time and channels of all segments in a row, and the number of each row's segment."""
    parts = record.segments
    arrays = {
        "time_s": np.concatenate([one.start_s + np.arange(one.samples) * record.Ts_s for one in parts]),
        "voltage_V": np.concatenate([one.u_V for one in parts]),
        "displacement_um": np.concatenate([one.y_um for one in parts]),
    }
    arrays |= {name: np.concatenate([one.aux[name] for one in parts]) for name in record.aux_names}
    if len(parts) > 1:
        arrays["segment"] = np.repeat(np.arange(len(parts)), [one.samples for one in parts])
    return arrays


def as_csv(path: Path, record: Record) -> None:
    path.with_suffix(".csv").write_text(record_csv(record))


def as_npz(path: Path, record: Record) -> None:
    np.savez(path.with_suffix(".npz"), **channels(record))


def as_mat_v5(path: Path, record: Record) -> None:
    scipy.io.savemat(path.with_suffix(".mat"), channels(record), oned_as="column")


def as_mat_v73(path: Path, record: Record) -> None:
    """As MATLAB writes -v7.3: HDF5 behind a block of 512 bytes, axes reversed, each dataset marked with its class."""
    with h5py.File(path.with_suffix(".mat"), "w", userblock_size=512) as file:
        for name, values in channels(record).items():
            file[name] = values[None, :]
            file[name].attrs["MATLAB_class"] = np.bytes_("double")
    with path.with_suffix(".mat").open("r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")


def as_hdf5(path: Path, record: Record) -> None:
    with h5py.File(path.with_suffix(".h5"), "w") as file:
        for name, values in channels(record).items():
            file[f"stage/run7/{name}"] = values


WRITERS: dict[str, Callable[[Path, Record], None]] = {
    "CSV": as_csv,
    "NPZ": as_npz,
    "MAT v5": as_mat_v5,
    "MAT v7.3": as_mat_v73,
    "HDF5": as_hdf5,
}

PERIODS_S = [1 / 50e3, 1 / 44.1e3, 1 / 6400, 1 / 750, 0.005, 0.1]
reals = st.floats(min_value=-1e6, max_value=1e6, allow_nan=False)


@st.composite
def records(draw: st.DrawFn) -> Record:
    """Records of one to three segments with any float64 values and up to two further channels."""
    names = draw(st.lists(st.sampled_from(["temperature_C", "axis2_V", "strain"]), max_size=2, unique=True))
    period = draw(st.sampled_from(PERIODS_S))
    parts = []
    for _ in range(draw(st.integers(1, 3))):
        n = draw(st.integers(3, 12))
        series = st.lists(reals, min_size=n, max_size=n)
        aux = {name: draw(series) for name in names}
        start = draw(st.integers(0, 100)) * period
        made = Record.from_arrays(draw(series), draw(series), period, aux, accept=ACCEPTABLE)
        moved = [dataclasses.replace(segment, start_s=start) for segment in made.segments]
        parts.append(Record.from_segments(moved, period, made.source, made.warnings))
    return Record.joined(*parts)


@pytest.mark.parametrize("form", WRITERS)
@settings(max_examples=40)
@given(record=records())
def test_record_written_and_read_back_is_the_same_in_every_format(form: str, record: Record) -> None:
    with tempfile.TemporaryDirectory() as folder:
        WRITERS[form](Path(folder) / "record", record)
        back = load_record(next(Path(folder).iterdir()), accept=ACCEPTABLE)
    assert back.digest == record.digest
    assert back.Ts_s == pytest.approx(record.Ts_s, rel=1e-12)  # 12 stamps at up to 100 periods: rounding of the stamps
    assert back.aux_names == record.aux_names
    assert len(back.segments) == len(record.segments)
    for one, other in zip(back.segments, record.segments, strict=True):
        np.testing.assert_array_equal(one.u_V, other.u_V)
        np.testing.assert_array_equal(one.y_um, other.y_um)
        for name in record.aux_names:
            np.testing.assert_array_equal(one.aux[name], other.aux[name])


def test_names_units_and_separators_by_option_give_the_same_record(tmp_path: Path) -> None:
    path = tmp_path / "log.txt"
    rows = (f"{k:.3f} {float(u / 1000)!r} {float(y * 1000)!r}" for k, u, y in zip(K, U_V, Y_UM, strict=True))
    path.write_text("\n".join(["t U pos", *rows]))
    text = "time=t,time_unit=ms,voltage=U,voltage_unit=kV,displacement=pos,displacement_unit=nm,separator=space"
    record = load_record(path, Columns.from_text(text))
    assert record.Ts_s == 1e-3
    # u/1000*1000 and y*1000/1000 round twice: two units in the last place.
    np.testing.assert_allclose(record.segments[0].u_V, U_V, rtol=5e-16)
    np.testing.assert_allclose(record.segments[0].y_um, Y_UM, rtol=5e-16)


@pytest.mark.parametrize(("rate_Hz", "decimals"), [(750, 11), (44100, 6), (50000, 6), (6400, 8), (200, 3), (3, 6)])
def test_period_is_the_exact_one_behind_rounded_stamps(rate_Hz: int, decimals: int, tmp_path: Path) -> None:
    path = tmp_path / "record.csv"
    k = np.arange(2000)
    rows = (f"{j / rate_Hz:.{decimals}f},{np.sin(j / 50):.6f},{np.sin(j / 50 - 0.1):.6f}" for j in k)
    path.write_text("\n".join([HEADER, *rows]))
    assert load_record(path).Ts_s == 1 / rate_Hz


def test_further_numeric_columns_are_channels_and_can_be_chosen_and_renamed(tmp_path: Path) -> None:
    path = tmp_path / "record.csv"
    lines = record_csv(SOUND).splitlines()
    path.write_text(
        "\n".join(f"{line},{'temp' if k == 0 else k},{'x2' if k == 0 else -k}" for k, line in enumerate(lines))
    )
    assert load_record(path).aux_names == ("temp", "x2")
    assert load_record(path, Columns(aux=())).aux_names == ()
    chosen = load_record(path, Columns.from_text("aux=axis2=x2"))
    assert chosen.aux_names == ("axis2",)
    np.testing.assert_array_equal(chosen.segments[0].aux["axis2"], -1.0 - K)


def test_selection_makes_realisations_and_periods_segments(tmp_path: Path) -> None:
    path = tmp_path / "record.npz"
    noise = np.random.default_rng(1).normal(size=(2, 50, 3, 4, 2)).astype(np.float32)
    np.savez(path, u=noise[0], y=noise[1], fs_Hz=6400.0)
    columns = Columns.from_text("voltage=u[:,1,:,:],displacement=y[10:,1,:,:],aux=other=u[:,2,:,:]")
    with pytest.raises(RecordError, match=r"y\[10:,1,:,:\] has 40 samples, u\[:,1,:,:\] has 50"):
        load_record(path, columns)
    record = load_record(path, Columns.from_text("voltage=u[:,1,:,:],displacement=y[:,1,:,:],aux=other=u[:,2,:,:]"))
    assert record.Ts_s == 1 / 6400
    assert [one.name for one in record.segments] == ["0,0", "0,1", "1,0", "1,1", "2,0", "2,1", "3,0", "3,1"]
    np.testing.assert_array_equal(record.segments[3].y_um, noise[1][:, 1, 1, 1].astype(np.float64))
    np.testing.assert_array_equal(record.segments[6].aux["other"], noise[0][:, 2, 3, 0].astype(np.float64))
    part = load_record(path, Columns.from_text("voltage=u[5:15,1,-1,0],displacement=y[5:15,1,-1,0]"))
    np.testing.assert_array_equal(part.segments[0].u_V, noise[0][5:15, 1, 3, 0].astype(np.float64))


def test_structures_and_groups_are_reached_by_path_or_by_a_name_that_stands_once(tmp_path: Path) -> None:
    inner = {"voltage_V": U_V, "displacement_um": Y_UM, "time_s": K * 1e-3, "note": "warm"}
    scipy.io.savemat(tmp_path / "one.mat", {"log": inner, "gain": 3.0})
    scipy.io.savemat(tmp_path / "two.mat", {"a": inner, "b": inner})
    assert load_record(tmp_path / "one.mat").digest == SOUND.digest
    two = load_record(tmp_path / "two.mat")
    assert [one.name for one in two.segments] == ["a", "b"]
    with pytest.raises(RecordError, match="no voltage array 'voltge_V'"):
        load_record(tmp_path / "two.mat", Columns(voltage="voltge_V"))
    columns = Columns.from_text("time=b/time_s,voltage=b/voltage_V,displacement=b/displacement_um")
    assert load_record(tmp_path / "two.mat", columns).digest == SOUND.digest


def test_axes_of_matlab_v73_read_as_in_matlab(tmp_path: Path) -> None:
    path = tmp_path / "record.mat"
    in_matlab = np.stack([U_V, Y_UM], axis=1)  # 60 by 2
    with h5py.File(path, "w") as file:
        file["log"] = in_matlab.T
        file["log"].attrs["MATLAB_class"] = np.bytes_("double")
    columns = Columns.from_text("voltage=log[:,0],displacement=log[:,1],Ts_s=1e-3")
    assert load_record(path, columns).digest == SOUND.digest


def test_several_files_are_several_segments_named_after_them(tmp_path: Path) -> None:
    as_csv(tmp_path / "up", SOUND)
    as_npz(tmp_path / "down", SOUND)
    record = load_record([tmp_path / "up.csv", tmp_path / "down.npz"])
    assert [one.name for one in record.segments] == ["up", "down"]
    assert record.source == "up.csv, down.npz"
    assert record.digest == Record.joined(SOUND, SOUND).digest != SOUND.digest
    slow = Record.from_arrays(U_V, Y_UM, 2e-3)
    as_csv(tmp_path / "slow", slow)
    with pytest.raises(RecordError, match=r"slow\.csv: sampled every 0\.002 s, but up\.csv every 0\.001 s"):
        load_record([tmp_path / "up.csv", tmp_path / "slow.csv"])


def test_gaps_can_start_segments(tmp_path: Path) -> None:
    path = tmp_path / "record.csv"
    lines = record_csv(SOUND).splitlines()
    path.write_text("\n".join(lines[:21] + lines[31:]))
    record = load_record(path, split_at_gaps=True)
    assert [(one.name, one.samples) for one in record.segments] == [("0.0", 20), ("0.1", 30)]
    assert record.segments[1].start_s == pytest.approx(0.03, abs=1e-15)
    np.testing.assert_array_equal(record.segments[1].u_V, U_V[30:])
