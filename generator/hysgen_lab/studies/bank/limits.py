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
    errors = [(judgement.name, judgement.errors[key]) for judgement in seen]
    worst = max((abs(error) for _, error in errors), default=math.nan)
    beyond = [named for named in errors if not abs(named[1]) <= most]
    return _limit_of(f"error of {key}", f"<= {most:g}", f"{worst:.3g}, {len(seen)} records", errors, beyond, ".3g")


def _fall_limit(judged: list[Judgement]) -> Limit:
    falls = [(judgement.name, judgement.fall) for judgement in judged if math.isfinite(judgement.fall)]
    beyond = [named for named in falls if named[1] < LEAST_FALL]
    measured = f"{min((fall for _, fall in falls), default=math.nan):.1f} at least, {len(falls)} records"
    return _limit_of("fall by the memory extension", f">= {LEAST_FALL:g} times", measured, falls, beyond, ".1f")


def _truth_limit(judged: list[Judgement]) -> Limit:
    ratios = [(judgement.name, judgement.over_truth) for judgement in judged if math.isfinite(judgement.over_truth)]
    beyond = [named for named in ratios if named[1] > MOST_OVER_TRUTH]
    measured = f"{max((ratio for _, ratio in ratios), default=math.nan):.2f} at most, {len(ratios)} records"
    name = "error over that with the truth known"
    return _limit_of(name, f"<= {MOST_OVER_TRUTH:g}", measured, ratios, beyond, ".2f")


Values = list[tuple[str, float]]
"""Name and value of records."""


def _limit_of(name: str, wanted: str, measured: str, values: Values, beyond: Values, form: str) -> Limit:
    """A limit of the values of records; beyond: those that exceed it."""
    exceeding = tuple(f"{record}: {value:{form}}" for record, value in beyond)
    if not values:
        return Limit(name, wanted, "no record", None)
    return Limit(name, wanted, measured, not beyond, beyond=exceeding)


def limits_table(comparisons: tuple[Limit, ...]) -> str:
    """The limits as text; below each limit the records that exceed it."""
    lines = [f"{'limit':38}{'wanted':26}{'measured':26}"]
    for limit in comparisons:
        lines.append(f"{limit.name:38}{limit.wanted:26}{limit.measured:26}{limit.mark}")
        lines.extend(f"    {record}" for record in limit.beyond)
    return "\n".join(lines)


def _differences(judgements: list[Judgement]) -> tuple[str, ...]:
    return tuple(f"{judgement.name}: {judgement.difference()}" for judgement in judgements)
