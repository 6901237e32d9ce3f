"""The score of a chain of causes, by which the search compares chains.

    score = N ln(R^2) + weights + sum over the parameters of order * ln N
            - sum over the causes of (2 ln(odds) + evidence)
    N     = R^2 / max(c R^2 / n, (R^2 - r^2) / n + r^2 / REPEATING)

R: rms of the residual on the n fitted rows, of which r repeats: the misfit of the hysteresis and the error of the
converter are the same whenever the stage passes the same states again, so that more rows do not average them out. They
count as REPEATING independent values. The rest is noise: what differs between neighbours, or moves while the stage
rests. c samples of it count as one (`dispersion`). odds: of a cause before the record (`Cause.prior_odds`); evidence:
of a direct observation (`Cause.evidence`). So an effect below the noise shows in a long record, and an effect far below
the misfit in none, unless it is observed where the misfit is absent. The difference of two scores is -2 ln of the odds
of the two chains, to the order of Schwarz's approximation; each weight also lowers N ln(R^2) by 1 on average if it fits
noise. A parameter whose standard error falls as n^(-k/2) has order k; the weights of one function count as its octaves.

Sources: Schwarz (1978); Kennedy and O'Hagan (2001) for a misfit that more data do not average out; Djuric (1996) for
the order 3 of a frequency.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes import causes
from hysgen.diagnosis.prepare import PROBE_LAGS
from hysgen.diagnosis.probe import Chain, Fit, Part, Scene, Trace, octaves, projector_off
from hysgen.diagnosis.probe.solve import block_left_out_error
from hysgen.model.remaining import LEAST_EVIDENCE
from hysgen.model.residual import dispersion, residual_noise
from hysgen.record.series import SHORTEST_PLATEAU, period_of, plateaus, resolution_um

Floats = NDArray[np.float64]

REPEATING = 37
"""Independent values of the misfit of the hysteresis: as many as the operator has weights for the same states."""

LEFT_OUT = 0.75
"""Power of the leverage in `Scored.left_out_error`: with 1/2 the scatter of a white error is right and that of coloured
noise too small, with 1 both are too large (Bell and McCaffrey, 2002). The mean of both powers is used."""

RESTING = 200
"""Least samples at rest from which a noise is taken: the standard error of its power is 10 %."""


@dataclass(frozen=True, eq=False)
class Scored:
    """A chain with what its score needs.

    fit: by least squares to `scene`. orders: sum of the orders of its parameters. weights: number of its weights that
    the rows determine.
    """

    scene: Scene
    fit: Fit
    orders: float
    weights: float

    @classmethod
    def of(cls, scene: Scene, fit: Fit) -> Self:
        size = determined(scene, fit)
        shape = sum(one.order for _, one in fit.chain.parameters)
        added = sum(part.weight_orders for part in fit.chain.parts)
        return cls(
            scene, fit, octaves(size) + shape + added, size + len(fit.weights) - scene.hysteresis_size(fit.chain)
        )

    @property
    def chain(self) -> Chain:
        return self.fit.chain

    @cached_property
    def independent(self) -> float:
        """N for white noise."""
        return self.independent_samples(1.0)

    def independent_samples(self, dispersion: float, apart: bool = False) -> float:
        """N, where `dispersion` samples of the residual count as one. apart: for the effect of a `Part.apart`."""
        power, rows = self.fit.rms_um**2 + 1e-300, len(self.scene.rows)
        if apart:
            return rows / dispersion
        repeating = self._repeating_um2
        return power / max(dispersion * power / rows, (power - repeating) / rows + repeating / REPEATING)

    @cached_property
    def _repeating_um2(self) -> float:
        """r^2: mean square of the residual beyond the noise, at least that of the sensor's steps."""
        power = self.fit.rms_um**2 + 1e-300
        noise = max(residual_noise(self.fit.error[self.scene.dense]), resting_noise(self.scene, self.fit)) ** 2
        steps = resolution_um(self.scene.y_um[self.scene.rows]) ** 2 / 12.0
        return min(max(power - noise, 0.0) + steps, power)

    def score(self, independent: float) -> float:
        """The score with a number of independent samples that is common to the compared chains."""
        penalty = self.orders * math.log(independent) + self.weights + prior_score(self.chain)
        return 2.0 * independent * math.log(self.fit.rms_um + 1e-300) + penalty - self.evidence

    @cached_property
    def evidence(self) -> float:
        """Evidence of the causes beside the residual."""
        return math.fsum(self._evidence_of.values())

    def adds_observed(self, smaller: Scored) -> bool:
        """Whether a part that the smaller chain has not is observed beside the residual, for or against it."""
        return any(self._evidence_of[part.cause] != 0.0 for part in self._added_to(smaller.chain))

    @cached_property
    def _evidence_of(self) -> dict[str, float]:
        return {name: cause.evidence(self.scene, self.fit) for name, cause in causes().items()}

    def fall_from(self, smaller: Scored, left_out: bool = False) -> float:
        """Fall of the score from a chain with fewer parts to this one.

        left_out: the samples that count as one are found from `left_out_error`. The weights of this chain fit coloured
        noise too, most of all where they are many, so that its own residual looks whiter than the noise. Memory is then
        judged by these samples alone: what is left of a vibration is no misfit of the hysteresis. Where the command
        repeats, whatever follows it does so too, and may be the misfit of the smaller chain.
        """
        rows, added = self.scene.rows, self._added_to(smaller.chain)
        error = self.left_out_error if left_out else self.fit.error[rows]
        few = dispersion(error, (smaller.fit.error - self.fit.error)[rows])
        apart = self._apart(smaller.chain, added, left_out)
        independent = self.independent_samples(few, apart=apart)
        follows = self.chain.memory == smaller.chain.memory and not apart and all(map(_repeats, self.scene.runs))
        if follows or any(part.flexible for part in added):
            independent = min(independent, smaller.independent_samples(few))
        return smaller.score(independent) - self.score(independent) - self._moved_at_rest(smaller)

    def _moved_at_rest(self, smaller: Scored) -> float:
        """2 ln of the likelihood ratio against this chain on the rows at rest; 0 where it leaves no more motion there.

            (n / c) ln(p^2 / q^2)        p, q: rms motion at rest of this chain and of the smaller one, n: rows at rest

        The misfit of the hysteresis is constant there and hides nothing: a part that moves what rests is not there.
        """
        lag_s = max(self.chain.lag_s, smaller.chain.lag_s)
        own, other = (np.concatenate([*at_rest(self.scene, fit.error, lag_s), []]) for fit in (self.fit, smaller.fit))
        risen = float(own @ own) / (float(other @ other) + 1e-300) if len(own) >= RESTING else 1.0
        return len(own) / dispersion(other, own - other) * math.log(risen) if risen > 1.0 else 0.0

    @cached_property
    def left_out_error(self) -> Floats:
        """(r,) residual as if the weights, which fit coloured noise too, were those of other blocks (LEFT_OUT)."""
        projector = projector_off(self.scene, self.chain, self.scene.training_columns(self.chain))
        return block_left_out_error(projector, self.fit.error[self.scene.rows], LEFT_OUT)

    def _added_to(self, smaller: Chain) -> list[Part]:
        """The parts that only this chain has."""
        known = {(type(part), part.names) for part in smaller.parts}
        return [part for part in self.chain.parts if (type(part), part.names) not in known]

    def _apart(self, smaller: Chain, added: Sequence[Part], left_out: bool) -> bool:
        """Whether the misfit averages out along all that is added: `Part.apart`, memory if blocks are left out."""
        if self.chain.memory != smaller.memory:
            return left_out and not added
        runs, Ts_s = self.scene.runs, self.scene.Ts_s
        return bool(added) and all(part.apart(runs, Ts_s) for part in added)


