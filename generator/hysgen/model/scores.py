"""Scores of a model on a record: one-step error, error over the horizon, and free-run error after the unknown past.

    e_rms  = sqrt(sum_k (y(k) - yhat(k))^2 / N)
    e_r    = max_k |y(k) - yhat(k)| / (max_k y(k) - min_k y(k)) * 100 %    over the record and its known past

The paper's "maximum e_r" (section 4) divides by max y, which depends on where the sensor has its zero; the paper's
records start at 0, where both are equal. The errors are shown with the one-step error of persistence, yhat(k+1) = y(k),
and with the noise floor: at high sampling rates the one-step error alone is small for any model.

Not scored are sample 0 of a segment, which is an input of the model, and the rows in which the unknown input before the
record matters (below).

A hysteresis keeps the extremes of the input before the record until later extremes wipe them out. Two runs of the block
bound its state: one after the lowest input of its range, one after the highest,

    d(k) = |h(k) after the highest - h(k) after the lowest|,   m(k) = max of d from k on

Two errors of the free run stand side by side: the cold one, of a model that knows nothing of the record before it, and
the model's own, without what no model can know (`remaining`).

d falls to zero where the record covers the range of the model. Where it does not, a part m(n-1) never falls: no row
to leave out lowers it, and it is part of the error.
"""

import dataclasses
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.display import Displayed, Summary, table
from hysgen.errors import RecordError
from hysgen.machine.processes import one_blas_thread
from hysgen.model.model import Model
from hysgen.model.path.hysteresis import Hysteresis
from hysgen.model.remaining import Named, Remaining, Taken, take_out
from hysgen.model.simulate import HorizonCurve, ModelOutput, free_run, horizon_curve, one_step
from hysgen.record import Record
from hysgen.record.excitation import FITTED_RECORD, Conditions, check_validation
from hysgen.record.noise import NoiseFloor, noise_floor

Floats = NDArray[np.float64]

LATEST = 0.8
"""Largest share of a segment that is left out: with more, too little is left for a score."""

ABOVE_NOISE, OF_SPAN = 2.0, 1e-3
"""A difference counts above this multiple of the noise floor, or above this share of the span if that is more."""


@dataclass(frozen=True)
class UnknownPast:
    """rows: at the start of each segment, in which the unknown past matters. later_um: what it may be after them."""

    rows: tuple[int, ...]
    later_um: float

    def describe(self, source: str, with_them_um: float) -> list[str]:
        """Lines for people; none if no row is left out. with_them_um: rms error of the free run with these rows."""
        lines = []
        if any(self.rows):
            lines.append(
                f"not scored: the first {', '.join(map(str, self.rows))} samples depend on the input before the "
                f"record, which is unknown; with them the free run is wrong by {with_them_um:.5f} um"
            )
        if self.later_um > 0.0:
            lines.append(
                f"{source}: the scored samples too depend on the input before the record, by up to {self.later_um:.2g} "
                "um: the record does not cover the range of the model"
            )
        return lines


def unknown_past(model: Model, record: Record, noise_um: float) -> UnknownPast:
    """The rows of a record in which the unknown past matters; none for a model without hysteresis.

    noise_um: noise floor of the record. A known past (`Segment.past`) takes the place of the first rows.
    """
    at = next((i for i, block in enumerate(model.blocks) if isinstance(block, Hysteresis)), None)
    if at is None:
        return UnknownPast((0,) * len(record.segments), 0.0)
    hysteresis = model.blocks[at]
    assert isinstance(hysteresis, Hysteresis)
    low_um, high_um = record.y_range_um
    least_um = max(ABOVE_NOISE * noise_um, OF_SPAN * (high_um - low_um))
    rows, later_um = [], 0.0
    for segment, past in zip(record.whole().segments, record.past_samples, strict=True):
        v_V = np.clip(segment.u_V, model.u_min_V, model.u_max_V)
        for block in model.blocks[:at]:
            v_V = block.apply(v_V, model.Ts_s)
        later = _largest_later(hysteresis, v_V)
        first = min(int(np.argmax(later <= later[-1] + least_um)), int(LATEST * v_V.size))
        rows.append(max(first - past, 0))
        later_um = max(later_um, float(later[max(first, past)]))
    return UnknownPast(tuple(rows), later_um if later_um > 2.0 * least_um else 0.0)


