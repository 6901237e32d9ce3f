"""Running a model over a record or over arrays: one step ahead, error against the horizon, and free run.

    one step    y^(k+1) = f(y(k), u(k)) + w(k)        from the measured y(k); small errors, since y(k+1) is near y(k)
    horizon h   y^(k+h) by h steps, the first from the measured y(k)
    free run    y^(k+1) = f(y^(k), u(k)) + w(k)       from the measured y(0) alone: the error of a simulation

Inputs outside the model's range and displacements outside its grid are clamped and counted.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hysgen.errors import ModelError, RecordError
from hysgen.machine import kernels
from hysgen.machine.kernels import Rules
from hysgen.model.disturbances import Drive
from hysgen.model.part import to_plain
from hysgen.model.path import applied
from hysgen.model.regression import Starts, drives_of, structure_of, term_output
from hysgen.record import Record, Segment

if TYPE_CHECKING:
    from hysgen.model.model import Model


Floats = NDArray[np.float64]

STEPS_PER_DECADE = 2_000_000
"""Largest number of model steps per decade of a horizon curve and segment; it sets the distance of the starts."""


@dataclass(frozen=True)
class ModelOutput:
    """A model's output over one segment: y_um (n,), and the numbers of clamped samples of y and of u."""

    y_um: Floats
    y_clamped: int
    u_clamped: int


@dataclass(frozen=True)
class HorizonCurve:
    """Error over the horizon: for each number of steps the rms and largest error in um, and the number of starts."""

    steps: tuple[int, ...]
    rms_um: tuple[float, ...]
    largest_um: tuple[float, ...]
    starts: tuple[int, ...]

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return to_plain(self)


def rules_of(model: Model) -> Rules:
    """The rules of `model` as arguments of the kernels."""
    return Rules(structure_of(model).range_um, model.consequents)


def simulate(model: Model, drive: Drive, y0_um: float) -> ModelOutput:
    """Free run from y(0) = y0 under any input.

    drive.u_V is the command: it is clamped to the model's range and passed through its blocks.
    """
    u_V = np.clip(drive.u_V, model.u_min_V, model.u_max_V)
    w = applied(model.blocks, u_V, drive.Ts_s, model.w_range, drive.start, drive.aux)
    arriving = dataclasses.replace(drive, u_V=np.ascontiguousarray(w))
    y_um, y_clamped = kernels.free_run(rules_of(model), arriving.u_V, term_output(model, arriving), y0_um)
    return ModelOutput(y_um, y_clamped, int(np.count_nonzero(u_V != drive.u_V)))


def free_run(
    model: Model, record: Record, starts: Starts | None = None, follow_drift: bool = False
) -> tuple[ModelOutput, ...]:
    """One free run per segment, started at its first measured displacement, or at that of its known past.

    starts: states of the terms before each segment, where they are known.
    follow_drift: let a drift term use past measured samples; state this beside the score.
    Raises RecordError if the record's sampling period is not the model's.
    """
    runs = []
    for part in _driven(model, record, starts):
        w_um = part.w_um + (part.bias_um if follow_drift else part.bias_um[0])
        y_um, y_clamped = kernels.free_run(rules_of(model), part.drive.u_V, w_um, float(part.segment.y_um[0]))
        runs.append(part.output(model, y_um, y_um, y_clamped))
    return tuple(runs)


def one_step(model: Model, record: Record, starts: Starts | None = None) -> tuple[ModelOutput, ...]:
    """One run per segment: sample k+1 predicted from measured y(k) and u(k); sample 0 is the measured one.

    Raises RecordError if the record's sampling period is not the model's.
    """
    runs = []
    for part in _driven(model, record, starts):
        w_um = part.w_um + part.bias_um
        y_um, y_clamped = kernels.one_step(rules_of(model), part.drive.u_V, w_um, part.segment.y_um)
        runs.append(part.output(model, y_um, part.segment.y_um, y_clamped))
    return tuple(runs)


