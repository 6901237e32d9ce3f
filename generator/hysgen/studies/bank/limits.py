"""What a run of the bank has to reach, and whether it does."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hysgen.stage import effects
from hysgen.studies.bank.result import BankResult, Verdict

RECORDS, QUIET = 200, 100
"""Records, and records with nothing hidden, from which on the rates mean what is asked of them."""

LEAST_EXACT, LEAST_FOUND = 0.95, 0.98
ALARMS = 1
"""False alarms that QUIET records may give."""

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
    """One limit: what is wanted, what was measured, whether it holds; None where there was nothing to measure.

    enough: whether there were as many records as the limit speaks of. beyond: the records that are beyond it.
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
    """Every limit, judged on the records of a run with a good excitation."""
    judged, quiet = result.judged(), result.quiet()
    alarmed = [verdict for verdict in quiet if not set(verdict.named) <= set(verdict.planted)]
    lacking = [v for v in judged if not set(v.required) <= set(v.named)]
    required = sum(len(verdict.required) for verdict in judged)
    found = [
        Limit(
            "exact set of causes",
            f">= {100 * LEAST_EXACT:.0f} % of {RECORDS} records",
            f"{100 * result.exact_rate:.1f} % of {len(judged)}",
            result.exact_rate >= LEAST_EXACT if judged else None,
            len(judged) >= RECORDS,
            _told([verdict for verdict in judged if not verdict.exact]),
        ),
        Limit(
            "required causes found",
            f">= {100 * LEAST_FOUND:.0f} %",
            f"{100 * result.found_rate:.1f} % of {required}",
            result.found_rate >= LEAST_FOUND if required else None,
            len(judged) >= RECORDS,
            _told(lacking),
        ),
        Limit(
            "false alarms",
            f"<= {ALARMS} in {QUIET} quiet records",
            f"{len(alarmed)} in {len(quiet)}",
            len(alarmed) <= ALARMS * max(1.0, len(quiet) / QUIET) if quiet else None,
            len(quiet) >= QUIET,
            _told(alarmed),
        ),
    ]
    for key, most in PARAMETERS.items():
        name = key.split(".")[0]
        seen = [v for v in judged if key in v.errors and name in v.required and name in v.named]
        worst = max((abs(verdict.errors[key]) for verdict in seen), default=math.nan)
        beyond = [verdict for verdict in seen if not abs(verdict.errors[key]) <= most]
        found.append(
            Limit(
                f"error of {key}",
                f"<= {most:g}",
                f"{worst:.3g}, {len(seen)} records" if seen else "no record",
                not beyond if seen else None,
                beyond=tuple(f"{_name(verdict)}: {verdict.errors[key]:.3g}" for verdict in beyond),
            )
        )
    falls = [verdict for verdict in judged if math.isfinite(verdict.fall)]
    found.append(
        Limit(
            "fall by the memory extension",
            f">= {LEAST_FALL:g} times",
            f"{min(v.fall for v in falls):.1f} at least, {len(falls)} records" if falls else "no record",
            all(verdict.fall >= LEAST_FALL for verdict in falls) if falls else None,
            beyond=tuple(f"{_name(v)}: {v.fall:.1f}" for v in falls if v.fall < LEAST_FALL),
        )
    )
    ratios = [verdict for verdict in judged if math.isfinite(verdict.over_truth)]
    found.append(
        Limit(
            "error over that with the truth known",
            f"<= {MOST_OVER_TRUTH:g}",
            f"{max(v.over_truth for v in ratios):.2f} at most, {len(ratios)} records" if ratios else "no record",
            all(verdict.over_truth <= MOST_OVER_TRUTH for verdict in ratios) if ratios else None,
            beyond=tuple(f"{_name(v)}: {v.over_truth:.2f}" for v in ratios if v.over_truth > MOST_OVER_TRUTH),
        )
    )
    return tuple(found)


def limits_table(found: tuple[Limit, ...]) -> str:
    """The limits for people; below each one that is missed or has exceptions, the records beyond it."""
    lines = [f"{'limit':38}{'wanted':26}{'measured':26}"]
    for limit in found:
        lines.append(f"{limit.name:38}{limit.wanted:26}{limit.measured:26}{limit.mark}")
        lines.extend(f"    {record}" for record in limit.beyond)
    return "\n".join(lines)


def _told(verdicts: list[Verdict]) -> tuple[str, ...]:
    return tuple(f"{_name(verdict)}: {verdict.difference()}" for verdict in verdicts)


def _name(verdict: Verdict) -> str:
    return f"{verdict.category} {verdict.seed}"
