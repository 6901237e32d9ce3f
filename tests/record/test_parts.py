"""Cutting and joining of records: rows, initial states and digests."""

import numpy as np
import pytest

from hysgen.record import Record, Segment

RNG = np.random.default_rng(11)


def record(samples: int, start_s: float = 0.0, Ts_s: float = 1e-3, **aux: np.ndarray) -> Record:
    return Record.from_segments([Segment("0", RNG.normal(size=samples), RNG.normal(size=samples), aux, start_s)], Ts_s)


def rows_of(*records: Record) -> np.ndarray:
    return np.concatenate([np.stack([one.u_V, one.y_um], axis=1) for part in records for one in part.segments])


WHOLE = Record.joined(record(20), record(30, start_s=5.0), record(7))


@pytest.mark.parametrize("row", [1, 19, 20, 21, 49, 50, 56])
def test_split_keeps_every_row_in_order_and_cuts_segments_only_there(row: int) -> None:
    first, second = WHOLE.split_at(row)
    np.testing.assert_array_equal(rows_of(first, second), rows_of(WHOLE))
    assert (first.samples, second.samples) == (row, 57 - row)
    ends = np.cumsum([one.samples for one in (*first.segments, *second.segments)])
    assert set(ends) == {20, 50, 57} | {row}


def test_digest_changes_with_a_bit_a_cut_a_period_and_a_name_and_with_nothing_else() -> None:
    u_V, y_um, aux = RNG.normal(size=(3, 20))
    base = Record.from_arrays(u_V, y_um, 1e-3, {"a": aux})
    flipped = u_V.copy()
    flipped[7] = np.nextafter(flipped[7], np.inf)
    others = [
        Record.from_arrays(flipped, y_um, 1e-3, {"a": aux}),
        Record.from_arrays(y_um, u_V, 1e-3, {"a": aux}),
        Record.from_arrays(u_V, y_um, 2e-3, {"a": aux}),
        Record.from_arrays(u_V, y_um, 1e-3, {"b": aux}),
        Record.from_arrays(u_V, y_um, 1e-3),
        Record.joined(*base.split_at(10)),
    ]
    assert len({base.digest, *(other.digest for other in others)}) == 7
    same = [
        Record.from_arrays(u_V.tolist(), y_um.astype(">f8"), 1e-3, {"a": aux}, source="x.csv"),
        Record.from_segments([Segment("up", u_V, y_um, {"a": aux}, start_s=3.0)], 1e-3),
        Record.from_arrays(np.repeat(u_V, 2)[::2], y_um, 1e-3, {"a": aux}),
    ]
    assert {base.digest} == {one.digest for one in same}


def test_record_does_not_change_with_the_arrays_it_was_made_of() -> None:
    u_V, y_um = RNG.normal(size=(2, 20))
    whole = Record.from_arrays(u_V, y_um, 1e-3)
    direct = Segment("0", u_V, y_um)
    kept = u_V[3]
    u_V[3] = 99.0
    assert whole.segments[0].u_V[3] == direct.u_V[3] == kept
    for segment in (whole.segments[0], whole.rows(2, 9).segments[0]):
        with pytest.raises(ValueError, match="read-only"):
            segment.y_um[0] = 1.0


def test_joining_keeps_common_channels_and_warns_about_the_others() -> None:
    a, b = RNG.normal(size=(2, 9))
    joined = Record.joined(record(9, a=a, b=b), record(9, b=b))
    assert joined.aux_names == ("b",)
    assert joined.warnings == ("arrays: channel a is left out because segment 0 lacks it; add it there to use it",)
