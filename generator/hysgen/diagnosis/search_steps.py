"""One step of the search for a chain (`search`): which chains it compares, and which of them is accepted."""

import dataclasses
import functools
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from hysgen.diagnosis.causes import Cause, Residual, causes, slow_causes, without_causes
from hysgen.diagnosis.probe import Chain, Fit, Scene, TrainingFit, refine, training_fit
from hysgen.diagnosis.score import Scored, admissible, present
from hysgen.diagnosis.slow_evidence import (
    SecondOperator,
    Whitenings,
    adds_first_slow_cause,
    differs_in_its_slow_cause,
    penalty,
)
from hysgen.machine.processes import in_processes
from hysgen.model.remaining import LEAST_EVIDENCE

LAGS = (0.3, 3.0, 30.0)
"""Starting values of the lag in samples: a lag that a limit or a delay has taken over lies at the end of its range."""

FIRST_ROUNDS, ROUNDS = 3, 8
"""Gauss-Newton rounds for a candidate: before its score is foreseen, and in all."""

PROJECTORS = 4
"""Linear fits of the proposals of a cause that keep their projectors: about as many as are refined."""


@dataclass(eq=False)
class State:
    """The chain of a search on its rows, every chain scored on these rows, and the fits of chains with a part less."""

    scene: Scene
    current: Scored
    whitenings: Whitenings
    visited: list[Scored]
    smaller: dict[Chain, Fit] = field(default_factory=dict)

    @functools.cached_property
    def second(self) -> SecondOperator:
        """The scene by the second operator."""
        return SecondOperator(self.scene)

    def fits_of_smaller(self, chains: Sequence[Chain]) -> list[Fit]:
        """The fits of chains with a part less, from the best lag, in their order; each chain is fitted once."""
        new = [chain for chain in dict.fromkeys(chains) if chain not in self.smaller]
        fits = in_processes(functools.partial(_refined_from_best_lag, self.scene), new)
        self.smaller |= zip(new, fits, strict=True)
        return [self.smaller[chain] for chain in chains]

    def scored(self, fits: Sequence[Fit], bounded: bool = True) -> list[Scored]:
        """The fits with their scores, the least score first. bounded: only the admissible ones."""
        found = [Scored.of(self.scene, fit) for fit in fits if not bounded or admissible(self.scene, fit)]
        self.visited += found
        return sorted(found, key=lambda one: one.score(self.current.independent))


def next_step(state: State, added: dict[str, Scored]) -> Scored | None:
    """The accepted chain, None if no chain is: an addition, else a drop or an exchange, else a first slow cause.

    added: of `best_additions`.
    """
    likelier = (one for one in added.values() if fall_of_addition(one, state.current) > LEAST_EVIDENCE)
    accepted = next((one for one in likelier if rise_without(state, one, state.current) > LEAST_EVIDENCE), None)
    return accepted or _dropped_or_exchanged(state) or _slow_addition(state, added)


def best_additions(state: State) -> dict[str, Scored]:
    """By cause, the chain of least score with one more part of it; the largest fall of the score first."""
    part, current = state.scene, state.current
    residual = Residual(part, current.fit)
    # Each proposal of a part of the amplifier requires a hysteresis of its own.
    of_causes = in_processes(
        functools.partial(_starts, residual=residual),
        causes().values(),
        cost=lambda cause: cause.part is not None and cause.part.amplifies,
    )
    starts = [(name, candidate) for name, of_cause in zip(causes(), of_causes, strict=True) for candidate in of_cause]
    fits = _refined_if_promising(state, [start for _, start in starts])
    fits = [_with_acting_causes(part, fit, name) for (name, _), fit in zip(starts, fits, strict=True)]
    cause_of = {id(fit): name for (name, _), fit in zip(starts, fits, strict=True)}
    return best_of_causes([(cause_of[id(one.fit)], one) for one in state.scored(fits)], current)


def best_of_causes(scored: Sequence[tuple[str, Scored]], current: Scored) -> dict[str, Scored]:
    """The best chain of each cause, the largest fall of the score from the current chain first.

    Falls count by other independent samples where a part is apart (`Part.apart`): of two chains with one cause, the
    one that leaves less with fewer parameters is taken whatever they say.
    """
    best: dict[str, Scored] = {}
    for name, one in sorted(scored, key=lambda named: -fall_of_addition(named[1], current)):
        first = best.setdefault(name, one)
        if one.fit.rms_um < first.fit.rms_um and one.orders < first.orders:
            best[name] = one
    return best