@functools.lru_cache(maxsize=8)
def _repeats(run: Trace) -> bool:
    """Whether the command of a run is periodic."""
    return period_of(run.u_V) is not None


def resting_noise(scene: Scene, fit: Fit) -> float:
    """Standard deviation of the residual while the stage rests (`at_rest`), less two standard errors of its square.

    The misfit of the hysteresis is constant there, so what moves is no misfit, but noise of any colour, or a vibration.
    The standard error is that between plateaus, because slow noise has few independent values on each. 0 with fewer
    than RESTING samples at rest.
    """
    moved = at_rest(scene, fit.error, fit.chain.lag_s)
    squares = np.array([float(error @ error) for error in moved])
    counts = np.array([len(error) - 1 for error in moved])
    if counts.sum() < RESTING:
        return 0.0
    power = float(squares.sum() / counts.sum())
    return math.sqrt(max(power - 2.0 * float(np.linalg.norm(squares - power * counts)) / float(counts.sum()), 0.0))


def at_rest(scene: Scene, error: Floats, lag_s: float) -> list[Floats]:
    """The residual, (n,), about its mean on each plateau of the command, from PROBE_LAGS lags of lag_s after a step on.

    Samples that are not fitted, such as corrupted ones, do not count.
    """
    used = np.zeros(scene.samples, dtype=np.bool_)
    used[scene.dense] = True
    first, moved = 0, []
    for run in scene.runs:
        settle = math.ceil(PROBE_LAGS * lag_s / (scene.Ts_s * run.stride))
        for begin, end in plateaus(run.u_V, settle + SHORTEST_PLATEAU):
            rows = slice(first + begin + settle, first + end)
            rest = error[rows][used[rows]]
            if len(rest) > 1:
                moved.append(rest - rest.mean())
        first += len(run.u_V)
    return moved


