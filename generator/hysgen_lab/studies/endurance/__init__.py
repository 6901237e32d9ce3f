"""Endurance test of the compiled learner: long runs under poor excitation and corrupted samples, then a recovery test.

Each test feeds the generated C with one excitation, then with one second of persistent excitation. The free-run error
of the learned model is divided by that of a fresh fit to the same second. For comparison, Eq. (10) runs in float32,
exactly as the paper prints it, over the same samples.
"""

import dataclasses
from collections.abc import Callable, Sequence
from importlib import resources
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hysgen.float32.struct_words import LEARNER_COUNTERS
from hysgen.machine.native import build
from hysgen.model.learner_settings import LearnerSettings
from hysgen.model.model import Grid, Model
from hysgen.model.regression import rule_regressors
from hysgen_lab.stage import Stage
from hysgen_lab.studies.endurance.compiled_learner import CompiledLearner, Recovery, bench_model
from hysgen_lab.studies.endurance.excitations import Excitation, excitations
from hysgen_lab.studies.endurance.results import (
    ALLOWED_RATIO,
    CASES,
    HEADINGS,
    EnduranceResult,
    EnduranceTest,
    endurance_tests,
    rows,
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