def fall_of_addition(larger: Scored, current: Scored) -> float:
    """Fall of the score from the current chain to a larger one, less LEAST_EVIDENCE for each part beyond the first.

    Otherwise parts that are added together could be dropped one by one, and added again.
    """
    counts = [
        sum(len(cause.without_one_part(one.chain)) for cause in causes().values() if cause.present(one.chain))
        for one in (current, larger)
    ]
    return larger.fall_from(current) - max(counts[1] - counts[0] - 1, 0) * LEAST_EVIDENCE


def _slow_addition(state: State, added: dict[str, Scored]) -> Scored | None:
    """The likeliest chain with a first slow cause, None if its pooled score does not fall by LEAST_EVIDENCE."""
    candidates = [one for one in added.values() if adds_first_slow_cause(one, state.current)]
    if not candidates:
        return None
    best = candidates[int(np.argmin(state.whitenings.scores(candidates, state.current.fit)))]
    return best if rise_without(state, best, state.current) > LEAST_EVIDENCE else None


def _starts(cause: Cause, residual: Residual) -> list[TrainingFit]:
    """The proposals of a cause that are refined, by linear fits."""
    return cause.select_starts(_fitted(residual.scene, cause.proposals(residual)))


def _dropped_or_exchanged(state: State) -> Scored | None:
    """The chain with one part less or exchanged, None if no such chain is accepted."""
    chain = state.current.chain
    names = present(chain)
    slow = [name for name in slow_causes() if name in names]
    less = [one for name in names for one in causes()[name].simpler_forms(chain)]
    less += [one for name in names for one in causes()[name].without_one_part(chain)]
    less += chains_without_a_cause(state)
    if len(slow) > 1:
        less.append(without_causes(chain, slow))
    dropped = state.scored(state.fits_of_smaller(list(dict.fromkeys(less))))
    for one in dropped:
        fewer = max(1, len(names) - len(present(one.chain)))
        if rise_without(state, state.current, one) < fewer * LEAST_EVIDENCE and _form_is_evident(state, one, dropped):
            return one
    pairs = [(old, new) for old in names for new in causes() if new not in names and similar(old, new)]
    for old, new in pairs:
        bare = next((one for one in dropped if old not in present(one.chain)), None)
        other = None if bare is None else _best_with(state, bare, new)
        if bare is None or other is None:
            continue
        either_slow = bool({old, new} & set(slow_causes()))
        if _likelier(state, other, bare, either_slow) and rise_without(state, other, bare) >= LEAST_EVIDENCE:
            return other
    return None


def chains_without_a_cause(state: State) -> list[Chain]:
    """The current chain without each of its causes, and the fuller forms of what is similar to the one left out."""
    names, chains = present(state.current.chain), []
    for name in names:
        bare = causes()[name].without(state.current.chain)
        chains.append(bare)
        for other in (other for other in names if other != name and similar(name, other)):
            chains += causes()[other].fuller_forms(bare, state.scene)
    return chains


def leaves_out_a_cause(state: State, step: Scored) -> bool:
    """Whether a step leads to a chain without a cause of the current chain that is not evident."""
    fewer = set(present(step.chain)) < set(present(state.current.chain))
    return fewer and rise_without(state, state.current, step) < LEAST_EVIDENCE


def _form_is_evident(state: State, one: Scored, dropped: Sequence[Scored]) -> bool:
    """Whether a chain has no simpler form of the only slow cause, or one that is evident itself."""
    if not differs_in_its_slow_cause(state.current, one):
        return True
    bare = [less for less in dropped if adds_first_slow_cause(one, less)]
    return all(rise_without(state, one, less) >= LEAST_EVIDENCE for less in bare)


def _best_with(state: State, bare: Scored, name: str) -> Scored | None:
    """The chain with the least score that adds the cause `name` to `bare`."""
    starts = _starts(causes()[name], Residual(state.scene, bare.fit))
    return next(iter(state.scored(_refined_if_promising(state, starts))), None)


