"""Cutting into runs, tables of text and of MATLAB: rows by hand, and both sides of the limits between two readings."""

import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hysgen.errors import RecordError
from hysgen.record.columns import Columns
from hysgen.record.csv_text import read_csv, write_csv
from hysgen.record.formats import FileArrays, Text
from hysgen.record.formats.hdf5 import read_tables
from hysgen.record.runs import at_gaps, runs_of_arrays, shifted
from hysgen.record.segment import NO_STAMPS, Origin, Segment

N = 12
K = np.arange(float(N))


ORIGIN = Origin("f", "t", "u", "y", lambda row: f"line {row + 2}")


def run(time_s: np.ndarray = K) -> Segment:
    return Segment("0", K, 10.0 + K, {"x": K**2}, stamps_s=time_s, origin=ORIGIN)


def rows(made: Segment) -> tuple[list[float], list[float], list[float]]:
    return made.stamps_s.tolist(), made.u_V.tolist(), made.y_um.tolist()


def test_a_cut_run_has_its_rows_and_says_those_of_the_file() -> None:
    cut = run().part(3, 6, "a")
    assert (cut.name, rows(cut)) == ("a", ([3.0, 4.0, 5.0], [3.0, 4.0, 5.0], [13.0, 14.0, 15.0]))
    assert cut.aux["x"].tolist() == [9.0, 16.0, 25.0]
    assert cut.origin.locate(1) == "line 6"
    assert cut.part(1, 3, "b").origin.locate(0) == "line 6"
    assert run(NO_STAMPS).part(3, 6, "a").stamps_s.size == 0


def test_a_shift_pairs_later_or_earlier_rows_until_none_is_left() -> None:
    later, earlier = shifted(run(), 2), shifted(run(), -3)
    assert rows(later) == (K[2:].tolist(), K[2:].tolist(), (10 + K[:-2]).tolist())
    assert rows(earlier) == (K[:-3].tolist(), K[:-3].tolist(), (10 + K[3:]).tolist())
    assert rows(shifted(run(), 0)) == rows(run())
    assert rows(shifted(run(), N - 1))[1] == [N - 1.0]
    for far in (N, -N):
        with pytest.raises(RecordError, match=f"shift={far} leaves no row of {N}"):
            shifted(run(), far)


def test_gaps_part_a_run_and_a_run_without_time_is_whole() -> None:
    gap = np.where(K < 5, K, K + 20.0)
    parts = list(at_gaps(run(gap)))
    assert [(part.name, len(part.u_V)) for part in parts] == [("0.0", 5), ("0.1", 7)]
    assert [part.name for part in at_gaps(run())] == ["0"]
    assert [len(part.u_V) for part in at_gaps(run(NO_STAMPS))] == [N]
    assert len(list(at_gaps(run().part(0, 1)))) == 1


def table(columns: dict[str, np.ndarray], starts: tuple[int, ...] = ()) -> FileArrays:
    return FileArrays(columns, names=tuple(columns), locate=lambda row: f"line {row + 2}", starts=starts)


CHOSEN = Columns(time="t", voltage="u", displacement="y")


def test_a_header_that_stands_again_parts_a_run_unless_the_time_goes_on() -> None:
    columns = {"t": K, "u": K, "y": K}
    assert len(runs_of_arrays("f", table(columns, (5,)), CHOSEN)) == 1
    again = {**columns, "t": np.concatenate([K[:5], K[:7]])}
    parts = runs_of_arrays("f", table(again, (5,)), CHOSEN)
    assert [(part.name, len(part.u_V)) for part in parts] == [("0", 5), ("1", 7)]
    period = Columns(time="", voltage="u", displacement="y", Ts_s=1.0)
    assert len(runs_of_arrays("f", table({"u": K, "y": K}, (5,)), period, 1.0)) == 2


