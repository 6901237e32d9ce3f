"""Settings and results of endurance tests, as data, JSON values and table rows."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Final

CASES: Final = ("constant", "noise", "sine", "triangle", "bursts", "spikes", "saturation")
"""Names of the excitations (`excitations.excitations`)."""

ALLOWED_RATIO: Final = 1.10
"""Largest allowed free-run error after recovery, divided by the free-run error of a fresh fit."""


@dataclass(frozen=True)
class EnduranceTest:
    """An excitation by name, the learner's forgetting and alpha, and the number of samples fed."""

    case: str
    forgetting: float
    alpha: float
    samples: int


def endurance_tests(samples: int, others: int) -> list[EnduranceTest]:
    """Every case for `samples` with forgetting 0.999 and alpha 1e6; for `others` with 1, 0.9999, 0.99 and 1e6, 1e3.

    A count of 0 leaves its tests out.
    """
    first = [EnduranceTest(case, 0.999, 1e6, samples) for case in CASES]
    rest = [
        EnduranceTest(case, forgetting, alpha, others)
        for forgetting in (1.0, 0.9999, 0.99)
        for alpha in (1e6, 1e3)
        for case in CASES
    ]
    return [*(first if samples else []), *(rest if others else [])]


@dataclass(frozen=True)
class EnduranceResult:
    """Result of one test.

    updates: number of samples that updated the estimate. broken_at: first sample after which a factor was not finite or
    not positive; None if there is none. least_d .. largest_theta_um: observed extremes of D, U and theta; the generated
    code guarantees D <= bound_d and |theta| <= bound_theta_um. events: the learner's counters.
    recovered: free-run error after one second of persistent excitation, divided by that of a fresh fit to that second
    with the same forgetting. recovered_whole: the same, divided by that of a fit without forgetting.
    paper_lost_at: first sample after which Eq. (10) in float32 has lost its covariance; None if there is none.
    """

    test: EnduranceTest
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
    paper_lost_at: int | None

    @property
    def holds(self) -> bool:
        """Whether all factors stayed finite, positive and bounded, and `recovered` is at most ALLOWED_RATIO."""
        bounded = self.largest_d <= self.bound_d and self.largest_theta_um <= self.bound_theta_um
        return self.broken_at is None and bounded and self.recovered <= ALLOWED_RATIO

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        values = asdict(self)
        test, lost_at = values.pop("test"), values.pop("paper_lost_at")
        return {"trial": test, **values, "printed_dies_at": lost_at, "holds": self.holds}


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


def rows(results: Sequence[EnduranceResult]) -> list[tuple[str, ...]]:
    """Table rows as text, one per result, under HEADINGS."""
    return [_row(result) for result in results]


def _row(result: EnduranceResult) -> tuple[str, ...]:
    test = result.test
    return (
        test.case,
        f"{test.forgetting:g}",
        f"{test.alpha:g}",
        f"{test.samples:.0e}",
        str(result.updates),
        f"{result.least_d:.1e} .. {result.largest_d:.1e}",
        f"{result.largest_u:.1e}",
        f"{result.largest_theta_um:.1e}",
        str(result.events["restarts"]),
        "hold" if result.broken_at is None else f"broken at {result.broken_at}",
        f"{result.recovered:.3f}",
        f"{result.recovered_whole:.3f}",
        "survives" if result.paper_lost_at is None else f"dies at {result.paper_lost_at}",
    )