def least_growth(independent: float, prior_odds: float) -> float:
    """Least growth of the rms error without a cause of one parameter that is named."""
    least = LEAST_EVIDENCE - 2.0 * math.log(prior_odds) + math.log(independent) + 1.0
    return math.exp(0.5 * least / independent)


def determined(scene: Scene, fit: Fit) -> float:
    """Number of weights of the hysteresis that the rows determine to less than the span of the displacement (MacKay).

        sum over the eigenvalues x of the Gram matrix of the columns of h of  x / (x + (rms / span)^2)

    A command of a few levels determines as many weights as it has levels, however many the hysteresis has; of plays
    that relax, which move at rest too, it determines more.
    """
    level = (fit.rms_um / float(np.ptp(scene.y_um[scene.rows]))) ** 2 + 1e-300
    relaxing = tuple(part for part in fit.chain.amplifier if part.relaxation > 0.0)
    powers = _powers(scene, Chain(scene.Ts_s, relaxing, fit.chain.memory, fit.chain.curve))
    return float(np.sum(powers / (powers + level)))


@functools.lru_cache(maxsize=8)
def _powers(scene: Scene, chain: Chain) -> Floats:
    """Eigenvalues of the Gram matrix of the columns of h on the rows."""
    columns = np.hstack([part.h for part in scene.hysteresis(chain)])[:, scene.rows]
    return np.asarray(np.maximum(np.linalg.eigvalsh(columns @ columns.T), 0.0))


def prior_score(chain: Chain) -> float:
    """-2 ln of the odds of the causes of a chain before the record."""
    return -2.0 * math.fsum(math.log(causes()[name].prior_odds) for name in present(chain))


def structure(chain: Chain) -> Hashable:
    """Key for the parts of a chain without the values of their parameters."""
    return (chain.memory, chain.curve, *(part.names for part in chain.parts))


def present(chain: Chain) -> list[str]:
    """Names of the causes that the chain holds."""
    return [name for name, cause in causes().items() if cause.present(chain)]


def admissible(scene: Scene, fit: Fit) -> bool:
    """Whether every parameter of a part lies inside its physical bounds, and every cause acts (`Cause.admissible`)."""
    inside = all(
        one.inside(value, scene.extent)
        for part in fit.chain.parts
        for (_, one), value in zip(part.parameters, part.values, strict=True)
    )
    return inside and all(cause.admissible(scene, fit) for cause in causes().values())


def confidences(visited: list[Scored], final: Scored) -> dict[str, float]:
    """Posterior probability of each cause over the sets of causes of the visited chains.

        p(cause) = sum over sets with the cause, or one that holds it, of exp(-rise/2) / sum over all sets

    rise: least rise of the score from the final chain to one with this set, by the independent samples of what the
    larger of the two adds; at least 0, because the search has refused every other chain, by more than this one number.
    The final chain counts as visited.
    """
    rises = {frozenset(present(final.chain)): 0.0}
    for one in visited:
        names = frozenset(present(one.chain))
        rises[names] = min(rises.get(names, math.inf), max(_rise(final, one), 0.0))
    weights = {names: math.exp(-0.5 * rise) for names, rise in rises.items()}
    total = math.fsum(weights.values())
    holders = {name: {name, cause.held_by} for name, cause in causes().items()}
    return {name: math.fsum(w for names, w in weights.items() if names & holders[name]) / total for name in causes()}


def _rise(final: Scored, other: Scored) -> float:
    """Rise of the score from the final chain to another."""
    return final.fall_from(other, left_out=True) if final.orders >= other.orders else -other.fall_from(final)