def test_segment_numbers_part_a_run_and_come_back_to_no_earlier_one() -> None:
    numbers = np.repeat([1.0, 2.5, 7.0], 4)
    columns = {"t": K, "u": K, "y": K, "segment": numbers}
    parts = runs_of_arrays("f", table(columns), CHOSEN)
    assert [(part.name, part.u_V[0]) for part in parts] == [("1", 0.0), ("2.5", 4.0), ("7", 8.0)]
    assert "segment" not in parts[0].aux
    with pytest.raises(RecordError, match="has no segment column 'part'"):
        runs_of_arrays("f", table(columns), replace(CHOSEN, segment="part"))
    columns["segment"] = np.repeat([1.0, 2.0, 1.0], 4)
    with pytest.raises(RecordError, match="line 10: segment 1 comes back after another"):
        runs_of_arrays("f", table(columns), CHOSEN)
    columns["segment"][3] = np.nan
    with pytest.raises(RecordError, match="line 5: segment is nan; number every row"):
        runs_of_arrays("f", table(columns), CHOSEN)


def test_arrays_of_two_groups_are_two_runs_and_lengths_agree() -> None:
    groups: dict[str, Any] = {f"{g}/{name}": K + g for g in (1, 2) for name in ("t", "u", "y", "more")}
    groups["Ts"] = np.array([1.0])
    found = runs_of_arrays("f", FileArrays(groups), CHOSEN)
    assert [(one.name, one.u_V[0], one.aux["more"][0]) for one in found] == [("1", 1, 1), ("2", 2, 2)]
    with pytest.raises(RecordError, match="t has 11 samples, u has 12; give every channel one per sample"):
        runs_of_arrays("f", FileArrays({"t": K[:-1], "u": K, "y": K}), CHOSEN)
    numbered = runs_of_arrays("f", FileArrays({"t": K, "u": K, "y": K, "segment": np.repeat([4.0, 5.0], 6)}), CHOSEN)
    assert [one.name for one in numbered] == ["4", "5"]
    with pytest.raises(RecordError, match="segment has 11 samples, u has 12"):
        runs_of_arrays("f", FileArrays({"t": K, "u": K, "y": K, "segment": np.ones(11)}), CHOSEN)
    two = Columns(time="", voltage="u[:,:]", displacement="y", Ts_s=1.0)
    with pytest.raises(RecordError, match=r"selects \d+ series and 'y' 1; select the same segments from both"):
        runs_of_arrays("f", FileArrays({"u": np.stack([K, K]), "y": K}), two, 1.0)


# Text


def text(*lines: str) -> Text:
    return Text(("\n".join(lines) + "\n").encode())


def test_numbers_are_written_so_that_they_read_back() -> None:
    made = write_csv({"a": [0.1, 1e-300], "b": [2.0, -3.5]})
    assert made == "a,b\n0.1,2.0\n1e-300,-3.5\n"
    assert write_csv({"a": [1.0]}) == "a\n1.0\n"


@pytest.mark.parametrize(("last", "kept", "said"), [("3,4,5", 4, False), ("3,4", 3, True), ("3", 3, True)])
def test_a_last_line_cut_short_is_left_out_and_a_whole_one_is_not(last: str, kept: int, said: bool) -> None:
    data = text("time_s,voltage_V,displacement_um", "0,1,2", "1,2,3", "2,3,4", last)
    found, _ = read_csv("f", Text(data.data[:-1]), Columns())
    assert len(found.arrays["voltage_V"]) == kept
    assert any("cut short" in remark for remark in found.remarks) is said


@pytest.mark.parametrize(("apart", "same"), [(0.49, True), (0.51, False)])
def test_a_second_time_is_the_same_within_half_a_step(apart: float, same: bool) -> None:
    lines = [f"{k},{k % 5},{k + (apart if k == 3 else 0)},{k % 7}" for k in range(20)]
    data = text("time_s,voltage_V,time_s,displacement_um", *lines)
    if same:
        assert set(read_csv("f", data, Columns())[0].arrays) == {"time_s", "voltage_V", "displacement_um"}
    else:
        with pytest.raises(RecordError, match=r"differ by up to 0\.51: the channels were sampled at different times"):
            read_csv("f", data, Columns())


