"""The evidence for a slow cause by two descriptions of the misfit, and for any cause by a second hysteresis operator.

    fall = (fall of the score + fall of the whitened score) / 2

The score (`score`) takes the misfit as values that repeat wherever they stand. The whitened score takes it as a process
along the way of the stage (`probe.solve`), which is constant while the stage rests: creep and drift show below
the misfit. Each of them alone is wrong where its description does not hold, so the mean of both logarithms of the odds
counts (logarithmic pool; Genest and Zidek, 1986).

    whitened score = n ln(Z^2) / c + orders ln(n / c) + weights - prior,    Z^2: mean square of the innovations

It counts only for the first slow cause of a chain: the course of a slow effect is known to a few per cent, and what is
left of it is slow too and would be named as a second one.

    fall = (fall by the operator of the search + fall by the second operator) / 2

What an operator misses depends on its form: a misfit that resembles a cause by chance does so for one operator, the
effect of a cause for each. The search has chosen the cause among all others by the first operator; the second one took
no part in that choice. Which of them describes the stage better is not known, so the mean of both logarithms of the
odds counts (logarithmic pool; Genest and Zidek, 1986).
"""

import dataclasses
import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from hysgen.diagnosis.causes import slow_causes, without_causes
from hysgen.diagnosis.probe import Chain, Fit, Scene, WhitenedScene, refine
from hysgen.diagnosis.score import Scored, present, prior_score, structure
from hysgen.model.residual import block_edges, dispersion

WHITENED_ROUNDS = 4
"""Gauss-Newton rounds on the innovations, from a chain that is refined by least squares already."""

LOUDEST = 4
"""Blocks of 40 that are no evidence alone: an effect over the length of the record shows in more than a tenth of it."""


@dataclass(frozen=True, eq=False)
class Whitenings:
    """Whitened scenes, one for the residual of each chain, and the fits of chains to them; each is made once."""

    scene: Scene
    _scenes: dict[Chain, WhitenedScene] = field(default_factory=dict)
    _fits: dict[tuple[Chain, Chain], Fit] = field(default_factory=dict)

    def fit(self, chain: Chain, residual: Fit) -> Fit:
        """The fit of a chain to the innovations of the scene, whitened for a residual; rms_um is Z."""
        if residual.chain not in self._scenes:
            self._scenes[residual.chain] = WhitenedScene.of(self.scene, residual)
        key = (chain, residual.chain)
        if key not in self._fits:
            self._fits[key] = refine(self._scenes[residual.chain], chain, WHITENED_ROUNDS)
        return self._fits[key]

    def pooled_fall(self, larger: Scored, smaller: Scored, least: float) -> float:
        """Fall of the pooled score to a chain with the first slow cause, or with another form of it.

        least: where the fall of the score alone makes the pooled one larger than this, a lower bound of it is returned.
        """
        fall = larger.fall_from(smaller, left_out=True)
        worst = fall - penalty(larger, smaller, float(len(self.scene.rows)))
        if worst > 2.0 * least:
            return 0.5 * worst
        return 0.5 * (fall + self.whitened_fall(larger, smaller))

    def whitened_fall(self, larger: Scored, smaller: Scored) -> float:
        """Fall of the whitened score; the residuals are whitened for that of the smaller chain.

        At most 0 if the rest of the record contradicts the LOUDEST blocks. The other parts of the smaller chain are
        fitted from those of the larger one, too: a minimum that only one of both fits finds is no evidence.
        """
        rows = self.scene.rows
        after = self.fit(larger.chain, smaller.fit)
        less = without_causes(after.chain, slow_causes())
        chains = [smaller.chain] if slow_part(smaller) else [smaller.chain, less]
        before = min((self.fit(chain, smaller.fit) for chain in chains), key=lambda fit: fit.rms_um)
        independent = len(rows) / dispersion(after.error[rows], (before.error - after.error)[rows])
        fall = 2.0 * independent * math.log(before.rms_um / after.rms_um) - penalty(larger, smaller, independent)
        falls = np.add.reduceat((before.error**2 - after.error**2)[rows], block_edges(len(rows))[:-1])
        return fall if np.sort(falls)[:-LOUDEST].sum() > 0.0 else min(fall, 0.0)

    def scores(self, candidates: Sequence[Scored], residual: Fit) -> list[float]:
        """Whitened scores of chains with as many causes, for one whitening: that of the residual of a fit.

        All samples count (c = 1): what the residual contains beside the innovations is common to the chains.
        """
        rows, scores = len(self.scene.rows), []
        for one in candidates:
            fit = self.fit(one.chain, residual)
            penalty = one.orders * math.log(rows) + one.weights + prior_score(one.chain)
            scores.append(rows * fit.rms_um**2 + penalty)
        return scores

    def confidence(self, current: Scored, bare: Scored, bayes: float, visited: Sequence[Scored]) -> float:
        """Posterior probability of the only slow cause of the current chain, against none and against each other one.

        bare: the chain without it; bayes: rise of the pooled score to that. visited: the chains that the search scored;
        each is at most as likely, because the search did not exchange the cause.
        """
        others = set(present(current.chain)) - slow_part(current)
        rivals: dict[str, Scored] = {}
        for one in sorted(visited, key=lambda one: one.score(current.independent)):
            for name in slow_part(one) - slow_part(current):
                if set(present(one.chain)) == {*others, name}:
                    rivals.setdefault(name, one)
        own, *scores = self.scores([current, *rivals.values()], bare.fit)
        odds_against = [math.exp(-0.5 * bayes), *(math.exp(min(0.5 * (own - score), 0.0)) for score in scores)]
        return 1.0 / (1.0 + math.fsum(odds_against))


