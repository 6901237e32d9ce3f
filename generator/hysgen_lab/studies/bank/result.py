"""The result of a run of the bank: confusion of causes, error rates, smallest effects found, parameter errors."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from hysgen.diagnosis.causes import VOCABULARY
from hysgen_lab.stage import Hysteresis

CONFIDENCES = (0.0, 0.9, 0.99, 0.999, 1.0)
"""Edges of the classes of confidence in the calibration."""


@dataclass(frozen=True)
class Judgement:
    """One record: the causes planted, required (share above `memory_model_rms`) and named.

    relative: share of each planted effect over `memory_model_rms`. errors: of each parameter, see `parameter_errors`.
    fall: free-run error of the paper's model over that of the extended one, where only Preisach memory is hidden.
    over_truth: error of the extended model over that of the same family fitted with the truth known, where every
    planted cause is extended. Either is nan elsewhere. family: of the hysteresis, "" for the bank's own stage.
    allowed: causes that may be named although they were not planted (`Scenario.allowed`). confidence: of each named
    cause that has one. ranks: of each parameter (`Compared`). over_probe: the delivered model's own error over that of
    the probe on the same held-out rows; gain: that of the paper's model over that of the delivered one.
    """

    category: str
    seed: int
    rate_Hz: float
    excitation: str
    planted: tuple[str, ...]
    required: tuple[str, ...]
    named: tuple[str, ...]
    relative: dict[str, float]
    errors: dict[str, float]
    seconds: float
    experiment: str
    fall: float = math.nan
    over_truth: float = math.nan
    family: str = ""
    allowed: tuple[str, ...] = ()
    confidence: dict[str, float] = field(default_factory=dict)
    ranks: dict[str, float] = field(default_factory=dict)
    over_probe: float = math.nan
    gain: float = math.nan

    @property
    def name(self) -> str:
        """Family (unless the bank's own stage), category and seed."""
        return " ".join(part for part in (self.family, self.category, str(self.seed)) if part)

    @property
    def exact(self) -> bool:
        """Whether every required cause is named, and no cause that is neither planted nor allowed."""
        return set(self.required) <= set(self.named) and not self.wrong

    @property
    def wrong(self) -> tuple[str, ...]:
        """The causes named that are neither planted nor allowed."""
        return tuple(name for name in self.named if name not in (*self.planted, *self.allowed))

    def difference(self) -> str:
        """The required causes that are not named, with their relative shares, and the causes wrongly named."""
        lacks = [f"{name} ({self.relative[name]:.3g})" for name in self.required if name not in self.named]
        parts = [f"{word} {', '.join(names)}" for word, names in (("lacks", lacks), ("adds", self.wrong)) if names]
        return "; ".join(parts) or "exact"


@dataclass(frozen=True)
class BankResult:
    """The judgements of a run in the order of the seeds; asked: number of records of the complete run."""

    judgements: tuple[Judgement, ...]
    seeds: tuple[int, ...]
    asked: int

    @property
    def complete(self) -> bool:
        """Whether every record of the run is judged."""
        return len(self.judgements) == self.asked

    def judged(self) -> list[Judgement]:
        """Records with a good excitation: those that the limits are stated for."""
        return [judgement for judgement in self.judgements if judgement.category != "poor"]

    def families(self) -> dict[str, BankResult]:
        """The judgements of each family of hysteresis; empty if all are of one family."""
        names = list(dict.fromkeys(judgement.family for judgement in self.judgements))
        parts = {name: tuple(judgement for judgement in self.judgements if judgement.family == name) for name in names}
        return {name: BankResult(part, self.seeds, len(part)) for name, part in parts.items()} if len(names) > 1 else {}

    def quiet(self) -> list[Judgement]:
        """Judged records with nothing hidden: memory only, or no effect at all."""
        return [judgement for judgement in self.judged() if judgement.category in (Hysteresis.name, "none")]

    @property
    def exact_rate(self) -> float:
        """Share of judged records with the exact set of causes."""
        return _share([judgement.exact for judgement in self.judged()])

    @property
    def found_rate(self) -> float:
        """Share of required causes that were named, over the judged records."""
        return _share([name in judgement.named for judgement in self.judged() for name in judgement.required])

    @property
    def false_alarm_rate(self) -> float:
        """Share of the quiet records in which a cause is named that was not planted."""
        return _share([bool(judgement.wrong) for judgement in self.quiet()])

    def confusion(self) -> dict[str, dict[str, int]]:
        """Number of records by required cause and named cause; "nothing": no cause but memory was planted."""
        table: dict[str, dict[str, int]] = {}
        for judgement in self.judged():
            required, planted, named = (
                [name for name in names if name != Hysteresis.name]
                for names in (judgement.required, judgement.planted, judgement.named)
            )
            for row in required or ([] if planted else ["nothing"]):
                counts = table.setdefault(row, {})
                others = [name for name in named if name == row or name not in planted]
                for column in others or ["nothing"]:
                    counts[column] = counts.get(column, 0) + 1
        return table

    def smallest(self, share: float) -> dict[str, float]:
        """Per cause: the smallest relative share from which on at least `share` of the records name the cause."""
        levels = {}
        for name in VOCABULARY:
            seen = sorted(
                (judgement.relative[name], name in judgement.named)
                for judgement in self.judged()
                if name in judgement.relative
            )
            for i, (strength, _) in enumerate(seen):
                if _share([named for _, named in seen[i:]]) >= share:
                    levels[name] = strength
                    break
        return levels

    def parameter_errors(self) -> dict[str, tuple[float, float, int]]:
        """Per parameter: median and largest error over the records where its cause was required and named."""
        gathered: dict[str, list[float]] = {}
        for judgement in self.judged():
            for key, error in judgement.errors.items():
                if key.split(".")[0] in judgement.required:
                    gathered.setdefault(key, []).append(abs(error))
        return {key: (float(np.median(v)), float(max(v)), len(v)) for key, v in sorted(gathered.items())}

    def ranks(self) -> dict[str, tuple[int, int, int, int]]:
        """Per parameter of a required cause: records whose truth lies in each quarter of what the estimate states."""
        quarters: dict[str, list[int]] = {}
        for judgement in self.judged():
            for key, rank in judgement.ranks.items():
                if key.split(".")[0] in judgement.required:
                    quarters.setdefault(key, [0, 0, 0, 0])[min(int(4.0 * rank), 3)] += 1
        return {key: (a, b, c, d) for key, (a, b, c, d) in sorted(quarters.items())}

    def calibration(self) -> list[tuple[float, int, int]]:
        """Per class of confidence: its lower edge, the named causes in it, and how many of them were planted."""
        named, classes = self._named(), []
        for low, high in itertools.pairwise(CONFIDENCES):
            inside = [planted for confidence, planted in named if low <= confidence < high or confidence == high == 1.0]
            classes.append((low, len(inside), sum(inside)))
        return classes

    def scores(self) -> tuple[float, float]:
        """Log score and Brier score of the confidences of the named causes: means of -ln p(what is so) and (1 - p)^2.

        p is at least 1 / (n + 2) and at most 1 less that, for n names: no more is shown by n of them (Laplace). nan
        without a name.
        """
        named = self._named()
        true = np.array([confidence if planted else 1.0 - confidence for confidence, planted in named] or [np.nan])
        known = np.clip(true, 1.0 / (len(named) + 2), 1.0 - 1.0 / (len(named) + 2))
        return float(-np.log(known).mean()), float(np.mean((1.0 - true) ** 2))

    def _named(self) -> list[tuple[float, bool]]:
        """Confidence of each named cause that has one, and whether it was planted."""
        return [
            (confidence, name not in judgement.wrong)
            for judgement in self.judged()
            for name, confidence in judgement.confidence.items()
        ]

    def falls(self) -> list[float]:
        """The factors `fall` of all records that have one, rising."""
        return sorted(judgement.fall for judgement in self.judged() if math.isfinite(judgement.fall))

    def over_truth(self) -> list[float]:
        """The ratios `over_truth` of all records that have one, rising."""
        return sorted(judgement.over_truth for judgement in self.judged() if math.isfinite(judgement.over_truth))

    def of_categories(self) -> dict[str, dict[str, Any]]:
        """By category: records, exact sets, delivered over probe (median, largest and its record), median gain."""
        table: dict[str, dict[str, Any]] = {}
        for category in dict.fromkeys(judgement.category for judgement in self.judgements):
            part = [judgement for judgement in self.judgements if judgement.category == category]
            ratios = [judgement.over_probe for judgement in part if math.isfinite(judgement.over_probe)]
            table[category] = {
                "records": len(part),
                "exact": sum(judgement.exact for judgement in part),
                "over_probe": {"median": _median(ratios), "largest": max(ratios, default=None)},
                "largest_in": next((v.name for v in part if ratios and v.over_probe == max(ratios)), None),
                "gain": _median([judgement.gain for judgement in part if math.isfinite(judgement.gain)]),
            }
        return table

    def to_json(self) -> dict[str, Any]:
        """The result as JSON values."""
        return {
            "records": len(self.judgements),
            "complete": self.complete,
            "seeds": [min(self.seeds), max(self.seeds)],
            "exact_rate": _finite(self.exact_rate),
            "found_rate": _finite(self.found_rate),
            "false_alarm_rate": _finite(self.false_alarm_rate),
            "confusion": self.confusion(),
            "smallest_found": {"50%": self.smallest(0.5), "95%": self.smallest(0.95)},
            "parameter_errors": {
                key: {"median": m, "largest": w, "records": c} for key, (m, w, c) in self.parameter_errors().items()
            },
            "ranks": {key: list(quarters) for key, quarters in self.ranks().items()},
            "calibration": [
                {"from": low, "named": named, "there": planted} for low, named, planted in self.calibration()
            ],
            "log_score": _finite(self.scores()[0]),
            "brier_score": _finite(self.scores()[1]),
            "falls_by_memory": self.falls(),
            "over_truth": self.over_truth(),
            "wrong": [
                {
                    "family": v.family,
                    "category": v.category,
                    "seed": v.seed,
                    "required": v.required,
                    "named": v.named,
                }
                for v in self.judged()
                if not v.exact
            ],
            "families": {
                name: {
                    "records": len(part.judged()),
                    "exact_rate": _finite(part.exact_rate),
                    "found_rate": _finite(part.found_rate),
                }
                for name, part in self.families().items()
            },
            "categories": self.of_categories(),
            "median_seconds": _median([judgement.seconds for judgement in self.judgements]),
        }

    def table(self) -> str:
        """The confusion matrix and the rates as text."""
        columns = [*(name for name in VOCABULARY if name != Hysteresis.name), "nothing"]
        matrix = self.confusion()
        lines = ["hidden (rows) named as (columns)", f"{'':12}" + "".join(f"{name[:7]:>8}" for name in columns)]
        for row in columns:
            if row in matrix:
                cells = "".join(f"{matrix[row].get(column, 0) or '.':>8}" for column in columns)
                lines.append(f"{row:12}{cells}")
        judged = self.judged()
        lines.append("")
        lines.append(f"exact set of causes  {100 * self.exact_rate:6.1f} %  of {len(judged)} records")
        required = sum(len(judgement.required) for judgement in judged)
        lines.append(f"required and found   {100 * self.found_rate:6.1f} %  of {required} causes")
        alarms = f"{100 * self.false_alarm_rate:6.1f} %  of {len(self.quiet())} records, nothing hidden"
        lines.append(f"false alarms         {alarms}")
        for name, part in self.families().items():
            count = sum(judgement.exact for judgement in part.judged())
            lines.append(f"  {name or 'own stage':18}exact {count:3} of {len(part.judged()):3}")
        lines.append("category         exact     delivered over probe: median, largest     gain: median")
        for category, values in self.of_categories().items():
            ratio, where = values["over_probe"], values["largest_in"] or ""
            figures = f"{_two(ratio['median'])}{_two(ratio['largest'])}{_two(values['gain'])}"
            lines.append(f"  {category:12}{values['exact']:3} of {values['records']:3}{figures}  {where}".rstrip())
        half, most = self.smallest(0.5), self.smallest(0.95)
        lines.append("smallest effect found, as a multiple of what memory alone leaves (50 % / 95 % of the time):")
        lines.extend(
            f"  {name:12}{half.get(name, float('nan')):8.2f} /{most.get(name, float('nan')):8.2f}" for name in half
        )
        lines.append("parameters, median and largest error:")
        lines.extend(f"  {key:32}{m:10.3g}{w:10.3g}  of {c}" for key, (m, w, c) in self.parameter_errors().items())
        lines.append("true parameters in each quarter of what the estimates state (equal if the errors are right):")
        lines.extend(f"  {key:32}" + "".join(f"{n:5}" for n in quarters) for key, quarters in self.ranks().items())
        lines.append("named with a confidence from .. on, and there:")
        lines.extend(
            f"  {100 * low:5.1f} %{planted:5} of {named}" for low, named, planted in self.calibration() if named
        )
        lines.append("log score {:.4f}, Brier score {:.4f} of these names".format(*self.scores()))
        if falls := self.falls():
            at = np.quantile(falls, [0.0, 0.1, 0.5, 1.0])
            lines.append(
                f"memory of the Preisach kind alone: error falls {at[2]:.1f} times (median of {len(falls)} records; "
                f"worst {at[0]:.1f}, a tenth below {at[1]:.1f}, best {at[3]:.1f})"
            )
        if over := self.over_truth():
            at = np.quantile(over, [0.5, 0.95, 1.0])
            lines.append(
                f"error over that with the truth known: median {at[0]:.2f}, 95 % below {at[1]:.2f}, "
                f"largest {at[2]:.2f} ({len(over)} records with every planted cause extended)"
            )
        return "\n".join(lines)


def _share(hits: Sequence[bool]) -> float:
    return float(np.mean(hits)) if hits else float("nan")


def _median(values: Sequence[float]) -> float | None:
    return float(np.median(values)) if values else None


def _two(value: float | None) -> str:
    return f"{'-' if value is None else format(value, '.2f'):>10}"


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
