"""A segment: one unbroken run of samples, with what is known of the time before; what several of them share."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hysgen.display import OWN, Quantities
from hysgen.errors import RecordError


def index_of(row: int) -> str:
    """The position of a row of an array in an error message."""
    return f"index {row}"


@dataclass(frozen=True, eq=False)
class Origin:
    """Where a segment was read: the file, the names of its columns, and a row as messages name it ("line 12")."""

    source: str = ""
    time: str = "time_s"
    voltage: str = "voltage_V"
    displacement: str = "displacement_um"
    locate: Callable[[int], str] = index_of

    def at(self, row: int) -> str:
        """File and row, with which a message begins."""
        return f"{self.source}: {self.locate(row)}"


def part_of(source: str) -> tuple[str, int]:
    """The whole and the first row of a part of a source, as `a.csv[20:80]`."""
    part = re.fullmatch(r"(.*)\[(\d+):\d+\]", source)
    return (part[1], int(part[2])) if part else (source, 0)


NO_STAMPS: NDArray[np.float64] = np.zeros(0)
NO_STAMPS.setflags(write=False)
ARRAYS = Origin()


@dataclass(frozen=True, eq=False)
class Segment:
    """One unbroken run of samples with an unknown initial state of its own.

    name: label of the run, for messages.
    u_V, y_um: (n,) applied voltage in V and measured displacement in um, float64, read-only.
    aux: further channels by name, each (n,), in the units of the file; sorted by name.
    start_s: time stamp of the first sample in s.
    past: the samples right before the first, of a segment that was cut; a simulation runs through them, and nothing
        is fitted to them or scored on them. None if nothing is known of the time before the first sample.
    quantities: what stands in u_V and y_um, if not a voltage and a displacement.
    stamps_s, origin: time stamps as the file has them, (n,) or (0,), and the names for messages, both only while a
        file is read; a record has its period instead.

    Raises RecordError if a channel is not one-dimensional or the lengths differ.
    """

    name: str
    u_V: NDArray[np.float64]
    y_um: NDArray[np.float64]
    aux: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)
    start_s: float = 0.0
    past: Segment | None = None
    quantities: Quantities = OWN
    stamps_s: NDArray[np.float64] = field(default_factory=lambda: NO_STAMPS)
    origin: Origin = ARRAYS

    def __post_init__(self) -> None:
        u_V = _channel(self.u_V, "voltage", self.name)
        object.__setattr__(self, "u_V", u_V)
        object.__setattr__(self, "y_um", _channel(self.y_um, "displacement", self.name))
        # Sorted, because HDF5 files do not store the order of the channels.
        aux = {key: _channel(self.aux[key], key, self.name) for key in sorted(self.aux)}
        object.__setattr__(self, "aux", aux)
        object.__setattr__(self, "stamps_s", _channel(self.stamps_s, self.origin.time, self.name))
        stamps = ((self.origin.time, self.stamps_s),) if self.stamps_s.size else ()
        for key, values in (*stamps, *self.channels()):
            if values.size != u_V.size:
                raise RecordError(
                    f"{self.origin.source or f'segment {self.name}'}: {key} has {values.size} samples, "
                    f"{self.origin.voltage} has {u_V.size}; give every channel one per sample, or leave the channel out"
                )

    @property
    def samples(self) -> int:
        """Number of samples n."""
        return int(self.u_V.size)

    @property
    def past_samples(self) -> int:
        """Number of known samples before the first."""
        return self.past.past_samples + self.past.samples if self.past is not None else 0

    def channels(self) -> Iterator[tuple[str, NDArray[np.float64]]]:
        """Every channel with its name in the file."""
        yield from ((self.origin.voltage, self.u_V), (self.origin.displacement, self.y_um), *self.aux.items())

    def whole(self) -> Segment:
        """The segment with its past as samples of its own."""
        if self.past is None:
            return self
        parts = [self.past.whole(), self]
        return Segment(
            name=self.name,
            u_V=np.concatenate([part.u_V for part in parts]),
            y_um=np.concatenate([part.y_um for part in parts]),
            aux={key: np.concatenate([part.aux[key] for part in parts]) for key in self.aux},
            start_s=parts[0].start_s,
            quantities=self.quantities,
        )

    def raised(self, level_um: float) -> Segment:
        """The segment and its past with `level_um` added to the displacement."""
        past = None if self.past is None else self.past.raised(level_um)
        return replace(self, y_um=self.y_um + level_um, past=past)

    def rows(self, start: int, stop: int, Ts_s: float) -> Segment:
        """Samples start..stop-1 as a segment of its own, whose past are the samples before; views, not copies."""
        past = self.rows(0, start, Ts_s) if start > 0 else self.past
        return replace(self.part(start, stop), start_s=self.start_s + start * Ts_s, past=past, origin=self.origin)

    def part(self, start: int, stop: int, name: str = "") -> Segment:
        """Samples start..stop-1 without a past; views, not copies. Messages still name the rows of the file."""
        return replace(
            self,
            name=name or self.name,
            u_V=self.u_V[start:stop],
            y_um=self.y_um[start:stop],
            aux={key: values[start:stop] for key, values in self.aux.items()},
            past=None,
            stamps_s=self.stamps_s[start:stop],
            origin=replace(self.origin, locate=lambda row: self.origin.locate(start + row)) if start else self.origin,
        )


def with_common_channels(segments: Sequence[Segment]) -> tuple[tuple[Segment, ...], list[str]]:
    """The segments with the further channels that all of them have, and a line for each removed channel."""
    shared = [key for key in segments[0].aux if all(key in segment.aux for segment in segments)]
    if all(len(segment.aux) == len(shared) for segment in segments):
        return tuple(segments), []
    lines = []
    for key in dict.fromkeys(key for segment in segments for key in segment.aux if key not in shared):
        lacking = next(segment.name for segment in segments if key not in segment.aux)
        lines.append(f"channel {key} is left out because segment {lacking} lacks it; add it there to use it")
    return tuple(_with_aux(segment, shared) for segment in segments), lines


def digest_of(segments: Sequence[Segment], Ts_s: float) -> str:
    """SHA-256 over names and little-endian float64 bytes of all channels, segment by segment, and Ts.

    Ts enters with 9 digits, because a period read back from rounded time stamps is not exact beyond that.
    """
    state = hashlib.sha256(f"hysgen record 1\nTs_s {Ts_s:.9g}\n".encode())
    for segment in segments:
        channels = {"u_V": segment.u_V, "y_um": segment.y_um}
        channels.update((f"aux {key}", values) for key, values in segment.aux.items())
        for key, values in channels.items():
            state.update(f"{key} {values.size}\n".encode())
            # Adding 0.0 turns -0.0 into 0.0: text formats may lose the sign.
            state.update((values + 0.0).astype("<f8").tobytes())
    return state.hexdigest()


def series_of(source: str, name: str, values: ArrayLike) -> NDArray[np.float64]:
    """`values` as float64 of shape (n,). Raises RecordError if they are not real numbers in one dimension."""
    array = np.asarray(values)
    if array.dtype.kind not in "fiub":
        raise RecordError(f"{source}: {name} holds {array.dtype}, not real numbers; give float values")
    if array.ndim == 2 and 1 in array.shape and array.size > 1:
        array = array.ravel()  # a column of MATLAB or of a DataFrame
    if array.ndim != 1:
        raise RecordError(f"{source}: {name} has shape {array.shape}; give a one-dimensional array")
    return array.astype(np.float64)


def _channel(values: ArrayLike, field_name: str, segment: str) -> NDArray[np.float64]:
    array = np.ascontiguousarray(values, dtype=np.float64)
    if array.ndim != 1:
        raise RecordError(f"segment {segment}: {field_name} has shape {array.shape}; give a one-dimensional array")
    if array.flags.writeable:
        # A copy, because the caller may modify this array later.
        array = array.copy()
        array.setflags(write=False)
    return array


def _with_aux(segment: Segment, names: Collection[str]) -> Segment:
    """The segment and its past with these further channels only."""
    past = None if segment.past is None else _with_aux(segment.past, names)
    return replace(segment, aux={key: segment.aux[key] for key in names}, past=past)