@pytest.mark.parametrize(("gap", "timed"), [(2.9, True), (3.4, False)])
def test_without_a_header_time_is_the_column_that_rises_evenly(gap: float, timed: bool) -> None:
    """A step of 3 times the mean is the largest; 19 steps, of which one is a gap."""
    times = np.cumsum(np.where(np.arange(20) == 10, gap * 18 / (19 - gap), 1.0))
    data = text(*(f"{5 - k % 3},{t:.6f},{k % 7}" for k, t in enumerate(times.tolist())))
    _, chosen = read_csv("f", data, Columns(Ts_s=None))
    assert (chosen.time == "1") is timed
    assert (chosen.voltage, chosen.displacement) == (("0", "2") if timed else ("0", "1"))


@pytest.mark.parametrize(("kinds", "refused"), [(1, False), (2, True), (9, True), (10, False)])
def test_a_column_that_names_what_each_row_holds_is_refused(kinds: int, refused: bool) -> None:
    lines = [f"{k},c{k % kinds},{k % 4}" for k in range(20)]
    with pytest.raises(RecordError) as fault:
        runs_of_arrays("f", *read_csv("f", text("time_s,channel,value", *lines), Columns()))
    assert ("names what each row holds (c0, c1" in str(fault.value)) is refused


def test_columns_of_words_are_left_out_with_a_remark_unless_channels_are_chosen() -> None:
    data = text("time_s,voltage_V,displacement_um,note,temp", "0,1,2,ok,20", "1,2,3,ok,21")
    found, _ = read_csv("f", data, Columns())
    assert set(found.arrays) == {"time_s", "voltage_V", "displacement_um", "temp"}
    assert [remark for remark in found.remarks if "note" in remark] == [
        "f: column note holds 'ok', not numbers, and is left out"
    ]
    assert read_csv("f", data, Columns.from_text("aux=temp"))[0].remarks == ()


# Tables of MATLAB


class Frame(dict[str, np.ndarray]):
    """The parts of a DataFrame that are read."""

    def __init__(self, index: np.ndarray, columns: dict[str, np.ndarray], **attrs: Any) -> None:
        super().__init__(columns)
        self.index, self.attrs = index, attrs

    @property
    def columns(self) -> list[str]:
        return list(self)


def tables(monkeypatch: pytest.MonkeyPatch, **content: Any) -> tuple[dict[str, Any], dict[str, str]]:
    library: Any = ModuleType("matio")
    library.load_from_mat = lambda path, add_table_attrs: content if add_table_attrs else {}
    monkeypatch.setitem(sys.modules, "matio", library)
    file = read_tables(Path("f.mat"))
    return dict(file.arrays), dict(file.units)


def test_a_timetable_gives_seconds_numbers_and_units(monkeypatch: pytest.MonkeyPatch) -> None:
    ms = np.array([5, 7, 9]).astype("timedelta64[ms]")
    columns = {"u": np.arange(1.0, 4.0), "name": np.array(["a", "b", "c"]), "late": ms, "on": np.array([True] * 3)}
    frame = Frame(ms, columns, varUnits=np.array(["V", "", " ms ", ""], dtype=object))
    arrays, units = tables(monkeypatch, t=frame, other=SimpleNamespace())
    assert {key: values.tolist() for key, values in arrays.items()} == {
        "t/Time": pytest.approx([5e-3, 7e-3, 9e-3]),
        "t/u": [1.0, 2.0, 3.0],
        "t/late": pytest.approx([5e-3, 7e-3, 9e-3]),
        "t/on": [True] * 3,
    }
    assert units == {"t/Time": "s", "t/u": "V", "t/late": "s"}
    dates = np.array(["2026-01-01T10:00:00", "2026-01-01T10:00:02"], dtype="datetime64[ns]")
    arrays, units = tables(monkeypatch, d=Frame(dates, {"y": np.array([1, 2])}, VariableUnits=["nm"]))
    assert (arrays["d/Time"].tolist(), units["d/y"]) == ([0.0, 2.0], "nm")
    plain, units = tables(monkeypatch, p=Frame(np.arange(2), {"y": np.array([1, 2])}))
    assert (list(plain), units) == (["p/y"], {})
    with pytest.raises(RecordError, match="its objects are no tables of numbers"):
        tables(monkeypatch, other=SimpleNamespace())
    monkeypatch.setitem(sys.modules, "matio", None)
    with pytest.raises(RecordError, match="pip install 'hysgen"):
        read_tables(Path("f.mat"))