def _largest_later(hysteresis: Hysteresis, v_V: Floats) -> Floats:
    """m(k), (n,), of the inputs v_V of the block, (n,)."""
    low, high = (
        hysteresis.apply(np.concatenate([[end_V], v_V]), 1.0)[1:] for end_V in (hysteresis.low_V, hysteresis.high_V)
    )
    return np.asarray(np.maximum.accumulate(np.abs(high - low)[::-1])[::-1])


@dataclass(frozen=True)
class Score:
    """The error of one prediction of a record.

    e_rms_um; largest_um: max |y - yhat|; e_r_percent: largest_um relative to the stroke, the range of the displacement
    over the record and its known past; of_span_percent: e_rms relative to the stroke; None and 0 for a record of
    constant displacement. samples: number of scored samples.
    """

    e_rms_um: float
    largest_um: float
    e_r_percent: float | None
    of_span_percent: float
    samples: int

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return dataclasses.asdict(self)


@dataclass(frozen=True, repr=False)
class Scores(Displayed):
    """All scores of a model on a record.

    settle: samples at the start of each segment that the caller left out. unknown_past: samples that are left out
    because they depend on the unknown past; None if the caller chose `settle`. with_unknown_past_um: rms error of the
    free run with these samples.
    own: the free run without what no model can know before the record, `taken`.
    warnings: findings that put the scores in doubt, one line each; they are shown first.
    """

    model: str
    source: str
    digest: str
    settle: int
    one_step: Score
    free_run: Score
    own: Score
    persistence: Score
    horizon: HorizonCurve
    noise: NoiseFloor
    y_clamped: int
    u_clamped: int
    Ts_s: float
    unknown_past: UnknownPast | None = None
    with_unknown_past_um: float | None = None
    taken: tuple[Taken, ...] = ()
    warnings: tuple[str, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "model": self.model,
            "record": {"source": self.source, "digest": self.digest},
            "settle": self.settle,
            "unknown_past": None
            if self.unknown_past is None
            else {
                "samples": list(self.unknown_past.rows),
                "later_um": self.unknown_past.later_um,
                "free_run_rms_with_um": self.with_unknown_past_um,
            },
            "warnings": list(self.warnings),
            "one_step": self.one_step.to_json(),
            "free_run": self.free_run.to_json(),
            "own": self.own.to_json()
            | {"taken_out": [dataclasses.asdict(p) | {"rows": list(p.rows)} for p in self.taken]},
            "persistence_one_step": self.persistence.to_json(),
            "horizon": self.horizon.to_json(),
            "noise_floor": self.noise.to_json(),
            "clamped": {"y": self.y_clamped, "u": self.u_clamped},
            "unit": "um",
        }

    def summary(self) -> Summary:
        """Table of the scores, with noise floor, horizon curve and clamped samples."""
        rows = [
            ("free run", self.free_run),
            (OWN, self.own),
            ("one step", self.one_step),
            ("persistence, one step", self.persistence),
        ]
        curve = zip(self.horizon.steps, self.horizon.rms_um, strict=True)
        taken = "; ".join(part.text for part in self.taken) or "nothing found"
        notes = [
            f"{OWN}: without what no model can know before the record: {taken}",
            f"noise floor {self.noise.describe()}",
            "rms um after " + ", ".join(f"{1e3 * self.Ts_s * steps:.4g} ms: {rms:.4g}" for steps, rms in curve),
        ]
        if self.y_clamped or self.u_clamped:
            outside = f"y {self.y_clamped}, u {self.u_clamped} samples"
            notes.append(f"outside the model's range in the free run: {outside}")
        if self.unknown_past is not None:
            notes += self.unknown_past.describe(self.source, self.with_unknown_past_um or 0.0)
        title = f"{self.model} on {self.source}: {self.free_run.samples} samples scored"
        first = [f"warning: {line}" for line in self.warnings]
        return Summary(title, SCORE_HEADER, score_rows(rows), notes, first=first)

    def table(self) -> str:
        """The summary as text."""
        return self.summary().text()


