"""Scores of a model on a record: one-step error, error over the horizon, and free-run error.

    e_rms  = sqrt(sum_k (y(k) - yhat(k))^2 / N)
    e_r    = max_k |y(k) - yhat(k)| / max_k y(k) * 100 %          section 4 of the paper, "maximum e_r"

They are shown with the one-step error of persistence, yhat(k+1) = y(k), and with the noise floor: at high sampling
rates the one-step error alone is small for any model. e_r is undefined where the displacement is not positive; errors
are also given in um and relative to the span.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.display import Displayed, Summary, table
from hysgen.model.model import Model
from hysgen.model.regression import Starts
from hysgen.model.simulate import HorizonCurve, ModelOutput, free_run, horizon_curve, one_step
from hysgen.record import Record
from hysgen.record.noise import NoiseFloor, noise_floor

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Score:
    """The error of one prediction of a record.

    e_rms_um; largest_um: max |y - yhat|; e_r_percent: the paper's maximum e_r, None where max y is not positive;
    of_span_percent: e_rms relative to the span of the record. samples: number of scored samples.
    """

    e_rms_um: float
    largest_um: float
    e_r_percent: float | None
    of_span_percent: float
    samples: int

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "e_rms_um": self.e_rms_um,
            "largest_um": self.largest_um,
            "e_r_percent": self.e_r_percent,
            "of_span_percent": self.of_span_percent,
            "samples": self.samples,
        }


@dataclass(frozen=True, repr=False)
class Scores(Displayed):
    """All scores of a model on a record. settle: burn-in, unscored samples at the start of each segment."""

    model: str
    source: str
    digest: str
    settle: int
    one_step: Score
    free_run: Score
    persistence: Score
    horizon: HorizonCurve
    noise: NoiseFloor
    y_clamped: int
    u_clamped: int
    Ts_s: float

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "model": self.model,
            "record": {"source": self.source, "digest": self.digest},
            "settle": self.settle,
            "one_step": self.one_step.to_json(),
            "free_run": self.free_run.to_json(),
            "persistence_one_step": self.persistence.to_json(),
            "horizon": self.horizon.to_json(),
            "noise_floor": self.noise.to_json(),
            "clamped": {"y": self.y_clamped, "u": self.u_clamped},
            "unit": "um",
        }

    def summary(self) -> Summary:
        """Table of the scores, with noise floor, horizon curve and clamped samples."""
        rows = [("free run", self.free_run), ("one step", self.one_step), ("persistence, one step", self.persistence)]
        curve = zip(self.horizon.steps, self.horizon.rms_um, strict=True)
        notes = [
            f"noise floor {self.noise.describe()}",
            "rms after steps: " + ", ".join(f"{steps}: {rms:.4g}" for steps, rms in curve) + " um",
        ]
        if self.y_clamped or self.u_clamped:
            outside = f"y {self.y_clamped}, u {self.u_clamped} samples"
            notes.append(f"outside the model's range in the free run: {outside}")
        title = f"{self.model} on {self.source}: {self.free_run.samples} samples scored"
        return Summary(title, SCORE_HEADER, score_rows(rows), notes)

    def table(self) -> str:
        """The summary as text."""
        return self.summary().text()


SCORE_HEADER = ["", "e_rms um", "max um", "max e_r %", "of span %"]


def score_lines(rows: Sequence[tuple[str, Score]]) -> list[str]:
    """One line per named score under a heading, columns aligned."""
    return table(SCORE_HEADER, score_rows(rows)).splitlines()


def score_rows(rows: Sequence[tuple[str, Score]]) -> list[list[str]]:
    """Cells under SCORE_HEADER, a row per named score."""
    return [
        [
            name,
            f"{score.e_rms_um:.5f}",
            f"{score.largest_um:.5f}",
            "-" if score.e_r_percent is None else f"{score.e_r_percent:.3f}",
            f"{score.of_span_percent:.3f}",
        ]
        for name, score in rows
    ]


def score_prediction(record: Record, predicted_um: Sequence[Floats], settle: int = 0) -> Score:
    """Score one prediction of every segment, (n,) each. Sample 0 of a segment is an input and not scored.

    settle: burn-in, unscored samples at the start of each segment.
    """
    first = max(1, settle)
    pairs = [(segment.y_um[first:], y_um[first:]) for segment, y_um in zip(record.segments, predicted_um, strict=True)]
    y, error = np.concatenate([y for y, _ in pairs]), np.concatenate([hat - y for y, hat in pairs])
    low, high = record.y_range_um
    if error.size == 0:
        return Score(0.0, 0.0, None, 0.0, 0)
    rms, largest, top = math.sqrt(float(np.mean(error * error))), float(np.abs(error).max()), float(y.max())
    span = high - low
    return Score(
        e_rms_um=rms,
        largest_um=largest,
        e_r_percent=100.0 * largest / top if top > 0.0 else None,
        of_span_percent=100.0 * rms / span if span > 0.0 else 0.0,
        samples=error.size,
    )


def persistence(record: Record) -> list[Floats]:
    """Persistence, yhat(k+1) = y(k), of every segment, (n,) each: the reference for one-step errors."""
    return [np.concatenate([segment.y_um[:1], segment.y_um[:-1]]) for segment in record.segments]


def score(
    model: Model, record: Record, settle: int = 0, starts: Starts | None = None, follow_drift: bool = False
) -> Scores:
    """One-step, horizon and free-run scores of a model on a record, with persistence and the noise floor.

    settle: samples at the start of each segment that are simulated but not scored.
    starts, follow_drift: as for `simulate.free_run`.
    Raises RecordError if the record's sampling period is not the model's.
    """
    free = free_run(model, record, starts, follow_drift)
    return Scores(
        model=model.name,
        source=record.source,
        digest=record.digest,
        settle=settle,
        one_step=score_prediction(record, _outputs(one_step(model, record, starts)), settle),
        free_run=score_prediction(record, _outputs(free), settle),
        persistence=score_prediction(record, persistence(record), settle),
        horizon=horizon_curve(model, record, starts=starts),
        noise=noise_floor(record),
        y_clamped=sum(run.y_clamped for run in free),
        u_clamped=sum(run.u_clamped for run in free),
        Ts_s=model.Ts_s,
    )


def _outputs(runs: Sequence[ModelOutput]) -> list[Floats]:
    return [run.y_um for run in runs]
