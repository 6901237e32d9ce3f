"""The measured record: segments of voltage and displacement at one sampling period."""

from __future__ import annotations

import importlib
import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hysgen.display import WRITTEN_IN, Displayed, Quantities, Summary
from hysgen.errors import RecordError
from hysgen.record.columns import Columns
from hysgen.record.runs import Content, checked, parts_of_frame
from hysgen.record.sampling import JITTER
from hysgen.record.segment import Origin, Segment, digest_of, part_of, series_of, with_common_channels
from hysgen.record.wrong_readings import are_frequent, bridged_segments, lines_of

LONGEST_PERIOD_S = 100.0
"""A longer sampling period is taken for a rate in Hz and refused."""

FAR_OFF = 10.0
"""Distance of a displacement from 0, in multiples of its range, from which on it stands on a constant of its own."""

SAME_PERIOD = 1e-4
"""Largest relative difference of two sampling periods that count as equal."""


@dataclass(frozen=True, eq=False, repr=False)
class Record(Displayed):
    """A measured record: one or more segments sampled at one period.

    segments: in the order of the file, or of the files.
    Ts_s: sampling period in s.
    source: file name(s) without folder, or "arrays".
    digest: SHA-256 of channels, segment lengths and Ts_s; independent of the file format.
    said: `warnings` as they are written for a voltage in V and a displacement in um.
    """

    segments: tuple[Segment, ...]
    Ts_s: float
    source: str
    digest: str
    said: tuple[str, ...] = ()

    @property
    def warnings(self) -> tuple[str, ...]:
        """Suspicious values that were not refused, one line each, in the quantities of the record."""
        return self.said if WRITTEN_IN.get().other else tuple(map(self.quantities.text, self.said))

    @classmethod
    def from_segments(
        cls, segments: Sequence[Segment], Ts_s: float, source: str = "arrays", warnings: Sequence[str] = ()
    ) -> Record:
        """A record of these segments, with its digest.

        Values are not checked: a part of a record may be constant. A channel that a segment lacks is removed from all
        segments, with a warning. Raises RecordError for no segment or for a sampling period that is not positive.
        """
        if not segments:
            raise RecordError(f"{source}: holds no samples; record at least one segment")
        if not (math.isfinite(Ts_s) and Ts_s > 0.0):
            raise RecordError(f"{source}: sampling period Ts_s = {Ts_s:g} s; give a positive number of seconds")
        kept, dropped = with_common_channels(segments)
        return cls(
            segments=kept,
            Ts_s=float(Ts_s),
            source=source,
            digest=digest_of(kept, Ts_s),
            said=(*warnings, *(f"{source}: {line}" for line in dropped)),
        )

    @classmethod
    def from_arrays(
        cls,
        u_V: ArrayLike,
        y_um: ArrayLike,
        Ts_s: float | None = None,
        aux: Mapping[str, ArrayLike] | None = None,
        source: str = "arrays",
        accept: Collection[str] = (),
        *,
        fs_Hz: float | None = None,
    ) -> Record:
        """A record of one segment "0" from arrays, after the same checks of values as for files.

        u_V, y_um: (n,) or (n, 1) in V and um. Ts_s or fs_Hz: sampling period or rate. aux: further channels, each (n,).
        accept: names of refusals ("constant", "saturation", "swapped") that become warnings.
        Raises RecordError with one line: source, index, channel, fault and cure.
        """
        if (Ts_s is None) == (fs_Hz is None):
            raise RecordError(f"{source}: give either Ts_s in seconds or fs_Hz in hertz")
        if Ts_s is None:
            Ts_s = 1.0 / fs_Hz if fs_Hz else math.nan
        if not (math.isfinite(Ts_s) and Ts_s > 0.0):
            raise RecordError(f"{source}: sampling period Ts_s = {Ts_s:g} s; give a positive number of seconds")
        named = {"voltage_V": u_V, "displacement_um": y_um, **(aux or {})}
        arrays = {name: series_of(source, name, values) for name, values in named.items()}
        run = Segment("0", arrays.pop("voltage_V"), arrays.pop("displacement_um"), arrays, origin=Origin(source))
        if Ts_s >= LONGEST_PERIOD_S:
            raise RecordError(
                f"{source}: Ts_s = {Ts_s:g} s; give the sampling period in s, {1.0 / Ts_s:g} for a rate of {Ts_s:g} Hz"
            )
        return cls.from_segments(*checked(source, Content([run], Columns(aux=()), (), Ts_s), JITTER, accept, False))

    @classmethod
    def from_dataframe(cls, frame: Any, columns: Columns | str | Mapping[str, Any] | None = None) -> Record:
        """A record of a pandas (or Polars) DataFrame; names of its columns are found as those of a file are.

        An index that is no plain count is read as a column too. columns: as for `load_record`.
        Raises RecordError as `load_record` does.
        """
        return cls.from_segments(*parts_of_frame(frame, columns))

    def to_dataframe(self) -> Any:
        """A pandas DataFrame with time_s, both quantities, the further channels, and segment if several.

        Raises RecordError without pandas.
        """
        try:
            pandas = importlib.import_module("pandas")
        except ModuleNotFoundError as fault:
            raise RecordError("pandas is not installed; pip install pandas to make a DataFrame") from fault
        return pandas.DataFrame(self.columns([part.name for part in self.segments]))

    def columns(self, names: Sequence[str | int]) -> dict[str, NDArray[Any]]:
        """time_s, both quantities, the further channels, and the names of the segments if several, each (n,)."""
        voltage, displacement = self.quantities.columns
        content: dict[str, NDArray[Any]] = {"time_s": self.time_s, voltage: self.u_V, displacement: self.y_um}
        content |= {name: np.concatenate([part.aux[name] for part in self.segments]) for name in self.aux_names}
        if len(self.segments) > 1:
            content["segment"] = np.repeat(names, [part.samples for part in self.segments])
        return content

    @property
    def u_V(self) -> NDArray[np.float64]:
        """(n,) voltage of all segments."""
        return np.concatenate([segment.u_V for segment in self.segments])

    @property
    def y_um(self) -> NDArray[np.float64]:
        """(n,) displacement of all segments."""
        return np.concatenate([segment.y_um for segment in self.segments])

    @property
    def time_s(self) -> NDArray[np.float64]:
        """(n,) time stamps of all segments; each segment starts at its own."""
        return np.concatenate([one.start_s + self.Ts_s * np.arange(one.samples) for one in self.segments])

    @property
    def quantities(self) -> Quantities:
        """What drives the stage and what it answers, with their units."""
        return self.segments[0].quantities

    def require_quantities(self, wanted: Quantities) -> None:
        """Raises RecordError if the record is of other quantities, or in other units, than a model or a record."""
        if self.quantities != wanted:
            both = (self.quantities, wanted)
            a, b = (f"'{q.input}' in '{q.input_unit}' and '{q.output}' in '{q.output_unit}'" for q in both)
            raise RecordError(
                f"{self.source}: holds {a}, not {b}; read it with --columns "
                f'"input={wanted.input} [{wanted.input_unit}],output={wanted.output} [{wanted.output_unit}]"'
            )

    @property
    def fs_Hz(self) -> float:
        """Sampling rate in Hz."""
        return 1.0 / self.Ts_s

    def __len__(self) -> int:
        return self.samples

    def __getitem__(self, rows: slice) -> Record:
        """`record[a:b]`: rows a..b-1; the rows before are their past. Raises RecordError for other indices."""
        if not isinstance(rows, slice) or rows.step not in (None, 1):
            raise RecordError(f"{self.source}: index a record by rows, as record[5000:10000]")
        start, stop, _ = rows.indices(self.samples)
        return self.rows(start, stop)

    @staticmethod
    def joined(*records: Record) -> Record:
        """Several records as one: all segments in order, each with its own initial state.

        Raises RecordError if the sampling periods differ by more than 1e-4 of their value.
        """
        if not records:
            raise RecordError("no record given; name at least one")
        first = records[0]
        for other in records[1:]:
            other.require_quantities(first.quantities)
            if abs(other.Ts_s - first.Ts_s) > SAME_PERIOD * first.Ts_s:
                raise RecordError(
                    f"{other.source}: sampled every {other.Ts_s:g} s, but {first.source} every {first.Ts_s:g} s; "
                    "resample one of them before joining"
                )
        return Record.from_segments(
            [segment for record in records for segment in record.segments],
            first.Ts_s,
            ", ".join(dict.fromkeys(record.source for record in records)),
            tuple(dict.fromkeys(line for record in records for line in record.said)),
        )

    def summary(self) -> Summary:
        """Table of the segments with their ranges."""
        rows = [
            [
                part.name,
                f"{part.samples}",
                f"{self.Ts_s * part.samples:.4g}",
                f"{part.u_V.min():.4g} .. {part.u_V.max():.4g}",
                f"{part.y_um.min():.4g} .. {part.y_um.max():.4g}",
            ]
            for part in self.segments
        ]
        channels = [f"further channels: {', '.join(self.aux_names)}"] if self.aux_names else []
        title = f"Record {self.source}: {self.samples} samples at {1e-3 / self.Ts_s:.4g} kHz"
        header = ["segment", "samples", "s", "voltage V", "displacement um"]
        return Summary(title, header, rows, [*channels, *(f"warning: {line}" for line in self.warnings)])

    def one_line(self) -> str:
        """Rate, duration, ranges and channels."""
        parts = f" in {len(self.segments)} segments" if len(self.segments) > 1 else ""
        (low_V, high_V), (low_um, high_um) = self.u_range_V, self.y_range_um
        channels = f", channels {', '.join(self.aux_names)}" if self.aux_names else ""
        ends = f"{low_um:.5g} .. {high_um:.5g} um"
        if self.level_um:
            ends = f"{low_um:.10g} um + 0 .. {high_um - low_um:.4g} um"
        return (
            f"{self.source}: {self.samples} samples{parts} at {1e-3 / self.Ts_s:.6g} kHz, "
            f"{self.Ts_s * self.samples:.4g} s, "
            f"{low_V:.4g} .. {high_V:.4g} V, {ends}{channels}"
        )

    @property
    def samples(self) -> int:
        """Number of samples in all segments."""
        return sum(segment.samples for segment in self.segments)

    @property
    def u_range_V(self) -> tuple[float, float]:
        """Smallest and largest voltage in V."""
        return _range(segment.u_V for segment in self.segments)

    @property
    def y_range_um(self) -> tuple[float, float]:
        """Smallest and largest displacement in um."""
        return _range(segment.y_um for segment in self.segments)

    @property
    def aux_ranges(self) -> dict[str, tuple[float, float]]:
        """Lowest and highest value of every further channel over all segments, in its own unit."""
        return {name: _range(segment.aux[name] for segment in self.segments) for name in self.aux_names}

    @property
    def aux_names(self) -> tuple[str, ...]:
        """Names of the further channels; every segment has all of them."""
        return tuple(self.segments[0].aux)

    def rows(self, start: int, stop: int) -> Record:
        """Rows start..stop-1 of the joined record. Segments keep their order; the first and last may be cut.

        A segment that is cut keeps the rows before its first as its past (`Segment.past`).
        Raises RecordError if no row is left or a bound lies outside 0..samples.
        """
        if not 0 <= start < stop <= self.samples:
            raise RecordError(
                f"{self.source}: rows {start}..{stop} asked for, the record has {self.samples}; "
                "choose 0 <= start < stop <= samples"
            )
        parts = []
        first = 0
        for segment in self.segments:
            low, high = max(start - first, 0), min(stop - first, segment.samples)
            if low < high:
                parts.append(segment.rows(low, high, self.Ts_s))
            first += segment.samples
        base, begin = part_of(self.source)
        return Record.from_segments(parts, self.Ts_s, f"{base}[{begin + start}:{begin + stop}]", self.said)

    def whole(self) -> Record:
        """The record with the past of every segment as samples of its own (`Segment.whole`)."""
        if all(segment.past is None for segment in self.segments):
            return self
        return self._of([segment.whole() for segment in self.segments])

    @property
    def level_um(self) -> float:
        """The constant on which the displacement stands: its least value if that is far beyond its range, else 0.

        Fits take it off: their priors and roundings are relative to the displacement, not to its range.
        """
        low, high = self.y_range_um
        return low if abs(low) > FAR_OFF * (high - low) else 0.0

    def raised(self, level_um: float) -> Record:
        """The record with `level_um` added to the displacement."""
        return self._of([segment.raised(level_um) for segment in self.segments])

    def _of(self, segments: Sequence[Segment], more: Sequence[str] = ()) -> Record:
        """The record with other segments, and more warnings."""
        return Record.from_segments(segments, self.Ts_s, self.source, (*self.said, *more))

    def without_wrong_readings(self, gated: bool = False) -> Record:
        """The record with its single wrong readings bridged (`wrong_readings`), and a line for each in its warnings.

        gated: a record with frequent ones stays as it is, for a diagnosis to judge.
        """
        segments, found = bridged_segments(self.segments, self.Ts_s)
        if gated and are_frequent([one.row for one in found if not one.voltage], self.samples):
            return self
        if all(new is old for new, old in zip(segments, self.segments, strict=True)):
            return self
        return self._of(segments, lines_of(self.source, found))

    @property
    def past_samples(self) -> tuple[int, ...]:
        """Number of known samples before the first of each segment."""
        return tuple(segment.past_samples for segment in self.segments)

    def split_at(self, row: int) -> tuple[Record, Record]:
        """The rows before `row`, and the rows from `row` on, whose past are the rows before.

        Raises RecordError if one of the parts would be empty.
        """
        return self.rows(0, row), self.rows(row, self.samples)

    def split(self, fraction: float) -> tuple[Record, Record]:
        """The first `fraction` (0..1) of the rows, and the rest. Raises RecordError if a part would be empty."""
        if not 0.0 < fraction < 1.0:
            raise RecordError(f"{self.source}: cannot be split at {fraction:g}; choose a fraction between 0 and 1")
        return self.split_at(round(fraction * self.samples))


def _range(channels: Iterator[NDArray[np.float64]]) -> tuple[float, float]:
    ends = [(float(values.min()), float(values.max())) for values in channels]
    return min(low for low, _ in ends), max(high for _, high in ends)