OWN = "free run, own"
"""Name of the model's own figure in tables."""


NEXT_TO_NOTHING = "it explains next to nothing of this record"
USELESS = 0.7
"""Free-run error relative to the standard deviation of the displacement from which on a model explains less than half
of the variance."""

SCORE_HEADER = ["", "e_rms um", "max um", "max e_r %", "of stroke %"]


def score_lines(rows: Sequence[tuple[str, Score]]) -> list[str]:
    """One line per named score under a heading, columns aligned."""
    return table(SCORE_HEADER, score_rows(rows)).splitlines()


def decimals(errors_um: Iterable[float]) -> int:
    """Decimals that show the least of these errors: 5, of a stroke of nanometres more.

    >>> decimals([0.5, 2e-4, 0.0]), decimals([3.2e-6])
    (5, 8)
    """
    least = min((error for error in errors_um if error > 0.0), default=1.0)
    return 5 if least >= 1e-4 else min(2 - math.floor(math.log10(least)), 15)


def score_rows(rows: Sequence[tuple[str, Score]]) -> list[list[str]]:
    """Cells under SCORE_HEADER, a row per named score."""
    digits = decimals(score.e_rms_um for _, score in rows)
    return [
        [
            name,
            f"{score.e_rms_um:.{digits}f}",
            f"{score.largest_um:.{digits}f}",
            "-" if score.e_r_percent is None else f"{score.e_r_percent:.3f}",
            f"{score.of_span_percent:.3f}",
        ]
        for name, score in rows
    ]


def score_prediction(record: Record, predicted_um: Sequence[Floats], settle: int | Sequence[int] = 0) -> Score:
    """Score one prediction of every segment, (n,) each. Sample 0 of a segment is an input and not scored.

    settle: samples at the start of every segment, or of each, that are not scored.
    Raises RecordError if a number of samples is negative, or if no sample is left.
    """
    errors = [y_um - segment.y_um for segment, y_um in zip(record.segments, predicted_um, strict=True)]
    return _score(record, errors, _scored_rows(record, settle))


def remaining_of(
    model: Model, record: Record, predicted_um: Sequence[Floats], settle: int | Sequence[int] = 0
) -> Remaining:
    """What a free run of a model leaves of a record, less what no model can know. Arguments as `score_prediction`."""
    errors = [y_um - segment.y_um for segment, y_um in zip(record.segments, predicted_um, strict=True)]
    measured = [segment.y_um for segment in record.segments]
    return take_out(errors, measured, _scored_rows(record, settle), record.Ts_s, Named.of(model))


def _scored_rows(record: Record, settle: int | Sequence[int]) -> list[NDArray[np.bool_]]:
    """(n,) flags of the scored samples of every segment. Raises RecordError as `score_prediction` does."""
    counts = [settle] * len(record.segments) if isinstance(settle, int) else list(settle)
    if min(counts) < 0:
        raise RecordError(f"settle: {min(counts)} is no number of samples; choose 0 or more")
    scored = [
        np.arange(segment.samples) >= max(1, first) for segment, first in zip(record.segments, counts, strict=True)
    ]
    if not any(rows.any() for rows in scored):
        raise RecordError(
            f"{record.source}: settle: {max(counts)} samples at the start of each segment leave none of "
            f"{record.samples} to score; choose fewer"
        )
    return scored


def _score(record: Record, errors_um: Sequence[Floats], scored: Sequence[NDArray[np.bool_]]) -> Score:
    """The score of the errors of every segment on its scored rows."""
    error = np.concatenate([one[rows] for one, rows in zip(errors_um, scored, strict=True)])
    low, high = record.whole().y_range_um
    rms, largest, span = math.sqrt(float(np.mean(error * error))), float(np.abs(error).max()), high - low
    return Score(
        e_rms_um=rms,
        largest_um=largest,
        e_r_percent=100.0 * largest / span if span > 0.0 else None,
        of_span_percent=100.0 * rms / span if span > 0.0 else 0.0,
        samples=error.size,
    )