def slow_part(one: Scored) -> set[str]:
    """Names of the slow causes of a chain."""
    return set(slow_causes()).intersection(present(one.chain))


def adds_first_slow_cause(larger: Scored, smaller: Scored) -> bool:
    """Whether a chain has one slow cause and a smaller one none."""
    return len(slow_part(larger)) == 1 and not slow_part(smaller)


def differs_in_its_slow_cause(larger: Scored, smaller: Scored) -> bool:
    """Whether two chains have the same one slow cause, simpler in the smaller one, and are equal otherwise."""
    slow = slow_part(larger)
    return (
        len(slow) == 1
        and slow == slow_part(smaller)
        and larger.orders > smaller.orders
        and _beside_slow_causes(larger) == _beside_slow_causes(smaller)
    )


def _beside_slow_causes(one: Scored) -> Hashable:
    return structure(without_causes(one.chain, slow_causes()))


def penalty(larger: Scored, smaller: Scored, independent: float) -> float:
    """Rise of the score by the parameters and the prior odds of the larger chain alone."""
    rise = (larger.orders - smaller.orders) * math.log(independent) + larger.weights - smaller.weights
    return rise + prior_score(larger.chain) - prior_score(smaller.chain)


ROUNDS = 8
"""Gauss-Newton rounds of a fit, from a chain that is refined with the first operator already."""


@dataclass(frozen=True, eq=False)
class SecondOperator:
    """The scene with the second operator, and the fits of chains to it; each is made once."""

    first: Scene
    _scored: dict[Chain, Scored] = field(default_factory=dict)

    @cached_property
    def scene(self) -> Scene:
        """Twice the hat functions, polynomials of more degrees, decay lengths between those of the first operator."""
        own = self.first.operator
        last = own.reaches[-1:]
        reaches = (*(0.5**0.5 * reach for reach in own.reaches), *(2.0**0.5 * reach for reach in last))
        finer = dataclasses.replace(own, hats=2 * own.hats, degree=own.degree + 2, curve=own.curve + 4, reaches=reaches)
        return dataclasses.replace(self.first.bare(), operator=finer)

    @cached_property
    def whitenings(self) -> Whitenings:
        return Whitenings(self.scene)

    def scored(self, chain: Chain) -> Scored:
        """The chain, fitted with this operator."""
        if chain not in self._scored:
            self._scored[chain] = Scored.of(self.scene, refine(self.scene, chain, ROUNDS))
        return self._scored[chain]
