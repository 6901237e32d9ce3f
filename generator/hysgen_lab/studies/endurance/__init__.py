"""Endurance test of the compiled learner: long runs under poor excitation and corrupted samples, then a recovery test.

Each test feeds the generated C with one excitation, then with one second of persistent excitation. The free-run error
of the learned model is divided by that of a fresh fit to the same second. For comparison, Eq. (10) runs in float32,
exactly as the paper prints it, over the same samples.
"""

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from importlib import resources
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.float32.struct_words import LEARNER_COUNTERS
from hysgen.machine.native import build
from hysgen.model.learner_settings import LearnerSettings
from hysgen.model.model import Grid, Model
from hysgen.model.regression import rule_regressors
from hysgen_lab.stage import Stage
from hysgen_lab.studies.endurance.compiled_learner import (
    CompiledLearner,
    Excitation,
    Recovery,
    bench_model,
    excitations,
)

__all__ = [
    "ALLOWED_RATIO",
    "CASES",
    "HEADINGS",
    "EnduranceResult",
    "EnduranceTest",
    "bench_model",
    "endurance_tests",
    "rows",
    "run",
]

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


Floats = NDArray[np.float64]
Progress = Callable[[float, str], None]

PAPER_SAMPLES: Final = 100_000
"""Most samples over which Eq. (10) runs as printed."""

_PAPER_DECLARATION = """
uint64_t paper_recursion(size_t rows, size_t size, const float *regressors, const float *target, float lambda, float *P,
    float *q);
"""


def run(
    tests: Sequence[EnduranceTest],
    progress: Progress | None = None,
    stage: Stage | None = None,
    model: Model | None = None,
) -> list[EnduranceResult]:
    """Run every test in turn.

    progress: called with the fraction done and the test under way. stage: default Stage.nominal(). model: default
    `bench_model`; its learner settings apply, except forgetting, alpha and rest_V, which the test sets.
    """
    chosen = stage or Stage.nominal()
    base = model or bench_model(chosen)
    by_case, recovery = excitations(chosen), Recovery(chosen, base.grid.rules)
    total, done = sum(test.samples for test in tests), 0
    results = []
    for test in tests:

        def advance(samples: int, test: EnduranceTest = test, before: int = done) -> None:
            if progress is not None:
                progress((before + samples) / total, f"{test.case}, lambda {test.forgetting:g}")

        results.append(_result(test, by_case[test.case], base, recovery, advance))
        done += test.samples
    return results


def covariance_lost_at(y_um: Floats, u_V: Floats, grid: Grid, forgetting: float, alpha: float) -> int | None:
    """First sample after which Eq. (10) in float32 has P_ii <= 0 or a value that is not finite; None if there is none.

        K = P x/(lambda + x' P x),   q <- q + K (y(k+1) - x' q),   P <- (I - K x') P/lambda,   P(0) = alpha I, q(0) = 0

    y_um, u_V: (n,). All arithmetic is float32; x are the regressors of Eq. (9), not scaled.
    """
    text = resources.files(__package__).joinpath("paper_recursion.c").read_text(encoding="utf-8")
    library = build([("paper_recursion.c", text)], _PAPER_DECLARATION)
    x = np.ascontiguousarray(rule_regressors(y_um[:-1], u_V[:-1], grid), dtype=np.float32)
    target = np.ascontiguousarray(y_um[1:], dtype=np.float32)
    size = x.shape[1]
    P, q = np.float32(alpha) * np.eye(size, dtype=np.float32), np.zeros(size, dtype=np.float32)
    floats = [library.ffi.from_buffer("float *", array) for array in (x, target, P, q)]
    lost = int(library.lib.paper_recursion(x.shape[0], size, *floats[:2], forgetting, *floats[2:]))
    return lost or None


def _result(
    test: EnduranceTest, excitation: Excitation, base: Model, recovery: Recovery, advance: Callable[[int], None]
) -> EnduranceResult:
    settings = base.learner or LearnerSettings()
    # rest_V = 0 turns the detection of rest off: a learner that pauses at rest would pass the constant input untested.
    settings = dataclasses.replace(settings, forgetting=test.forgetting, alpha=test.alpha, rest_V=0.0)
    learner = CompiledLearner(dataclasses.replace(base, learner=settings))
    learner.start(float(excitation.y_um[0]), float(excitation.u_V[0]))
    learner.feed(excitation, test.samples, advance)
    extremes = learner.extremes
    events = {name: int(getattr(learner.learner, name)) for name in LEARNER_COUNTERS}
    result = EnduranceResult(
        test=test,
        updates=events.pop("updates"),
        broken_at=int(extremes.broken_at) or None,
        least_d=float(extremes.least_d),
        largest_d=float(extremes.largest_d),
        largest_u=float(extremes.largest_u),
        largest_theta_um=float(extremes.largest_theta),
        bound_d=float(learner.numbers.ceiling.max()),
        bound_theta_um=float(learner.numbers.limit_um),
        events=events,
        recovered=np.inf,
        recovered_whole=np.inf,
        paper_lost_at=_paper_lost_at(test, excitation, base),
    )
    # The recovery feeds further samples, so it comes after the extremes were read.
    recovered, whole = recovery.ratios(learner, test.forgetting)
    return dataclasses.replace(result, recovered=recovered, recovered_whole=whole)


def _paper_lost_at(test: EnduranceTest, excitation: Excitation, base: Model) -> int | None:
    """`covariance_lost_at` over the first PAPER_SAMPLES, without NaN and spikes: Eq. (10) does not reject samples."""
    rng = np.random.default_rng(20120321)
    repeated = np.arange(min(PAPER_SAMPLES, test.samples)) % excitation.u_V.size
    y_um = excitation.y_um[repeated] + rng.normal(0.0, excitation.noise_um, repeated.size)
    u_V = excitation.u_V[repeated] + rng.normal(0.0, max(excitation.noise_V, 1e-12), repeated.size)
    return covariance_lost_at(y_um, u_V, base.grid, test.forgetting, test.alpha)