def persistence(record: Record) -> list[Floats]:
    """Persistence, yhat(k+1) = y(k), of every segment, (n,) each: the reference for one-step errors."""
    return [np.concatenate([segment.y_um[:1], segment.y_um[:-1]]) for segment in record.segments]


@one_blas_thread()
def score(
    model: Model,
    record: Record,
    settle: int | None = None,
    follow_drift: bool = False,
) -> Scores:
    """One-step, horizon and free-run scores of a model on a record, with persistence and the noise floor.

    A segment with a known past (a record that was cut by `rows` or `split`) is simulated from the start of its past.
    settle: samples at the start of each segment that are simulated but not scored; by default those in which the
    unknown past matters (`unknown_past`). follow_drift: as for `simulate.free_run`.
    Raises RecordError if the record's sampling period is not the model's, or if `settle` leaves no sample.
    """
    free, noise = free_run(model, record, follow_drift=follow_drift), noise_floor(record)
    unknown = unknown_past(model, record, noise.rms_um) if settle is None else None
    unscored = [settle or 0] * len(record.segments) if unknown is None else list(unknown.rows)
    scored = score_prediction(record, _outputs(free), unscored)
    ahead = score_prediction(record, _outputs(one_step(model, record)), unscored)
    resting = score_prediction(record, persistence(record), unscored)
    remaining = remaining_of(model, record, _outputs(free), unscored)
    clamped = sum(run.y_clamped for run in free), sum(run.u_clamped for run in free)
    return Scores(
        model=model.name,
        source=record.source,
        digest=record.digest,
        settle=settle or 0,
        one_step=ahead,
        free_run=scored,
        own=_score(record, remaining.error_um, remaining.counted),
        taken=remaining.taken,
        persistence=resting,
        horizon=horizon_curve(model, record, unscored=unscored),
        noise=noise,
        y_clamped=clamped[0],
        u_clamped=clamped[1],
        Ts_s=model.Ts_s,
        unknown_past=unknown,
        with_unknown_past_um=score_prediction(record, _outputs(free)).e_rms_um if unknown is not None else None,
        warnings=(*_doubts(record, scored, ahead, resting), *check_validation(conditions_of_fit(model), record)),
    )


def score_identification(model: Model, record: Record) -> Scores:
    """`score` on the record that the model was fitted to, without the warning that says so."""
    scores = score(model, record)
    kept = tuple(line for line in scores.warnings if not line.endswith(FITTED_RECORD))
    return dataclasses.replace(scores, warnings=kept)


def conditions_of_fit(model: Model) -> Conditions:
    """The conditions of the record that a model was fitted to; of an older model file, the ranges of the model."""
    stored = model.history.get("record", {})
    return Conditions(
        source=str(stored.get("source", model.name)),
        Ts_s=model.Ts_s,
        u_range_V=(model.u_min_V, model.u_max_V),
        y_range_um=(model.grid.y_min_um, model.grid.y_max_um),
        fastest_V_per_s=stored.get("fastest_V_per_s"),
        digest=str(stored.get("digest", "")),
    )


def _doubts(record: Record, free: Score, ahead: Score, resting: Score) -> Iterator[str]:
    """Lines for a model that is no better than a prediction without a model."""
    y_um = record.y_um
    if ahead.e_rms_um > resting.e_rms_um:
        yield (
            f"{record.source}: one step ahead the model is worse than persistence, y(k+1) = y(k): "
            f"{ahead.e_rms_um:.4g} um against {resting.e_rms_um:.4g} um"
        )
    if free.e_rms_um > USELESS * (varies_um := float(np.std(y_um))):
        yield (
            f"{record.source}: in free run the model is wrong by {free.e_rms_um:.4g} um where the displacement itself "
            f"varies by {varies_um:.4g} um rms: {NEXT_TO_NOTHING}"
            f"{', and a constant is wrong by less' if free.e_rms_um > varies_um else ''}"
        )


def _outputs(runs: Sequence[ModelOutput]) -> list[Floats]:
    return [run.y_um for run in runs]
