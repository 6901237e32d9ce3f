"""Each protection of the learner does what its name says and tells so, and is missed where it is taken out."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from fixtures.learner_bench import Pair, lagging, sized, texts_of
from hysgen.float32.learner_status import LearnerStatus

Floats32 = NDArray[np.float32]
Words = NDArray[np.uint32]

LEARNT = 3000
"""Samples of good excitation after which the learner knows the plant."""


class Watched:
    """A compiled learner of six parameters that has learnt for LEARNT samples, and what happens to it afterwards."""

    def __init__(self, settings: dict[str, Any], edit: tuple[str, str] | None) -> None:
        self.pair = _pair(tuple(settings.items()), edit)
        self.pair.host.call("learn_init", self.pair.learner, self.pair.host.instance(2.0, 30.0))
        self.paths = list(self.pair.lane.words())
        self.numbers = self.pair.lane.numbers
        self.y_um, self.u_V = lagging(LEARNT + 4000)
        self.at = 0
        self.go(LEARNT)
        self.learner.status = 0

    @property
    def learner(self) -> Any:
        return self.pair.learner

    def next(self, samples: int) -> tuple[Floats32, Floats32]:
        """The coming samples of the plant, to be spoilt before they are fed."""
        ahead = slice(self.at, self.at + samples)
        self.at += samples
        return self.y_um[ahead].copy(), self.u_V[ahead].copy()

    def go(self, samples: int) -> Words:
        return self.feed(*self.next(samples))

    def feed(self, y_um: Floats32, u_V: Floats32) -> Words:
        """The state after each sample, (n, words)."""
        return self.pair.run(y_um, u_V)

    def values(self, trace: Words, name: str) -> Floats32:
        """A number or vector of the struct over a trace, (n, size)."""
        places = [i for i, path in enumerate(self.paths) if path == name or path.startswith((f"{name}[", f"{name},"))]
        return np.ascontiguousarray(trace[:, places]).view(np.float32)

    def told(self, bit: LearnerStatus) -> bool:
        return bool(self.learner.status & bit)


@functools.lru_cache(maxsize=4)
def _pair(settings: tuple[tuple[str, Any], ...], edit: tuple[str, str] | None) -> Pair:
    model = sized(6, **dict(settings))
    texts = texts_of(model)
    if edit is not None:
        assert edit[0] in texts["smooth_2.c"], f"the fault has nothing to bite on: {edit[0]}"
        texts["smooth_2.c"] = texts["smooth_2.c"].replace(*edit)
    return Pair(model, texts)


def nothing_learnt(watched: Watched, trace: Words) -> bool:
    """Parameters and covariance keep every bit."""
    same = [
        bool((trace[:, i] == trace[0, i]).all())
        for i, path in enumerate(watched.paths)
        if path[0] in "ud" and "[" in path
    ]
    theta = watched.values(trace, "theta")
    return all(same) and bool((theta.view(np.uint32) == theta[0].view(np.uint32)).all())


def samples_that_are_no_numbers_teach_nothing(watched: Watched) -> bool:
    y, u = watched.next(41)
    y[1::5], y[2::5], y[3::5], u[4::5] = np.nan, np.inf, 1e30, -np.inf
    y[5::5] = np.nan
    trace = watched.feed(y, u)
    whole = bool(np.isfinite(watched.values(trace, "theta")).all())
    return whole and nothing_learnt(watched, trace[1:]) and watched.told(LearnerStatus.REJECTED)


def a_single_outlier_teaches_nothing(watched: Watched) -> bool:
    y, u = watched.next(20)
    y[10] += np.float32(0.3)
    before = int(watched.learner.outliers)
    trace = watched.feed(y, u)
    return (
        nothing_learnt(watched, trace[9:11])
        and watched.learner.outliers > before
        and watched.told(LearnerStatus.OUTLIER)
    )


def outliers_without_end_are_a_change_and_are_learnt(watched: Watched) -> bool:
    y, u = watched.next(400)
    watched.feed(y + np.where(np.arange(400) % 2, 0.3, -0.3).astype(np.float32), u)
    return int(watched.learner.changes) > 0 and watched.told(LearnerStatus.CHANGED)


def an_innovation_inside_the_dead_zone_teaches_nothing(watched: Watched) -> bool:
    before = int(watched.learner.quiet)
    trace = watched.go(40)
    # One update in eight puts back the prior, whatever the innovation.
    between = any(nothing_learnt(watched, trace[k : k + 6]) for k in range(8, 16))
    return int(watched.learner.quiet) - before >= 30 and between and watched.told(LearnerStatus.QUIET)


def an_input_at_rest_teaches_nothing(watched: Watched) -> bool:
    y, u = watched.next(3000)
    trace = watched.feed(y, np.full_like(u, u[0]))
    return nothing_learnt(watched, trace[2500:]) and watched.told(LearnerStatus.RESTING)


def no_parameter_moves_further_than_its_limit_per_update(watched: Watched) -> bool:
    y, u = watched.next(400)
    trace = watched.feed(y + np.float32(0.3), u)
    # One rounding of theta on top of the limit.
    theta = watched.values(trace, "theta").astype(np.float64)
    allowed = float(watched.numbers.step_um) + np.spacing(np.float32(np.abs(theta).max()))
    return bool(np.abs(np.diff(theta, axis=0)).max() <= allowed) and watched.told(LearnerStatus.LIMITED)


def a_displacement_outside_the_range_teaches_nothing(watched: Watched) -> bool:
    y, u = watched.next(40)
    y[10:30] = 9.4
    trace = watched.feed(y, u)
    # What sample 9 had to predict may still be an outlier or teach; from there on nothing is kept to learn from.
    return nothing_learnt(watched, trace[11:30]) and watched.told(LearnerStatus.OUTSIDE)


def a_shadow_worse_than_the_reference_starts_again(watched: Watched) -> bool:
    """The reference is what was learnt; the shadow is pushed off it and held there by a covariance that is spent."""
    learner = watched.learner
    for i in range(watched.numbers.size):
        learner.reference[i] = learner.theta[i]
        learner.theta[i] = learner.theta[i] * 1.2
        learner.d[i] = 2.0**-40
    watched.go(1500)
    return int(learner.restarts) > 0 and watched.told(LearnerStatus.RESTARTED)


def a_parameter_beyond_its_limit_starts_again(watched: Watched) -> bool:
    watched.learner.theta[2] = 2.0 * float(watched.numbers.limit_um)
    trace = watched.go(60)
    least = float(np.abs(watched.values(trace, "theta")).max(axis=1)[-1])
    return least < float(watched.numbers.limit_um) and watched.told(LearnerStatus.RESTARTED)


def variances_stay_below_their_ceiling(watched: Watched) -> bool:
    """An update with a prior far too large, as a bit flipped in memory would leave it."""
    for i in range(watched.numbers.size):
        watched.learner.d[i] = 1.5 * float(watched.numbers.ceiling[i])
    trace = watched.go(30)
    return bool((watched.values(trace, "d")[10:] <= watched.numbers.ceiling).all()) and watched.told(
        LearnerStatus.CLAMPED
    )


Protection = tuple[Callable[[Watched], bool], dict[str, Any], tuple[str, str]]
PROTECTIONS: list[Protection] = [
    (
        samples_that_are_no_numbers_teach_nothing,
        {},
        ("const uint32_t usable = 1u ^ (y_lost | implausible);", "const uint32_t usable = 1u; (void)implausible;"),
    ),
    (a_single_outlier_teaches_nothing, {}, ("outlier = far & (changed ^ 1u);", "outlier = 0u;")),
    (
        outliers_without_end_are_a_change_and_are_learnt,
        {},
        ("changed = (uint32_t)(self->run >= SMOOTH_2_LEARN_OUTLIER_RUN);", "changed = 0u;"),
    ),
    (
        an_innovation_inside_the_dead_zone_teaches_nothing,
        {"dead_zone_um": 0.2},
        ("return (outlier | quiet) ^ 1u;", "return outlier ^ 1u;"),
    ),
    (an_input_at_rest_teaches_nothing, {}, ("if (self->rested == 0u)", "if (1)")),
    (
        no_parameter_moves_further_than_its_limit_per_update,
        {"step_um": 1e-4},
        ("if (size > SMOOTH_2_LEARN_STEP_UM)", "if (0)"),
    ),
    (a_displacement_outside_the_range_teaches_nothing, {}, ("self->fresh = outside ^ 1u;", "self->fresh = 1u;")),
    (
        a_shadow_worse_than_the_reference_starts_again,
        {"settle": 512, "lost": 1e3},
        ("(uint32_t)(self->error > SMOOTH_2_LEARN_WORSE * self->reference_error)", "0u"),
    ),
    (a_parameter_beyond_its_limit_starts_again, {}, ("    return beyond;\n", "    return 0u * beyond;\n")),
    (
        variances_stay_below_their_ceiling,
        {},
        ("learn_ceiling[j], &limited", "learn_ceiling[j] * ((j == 3u) ? 1e6f : 1.0f), &limited"),
    ),
]


@pytest.mark.parametrize(("promise", "settings", "edit"), PROTECTIONS, ids=lambda given: getattr(given, "__name__", ""))
@pytest.mark.slow
def test_protection_holds_and_is_missed_where_it_is_taken_out(
    promise: Callable[[Watched], bool], settings: dict[str, Any], edit: tuple[str, str]
) -> None:
    assert promise(Watched(settings, None))
    assert not promise(Watched(settings, edit))
