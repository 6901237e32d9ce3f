"""What is tried: cases with settings, and what came of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Final

CASES: Final = ("constant", "noise", "sine", "triangle", "bursts", "spikes", "saturation")
ALLOWED_RATIO: Final = 1.10
"""Free-run error after recovery over that of a fresh fit."""


@dataclass(frozen=True)
class Trial:
    """A case, the learner's forgetting and alpha, and how many samples it is fed."""

    case: str
    forgetting: float
    alpha: float
    samples: int


def trials(samples: int, others: int) -> list[Trial]:
    """Every case for `samples` with forgetting 0.999 and alpha 1e6; for `others` with 1, 0.9999, 0.99 and 1e6, 1e3.

    Of 0 samples: none.
    """
    first = [Trial(case, 0.999, 1e6, samples) for case in CASES]
    rest = [
        Trial(case, forgetting, alpha, others)
        for forgetting in (1.0, 0.9999, 0.99)
        for alpha in (1e6, 1e3)
        for case in CASES
    ]
    return [*(first if samples else []), *(rest if others else [])]


@dataclass(frozen=True)
class Outcome:
    """What a trial came to.

    broken_at: first sample after which a factor was not finite or not positive; None: never. updates: how many samples
    were learnt from. least_d .. largest_theta_um: extremes of D, U and theta seen on the way, which the generated code
    promises to keep within bound_d and bound_theta_um. events: counters.
    recovered: free-run error after one second of good excitation over that of a fresh fit of the same second with the
    same forgetting; recovered_whole: over that of a fit that weighs the whole second alike.
    printed_dies_at: where Eq. (10) as printed, in float32, loses its covariance under the same samples.
    """

    trial: Trial
    updates: int
    broken_at: int | None
    least_d: float
    largest_d: float
    largest_u: float
    largest_theta_um: float
    bound_d: float
    bound_theta_um: float
    events: dict[str, int]
    recovered: float
    recovered_whole: float
    printed_dies_at: int | None

    @property
    def holds(self) -> bool:
        """All factors finite, positive and bounded to the end, and recovered within ALLOWED_RATIO."""
        bounded = self.largest_d <= self.bound_d and self.largest_theta_um <= self.bound_theta_um
        return self.broken_at is None and bounded and self.recovered <= ALLOWED_RATIO

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return asdict(self) | {"holds": self.holds}


HEADINGS: Final = (
    "case",
    "lambda",
    "alpha",
    "samples",
    "updates",
    "D",
    "max |U|",
    "max |theta| um",
    "restarts",
    "factors",
    "recovered",
    "lambda 1",
    "Eq. (10) float32",
)


def rows(outcomes: Sequence[Outcome]) -> list[tuple[str, ...]]:
    """The table's rows as text, one per outcome, under HEADINGS."""
    return [_row(outcome) for outcome in outcomes]


def _row(outcome: Outcome) -> tuple[str, ...]:
    trial = outcome.trial
    printed = "survives" if outcome.printed_dies_at is None else f"dies at {outcome.printed_dies_at}"
    return (
        trial.case,
        f"{trial.forgetting:g}",
        f"{trial.alpha:g}",
        f"{trial.samples:.0e}",
        str(outcome.updates),
        f"{outcome.least_d:.1e} .. {outcome.largest_d:.1e}",
        f"{outcome.largest_u:.1e}",
        f"{outcome.largest_theta_um:.1e}",
        str(outcome.events["restarts"]),
        "hold" if outcome.broken_at is None else f"broken at {outcome.broken_at}",
        f"{outcome.recovered:.3f}",
        f"{outcome.recovered_whole:.3f}",
        printed,
    )