def horizon_curve(
    model: Model,
    record: Record,
    steps: Sequence[int] | None = None,
    starts: Starts | None = None,
    first: int = 0,
    unscored: Sequence[int] | None = None,
) -> HorizonCurve:
    """Error over the horizon in all segments; a drift term keeps its value at each start.

    steps: rising numbers of samples; by default 1, 2, 5, 10, ... up to a quarter of the shortest segment.
    first: rows before it move the states of the terms but are not scored. unscored: rows at the start of each segment
        that are not scored either.
    Raises RecordError if a segment is shorter than the longest horizon or the sampling period is not the model's.
    """
    ends = np.cumsum([segment.samples for segment in record.segments])
    scored = [
        min(max(int(end) - first, 0), segment.samples - unscored_rows)
        for end, segment, unscored_rows in zip(ends, record.segments, unscored or [0] * len(ends), strict=True)
    ]
    shortest = min((count for count in scored if count), default=0)
    horizons = np.array(sorted(set(steps)) if steps else default_horizons(shortest), dtype=np.int64)
    if horizons[0] < 1 or horizons[-1] >= shortest:
        raise RecordError(
            f"{record.source}: a horizon of {horizons[-1]} samples needs longer segments than {shortest}; choose less"
        )
    square, largest = np.zeros(horizons.size), np.zeros(horizons.size)
    count = np.zeros(horizons.size, dtype=np.int64)
    decade = np.array([len(str(step)) for step in horizons])
    for part, rows in zip(_driven(model, record, starts), scored, strict=True):
        begin = part.segment.samples - rows
        for group in (decade == value for value in np.unique(decade)):
            stride = max(1, -(-rows * int(horizons[group][-1]) // STEPS_PER_DECADE))
            sums = kernels.horizon_errors(
                rules_of(model),
                kernels.HorizonInputs(
                    part.drive.u_V[begin:], part.w_um[begin:], part.bias_um[begin:], part.segment.y_um[begin:]
                ),
                stride,
                horizons[group],
            )
            square[group] += sums[0]
            largest[group] = np.maximum(largest[group], sums[1])
            count[group] += sums[2]
    rms = np.sqrt(square / count)
    return HorizonCurve(*(tuple(column.tolist()) for column in (horizons, rms, largest, count)))


def default_horizons(samples: int) -> list[int]:
    """1, 2, 5, 10, 20, 50, ... up to a quarter of `samples`; at least 1."""
    decades = [digit * 10**power for power in range(8) for digit in (1, 2, 5)]
    return [step for step in decades if step == 1 or step <= samples // 4]


@dataclass(frozen=True)
class _Driven:
    """A segment with its past, what drives the model over it, w of its terms and the bias of its drift term, (n,) each.

    past: samples of the known past. u_clamped: later samples of the command outside the model's range.
    """

    segment: Segment
    drive: Drive
    w_um: Floats
    bias_um: Floats
    past: int
    u_clamped: int

    def output(self, model: Model, y_um: Floats, antecedent_um: Floats, y_clamped: int) -> ModelOutput:
        """The output after the past. antecedent_um: (n,) displacement that selects the rules; y_clamped: of all n."""
        early = antecedent_um[: self.past]
        before = np.count_nonzero((early < model.grid.y_min_um) | (early > model.grid.y_max_um))
        return ModelOutput(y_um[self.past :], y_clamped - int(before), self.u_clamped)


def _driven(model: Model, record: Record, starts: Starts | None) -> Iterator[_Driven]:
    if abs(record.Ts_s - model.Ts_s) > 1e-4 * model.Ts_s:
        raise RecordError(
            f"{record.source}: sampled every {record.Ts_s:g} s, but model {model.name} steps every {model.Ts_s:g} s; "
            "resample the record or fit a model at its rate"
        )
    record.require_quantities(model.quantities)
    steady = [term.kind for term in model.terms if not term.follows_measurements]
    following = [term.kind for term in model.terms if term.follows_measurements]
    whole = record.whole()
    drives = drives_of(whole, structure_of(model), starts)
    for segment, drive, past in zip(whole.segments, drives, record.past_samples, strict=True):
        w_um = term_output(model, drive, steady)
        bias_um = np.zeros_like(w_um)
        if following:
            predicted, _ = kernels.one_step(rules_of(model), drive.u_V, w_um, segment.y_um)
            informed = dataclasses.replace(drive, innovation_um=segment.y_um - predicted)
            bias_um = term_output(model, informed, following)
        u_V = segment.u_V[past:]
        outside = int(np.count_nonzero((u_V < model.u_min_V) | (u_V > model.u_max_V)))
        yield _Driven(segment, drive, w_um, bias_um, past, outside)


REST_S, LEAST_REST = 0.05, 2000
"""Seconds, and samples at least, under the first voltage before a simulation without a starting point."""


def simulated_array(
    model: Model, u_V: ArrayLike, y0_um: float | None = None, channels: Mapping[str, ArrayLike] | None = None
) -> Floats:
    """Displacement in um, (n,), of a free run under the voltages u_V, (n,): y(k) before u(k) acts.

    y0_um: displacement at sample 0; by default that at rest under u(0). channels: of the model's terms.
    Raises ModelError for an input that is no series of finite numbers, or for a missing channel.
    """
    u = series(u_V, "u_V")
    given = {name: series(values, name, u.size) for name, values in (channels or {}).items()}
    _need_channels(model, given)
    if y0_um is None:
        y0_um = rest_um(model, float(u[0]), {name: float(values[0]) for name, values in given.items()})
    return simulate(model, Drive(u, model.Ts_s, given), y0_um).y_um


def predicted_array(
    model: Model, y_um: ArrayLike, u_V: ArrayLike, channels: Mapping[str, ArrayLike] | None = None
) -> Floats:
    """One step ahead, in um, (n,): element k is the prediction of y(k) from the measured y(k-1) and u(k-1).

    Element 0 is y(0). Raises ModelError as `simulate` does.
    """
    u, y = series(u_V, "u_V"), series(y_um, "y_um")
    given = {name: series(values, name, u.size) for name, values in (channels or {}).items()}
    _need_channels(model, given)
    segment = Segment("0", u, series(y, "y_um", u.size), given, quantities=model.quantities)
    record = Record.from_segments([segment], model.Ts_s)
    return one_step(model, record)[0].y_um


def rest_um(model: Model, u_V: float, channels: Mapping[str, float]) -> float:
    """Displacement at rest under a voltage."""
    samples = max(LEAST_REST, round(REST_S / model.Ts_s))
    held = {name: np.full(samples, value) for name, value in channels.items()}
    middle = 0.5 * (model.grid.y_min_um + model.grid.y_max_um)
    return float(simulate(model, Drive(np.full(samples, u_V), model.Ts_s, held), middle).y_um[-1])


def series(values: ArrayLike, name: str, size: int | None = None) -> Floats:
    """Values as float64, (n,); a column (n, 1) is taken. Raises ModelError if they are no finite numbers."""
    try:
        array = np.squeeze(np.asarray(values, dtype=np.float64))
    except (TypeError, ValueError) as fault:
        raise ModelError(f"{name}: holds no numbers ({fault}); give an array of shape (n,)") from fault
    array = np.atleast_1d(array)
    if array.ndim != 1 or array.size < 2:
        raise ModelError(f"{name}: has shape {array.shape}; give an array of shape (n,), n >= 2")
    if size is not None and array.size != size:
        raise ModelError(f"{name}: has {array.size} samples, the voltage {size}; give as many")
    if not np.isfinite(array).all():
        row = int(np.argmin(np.isfinite(array)))
        raise ModelError(f"{name}: index {row} is {array[row]}; give finite numbers")
    return array


def _need_channels(model: Model, given: Mapping[str, Floats]) -> None:
    for channel in model.channels:
        if channel not in given:
            raise ModelError(f"{model.name}: needs the channel {channel}; give channels={{{channel!r}: values}}")