def rise_without(state: State, larger: Scored, less: Scored) -> float:
    """Rise of the score from a chain to one with less; of the pooled score if they differ in the only slow cause.

    Where the evidence is small, the mean with that by the second operator. It is not asked where it could not make the
    mean smaller than LEAST_EVIDENCE, because a larger chain leaves no larger residual, nor about causes that are seen
    where the misfit of the hysteresis is absent.
    """
    rise = _rise_by_one_operator(state.whitenings, larger, less)
    least = rise - penalty(larger, less, float(len(state.scene.rows)))
    if rise <= 0.0 or least > 2.0 * LEAST_EVIDENCE or larger.adds_observed(less):
        return rise
    both = [state.second.scored(one.chain) for one in (larger, less)]
    return 0.5 * (rise + _rise_by_one_operator(state.second.whitenings, *both))


def _rise_by_one_operator(whitenings: Whitenings, larger: Scored, less: Scored) -> float:
    if adds_first_slow_cause(larger, less) or differs_in_its_slow_cause(larger, less):
        return whitenings.pooled_fall(larger, less, LEAST_EVIDENCE)
    return larger.fall_from(less, left_out=True)


def _likelier(state: State, other: Scored, bare: Scored, slow: bool) -> bool:
    """Whether a chain is likelier than the current one, which has as many causes. bare: the chain without both.

    slow: whether a slow cause is exchanged. If the score does not decide by LEAST_EVIDENCE against the other chain, the
    sum of both scores decides then (`slow_evidence`).
    """
    current = state.current
    fall = current.score(current.independent) - other.score(current.independent)
    if not slow or fall < -LEAST_EVIDENCE:
        return fall > 0.0
    before, after = state.whitenings.scores([current, other], bare.fit)
    return fall + before - after > 0.0


def similar(name: str, other: str) -> bool:
    """Whether two causes have a similar effect, so that the search exchanges them."""
    both_slow = name in slow_causes() and other in slow_causes()
    return both_slow or other in causes()[name].mistaken_for or name in causes()[other].mistaken_for


def with_best_lag(part: Scene, chain: Chain) -> Chain:
    """The chain with its own lag or one of LAGS, whichever leaves the least error before a refinement."""
    lags = [chain.lag_s, *(scale * part.Ts_s for scale in LAGS)]
    return _fitted(part, [dataclasses.replace(chain, lag_s=lag_s) for lag_s in lags])[0].chain


def _fitted(part: Scene, chains: Sequence[Chain]) -> list[TrainingFit]:
    """Linear least-squares fits of the chains to the rows of the scene, sorted by rms error.

    Only the best few keep their projectors, which are as large as their columns: the rest are rarely refined.
    """
    fits = list[TrainingFit]()
    for chain in chains:
        fits = sorted([*fits, training_fit(part, chain)], key=lambda candidate: candidate.rms_um)
        fits[PROJECTORS:] = [dataclasses.replace(candidate, projector=None) for candidate in fits[PROJECTORS:]]
    return fits


def _refined_from_best_lag(part: Scene, chain: Chain) -> Fit:
    """Fit of the linear and the shape parameters from a chain, with its best lag, as the starting value."""
    return refine(part, with_best_lag(part, chain), ROUNDS)


def _refined_if_promising(state: State, starts: Sequence[TrainingFit]) -> list[Fit]:
    """Fits from each start, with FIRST_ROUNDS rounds only if the rest could not make them better than the current fit.

    The rest of the rounds is taken to lower the error by the same factor as the first ones, which is optimistic.
    """
    refined = functools.partial(_refined_start, state.current)
    return in_processes(refined, starts, cost=lambda start: len(start.chain.amplifier))


def _refined_start(current: Scored, start: TrainingFit) -> Fit:
    """The fit of `_refined_if_promising` from one start."""
    part = current.scene
    first = refine(part, start.chain, FIRST_ROUNDS, start)
    hoped_um = first.rms_um * min(first.rms_um / start.rms_um, 1.0)
    hoped = Scored.of(part, dataclasses.replace(first, rms_um=hoped_um))
    return refine(part, first.chain, ROUNDS - FIRST_ROUNDS) if hoped.fall_from(current) > 0.0 else first


def _with_acting_causes(part: Scene, fit: Fit, added: str) -> Fit:
    """The fit without the causes that an added cause leaves no effect for (`Cause.admissible`)."""
    idle = [name for name in present(fit.chain) if name != added and not causes()[name].admissible(part, fit)]
    return refine(part, without_causes(fit.chain, idle), ROUNDS) if idle else fit
