"""The limits that a run of the bank must meet, and whether it meets them."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hysgen_lab.stage import effects
from hysgen_lab.studies.bank.result import BankResult, Judgement

RECORDS, QUIET = 200, 100
"""Number of records, and of records with nothing hidden, that the limits of the rates are stated for."""

LEAST_EXACT, LEAST_FOUND = 0.95, 0.98
LEAST_EXACT_IN_FAMILY, FAMILY_RECORDS = 0.90, 42
"""Share of exact sets in each family of hysteresis, and the records it is stated for: 14 categories, 3 seeds."""

ALARMS = 1
"""False alarms that are allowed in QUIET records."""

LEAST_FALL = 7.0
MOST_OVER_TRUTH = 2.0

PARAMETERS: dict[str, float] = {
    key: tolerance.limit
    for kind in effects().values()
    for key, tolerance in kind.tolerances.items()
    if tolerance is not None and tolerance.limit is not None
}
"""Largest error of each parameter, in the measure of its `Tolerance`."""


@dataclass(frozen=True)
class Limit:
    """One limit: the value wanted, the value measured, and whether it holds; None where no record measures it.

    enough: whether the run has the number of records that the limit is stated for. beyond: records that exceed it.
    """

    name: str
    wanted: str
    measured: str
    holds: bool | None
    enough: bool = True
    beyond: tuple[str, ...] = ()

    @property
    def mark(self) -> str:
        """ "met", "MISSED", "met so far" with too few records, or "-"."""
        if self.holds is None:
            return "-"
        return ("met" if self.enough else "met so far") if self.holds else "MISSED"


def limits(result: BankResult) -> tuple[Limit, ...]:
    """Every limit, on the records of a run with a good excitation."""
    judged = result.judged()
    parameters = (_parameter_limit(key, most, judged) for key, most in PARAMETERS.items())
    families = (_family_limit(name, part) for name, part in result.families().items())
    return (*_rate_limits(result), *families, *parameters, _fall_limit(judged), _truth_limit(judged))


def _family_limit(name: str, part: BankResult) -> Limit:
    judged = part.judged()
    return Limit(
        f"exact set, {name or 'own stage'}",
        f">= {100 * LEAST_EXACT_IN_FAMILY:.0f} % of {FAMILY_RECORDS} records",
        f"{100 * part.exact_rate:.1f} % of {len(judged)}",
        part.exact_rate >= LEAST_EXACT_IN_FAMILY if judged else None,
        len(judged) >= FAMILY_RECORDS,
    )


def _rate_limits(result: BankResult) -> list[Limit]:
    judged, quiet = result.judged(), result.quiet()
    alarmed = [judgement for judgement in quiet if judgement.wrong]
    lacking = [judgement for judgement in judged if not set(judgement.required) <= set(judgement.named)]
    required = sum(len(judgement.required) for judgement in judged)
    return [
        Limit(
            "exact set of causes",
            f">= {100 * LEAST_EXACT:.0f} % of {RECORDS} records",
            f"{100 * result.exact_rate:.1f} % of {len(judged)}",
            result.exact_rate >= LEAST_EXACT if judged else None,
            len(judged) >= RECORDS,
            _differences([judgement for judgement in judged if not judgement.exact]),
        ),
        Limit(
            "required causes found",
            f">= {100 * LEAST_FOUND:.0f} %",
            f"{100 * result.found_rate:.1f} % of {required}",
            result.found_rate >= LEAST_FOUND if required else None,
            len(judged) >= RECORDS,
            _differences(lacking),
        ),
        Limit(
            "false alarms",
            f"<= {ALARMS} in {QUIET} quiet records",
            f"{len(alarmed)} in {len(quiet)}",
            len(alarmed) <= ALARMS * max(1.0, len(quiet) / QUIET) if quiet else None,
            len(quiet) >= QUIET,
            _differences(alarmed),
        ),
    ]


def _parameter_limit(key: str, most: float, judged: list[Judgement]) -> Limit:
    """The largest error of "cause.parameter", over the records where the cause was required and named."""
    name = key.split(".")[0]
    seen = [
        judgement
        for judgement in judged
        if key in judgement.errors and name in judgement.required and name in judgement.named
    ]
    worst = max((abs(judgement.errors[key]) for judgement in seen), default=math.nan)
    beyond = [judgement for judgement in seen if not abs(judgement.errors[key]) <= most]
    return Limit(
        f"error of {key}",
        f"<= {most:g}",
        f"{worst:.3g}, {len(seen)} records" if seen else "no record",
        not beyond if seen else None,
        beyond=tuple(f"{judgement.name}: {judgement.errors[key]:.3g}" for judgement in beyond),
    )


def _fall_limit(judged: list[Judgement]) -> Limit:
    falls = [judgement for judgement in judged if math.isfinite(judgement.fall)]
    return Limit(
        "fall by the memory extension",
        f">= {LEAST_FALL:g} times",
        f"{min(judgement.fall for judgement in falls):.1f} at least, {len(falls)} records" if falls else "no record",
        all(judgement.fall >= LEAST_FALL for judgement in falls) if falls else None,
        beyond=tuple(f"{judgement.name}: {judgement.fall:.1f}" for judgement in falls if judgement.fall < LEAST_FALL),
    )


def _truth_limit(judged: list[Judgement]) -> Limit:
    ratios = [judgement for judgement in judged if math.isfinite(judgement.over_truth)]
    beyond = [judgement for judgement in ratios if judgement.over_truth > MOST_OVER_TRUTH]
    largest = max((judgement.over_truth for judgement in ratios), default=math.nan)
    return Limit(
        "error over that with the truth known",
        f"<= {MOST_OVER_TRUTH:g}",
        f"{largest:.2f} at most, {len(ratios)} records" if ratios else "no record",
        not beyond if ratios else None,
        beyond=tuple(f"{judgement.name}: {judgement.over_truth:.2f}" for judgement in beyond),
    )


def limits_table(comparisons: tuple[Limit, ...]) -> str:
    """The limits as text; below each limit the records that exceed it."""
    lines = [f"{'limit':38}{'wanted':26}{'measured':26}"]
    for limit in comparisons:
        lines.append(f"{limit.name:38}{limit.wanted:26}{limit.measured:26}{limit.mark}")
        lines.extend(f"    {record}" for record in limit.beyond)
    return "\n".join(lines)


def _differences(judgements: list[Judgement]) -> tuple[str, ...]:
    return tuple(f"{judgement.name}: {judgement.difference()}" for judgement in judgements)
