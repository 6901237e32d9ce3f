"""Search for the chain with the least score (`score`): parts are added, dropped and exchanged while the score falls.

    add       every cause proposes chains with one more part at starting values; the best few are fitted and scored
    drop      a part, a form of a part, a cause, all slow causes, if the score rises by less than LEAST_EVIDENCE a cause
    exchange  a part for a similar one (`Cause.mistaken_for`, slow causes for each other), if the score falls

A part is added if the score falls by LEAST_EVIDENCE, several at once if it falls by as many times that. Each step fits
all parameters of the chain jointly, so an effect that was first attributed to the wrong cause moves to the right one.
Every scored chain counts in the confidences.
"""

from __future__ import annotations

import dataclasses
import functools
import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes import Cause, Residual, causes, slow_causes
from hysgen.diagnosis.outlier_detection import outlier_flags
from hysgen.diagnosis.probe import (
    Chain,
    Fit,
    Scene,
    TrainingFit,
    linear_fit,
    refine,
    rms,
    training_fit,
)
from hysgen.diagnosis.score import LEAST_EVIDENCE, Scored, admissible, confidences, present, structure
from hysgen.diagnosis.slow_evidence import Whitenings, adds_first_slow_cause, differs_in_its_slow_cause, slow_part
from hysgen.machine.processes import in_processes
from hysgen.record.series import resolution_um

Progress = Callable[[str], None]

MOST_STEPS = 20
"""Largest number of steps; no structure is taken twice with the same error, so the search also ends without it."""

BETTER = 0.01
"""Least fall of the rms error by which a structure is taken again: the second fit found another minimum."""

MOST_ROWS = 8000
"""Rows above which a scene is thinned out for a fit."""

LAGS = (0.3, 3.0, 30.0)
"""Starting values of the lag in samples: a lag that a limit or a delay has taken over lies at the end of its range."""

FIRST_ROUNDS, ROUNDS = 3, 8
"""Gauss-Newton rounds for a candidate: before its score is foreseen, and in all."""


@dataclass(frozen=True, eq=False)
class SearchResult:
    """Result of `search`.

    fit: of the final chain to all usable rows of the identification part. rivals: the fit without each cause of the
    chain. corrupted: (n,) flags of the corrupted samples. bayes: rise of the score without each cause; refused: fall of
    the score by each cause not in the chain, at most LEAST_EVIDENCE. error_growth: ratio of the rms errors without and
    with each cause. confidence: posterior probability of each.
    """

    scene: Scene
    fit: Fit
    rivals: dict[str, Fit]
    corrupted: NDArray[np.bool_]
    bayes: dict[str, float]
    refused: dict[str, float]
    error_growth: dict[str, float]
    confidence: dict[str, float]


@dataclass(eq=False)
class _State:
    """The chain of a search on its rows, every chain scored on these rows, and the fits of chains with a part less."""

    scene: Scene
    current: Scored
    whitenings: Whitenings
    visited: list[Scored]
    smaller: dict[Chain, Fit] = field(default_factory=dict)

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


def search(scene: Scene, progress: Progress = lambda line: None) -> SearchResult:
    """The chain with the least score, from the hysteresis and one lag on."""
    fit = _start(scene)
    usable, corrupted = _without_outliers(scene, fit)
    part = thinned(usable)
    state = _begin(part, refine(part, fit.chain))
    added: dict[str, Scored] = {}
    # A search may come back to a structure: causes are exchanged by another measure than they are added and dropped by,
    # and a part that was dropped again may have led the fit out of a local minimum.
    least_um = {structure(state.current.chain): state.current.fit.rms_um}
    for _ in range(MOST_STEPS):
        added = _best_additions(state)
        step = next((one for one in added.values() if _accepted(state, one)), None)
        step = step or _dropped_or_exchanged(state) or _slow_addition(state, added)
        if step is None:
            break
        if step.fit.rms_um > (1.0 - BETTER) * least_um.get(structure(step.chain), np.inf):
            if _leaves_out_a_cause(state, step):
                # No addition to this chain is known, but it holds nothing that is not evident.
                state.current, added = step, {}
            break
        least_um[structure(step.chain)] = step.fit.rms_um
        progress(f"{', '.join(present(step.chain)) or 'lag'}: {1e3 * rms(step.fit.error[part.rows]):.3g} nm")
        state.current = step
        before = len(usable.rows)
        usable, corrupted = _without_outliers(scene, step.fit)
        if len(usable.rows) != before:
            # Scores of different rows do not compare.
            part = thinned(usable)
            state = _begin(part, refine(part, step.chain, ROUNDS))
    return _result(usable, corrupted, state, added)


def over_all_rows(found: SearchResult, whole: Scene) -> Residual:
    """The residual of the final chain, and the corrupted samples, of a scene with all rows of the record.

    If the search looked at blocks of these rows (`excerpt`), the weights are fitted again to rows of the whole record,
    because the blocks do not hold all states of the hysteresis.
    """
    if whole.samples == found.scene.samples:
        return Residual(found.scene, found.fit, found.corrupted)
    usable, corrupted = _without_outliers(whole, linear_fit(thinned(whole), found.fit.chain))
    fit = linear_fit(thinned(usable), found.fit.chain)
    # Without the columns of all rows, which a scene keeps.
    return Residual(usable.bare(), dataclasses.replace(fit, rms_um=rms(fit.error[usable.rows])), corrupted)


def _begin(part: Scene, fit: Fit) -> _State:
    current = Scored.of(part, fit)
    return _State(part, current, Whitenings(part), [current])


def _result(usable: Scene, corrupted: NDArray[np.bool_], state: _State, added: dict[str, Scored]) -> SearchResult:
    """The final fit with what the scores around it say."""
    current, names = state.current, present(state.current.chain)
    less = state.fits_of_smaller([causes()[name].without(current.chain) for name in names])
    without = state.scored(less, bounded=False)
    rivals = {name: one for one in without for name in names if name not in present(one.chain)}
    falls = {name: _fall(one, current) for name, one in added.items() if name not in names}
    bayes = {name: _rise_without(state, current, one) for name, one in rivals.items()}
    return SearchResult(
        scene=usable,
        fit=refine(thinned(usable), current.chain),
        rivals={name: one.fit for name, one in rivals.items()},
        corrupted=corrupted,
        bayes=bayes,
        refused={name: fall for name, fall in falls.items() if fall > 0.0},
        error_growth={name: one.fit.rms_um / current.fit.rms_um for name, one in rivals.items()},
        confidence=_confidences(state, rivals, bayes),
    )


def _confidences(state: _State, rivals: dict[str, Scored], bayes: dict[str, float]) -> dict[str, float]:
    """Posterior probability of each cause; that of an only slow cause by the pooled score."""
    current, slow = state.current, slow_part(state.current)
    if len(slow) != 1:
        return confidences(state.visited, current)
    (name,) = slow
    alike = [one for one in state.visited if slow_part(one) == slow]
    first = state.whitenings.confidence(current, rivals[name], bayes[name], state.visited)
    return confidences(alike, current) | {name: first}


def _best_additions(state: _State) -> dict[str, Scored]:
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
    best: dict[str, Scored] = {}
    for one in sorted(state.scored(fits), key=lambda one: -_fall(one, current)):
        best.setdefault(cause_of[id(one.fit)], one)
    return best


def _fall(larger: Scored, current: Scored) -> float:
    """Fall of the score from the current chain to a larger one, less LEAST_EVIDENCE for each part beyond the first.

    Otherwise parts that are added together could be dropped one by one, and added again.
    """
    counts = [
        sum(len(cause.without_one_part(one.chain)) for cause in causes().values() if cause.present(one.chain))
        for one in (current, larger)
    ]
    return larger.fall_from(current) - max(counts[1] - counts[0] - 1, 0) * LEAST_EVIDENCE


def _accepted(state: _State, one: Scored) -> bool:
    """Whether a larger chain is accepted because its score falls; for the first slow cause, the pooled score too."""
    if _fall(one, state.current) <= LEAST_EVIDENCE:
        return False
    return _rise_without(state, one, state.current) > LEAST_EVIDENCE


def _slow_addition(state: _State, added: dict[str, Scored]) -> Scored | None:
    """The likeliest chain with a first slow cause, None if its pooled score does not fall by LEAST_EVIDENCE."""
    candidates = [one for one in added.values() if adds_first_slow_cause(one, state.current)]
    if not candidates:
        return None
    best = candidates[int(np.argmin(state.whitenings.scores(candidates, state.current.fit)))]
    return best if _rise_without(state, best, state.current) > LEAST_EVIDENCE else None


def _starts(cause: Cause, residual: Residual) -> list[TrainingFit]:
    """The proposals of a cause that are refined, by linear fits."""
    return cause.select_starts(_fitted(residual.scene, cause.proposals(residual)))


def _dropped_or_exchanged(state: _State) -> Scored | None:
    """The chain with one part less or exchanged, None if no such chain is accepted."""
    chain = state.current.chain
    names = present(chain)
    slow = [name for name in slow_causes() if name in names]
    less = [one for name in names for one in causes()[name].simpler_forms(chain)]
    less += [one for name in names for one in causes()[name].without_one_part(chain)]
    less += [causes()[name].without(chain) for name in names]
    if len(slow) > 1:
        less.append(_without(chain, slow))
    dropped = state.scored(state.fits_of_smaller(list(dict.fromkeys(less))))
    for one in dropped:
        fewer = max(1, len(names) - len(present(one.chain)))
        if _rise_without(state, state.current, one) < fewer * LEAST_EVIDENCE and _form_is_evident(state, one, dropped):
            return one
    pairs = [(old, new) for old in names for new in causes() if new not in names and similar(old, new)]
    for old, new in pairs:
        bare = next((one for one in dropped if old not in present(one.chain)), None)
        other = None if bare is None else _best_with(state, bare, new)
        if bare is None or other is None:
            continue
        either_slow = bool({old, new} & set(slow_causes()))
        if _likelier(state, other, bare, either_slow) and _rise_without(state, other, bare) >= LEAST_EVIDENCE:
            return other
    return None


def _leaves_out_a_cause(state: _State, step: Scored) -> bool:
    """Whether a step leads to a chain without a cause of the current chain that is not evident."""
    fewer = set(present(step.chain)) < set(present(state.current.chain))
    return fewer and _rise_without(state, state.current, step) < LEAST_EVIDENCE


def _form_is_evident(state: _State, one: Scored, dropped: Sequence[Scored]) -> bool:
    """Whether a chain has no simpler form of the only slow cause, or one that is evident itself."""
    if not differs_in_its_slow_cause(state.current, one):
        return True
    bare = [less for less in dropped if adds_first_slow_cause(one, less)]
    return all(_rise_without(state, one, less) >= LEAST_EVIDENCE for less in bare)


def _without(chain: Chain, names: Sequence[str]) -> Chain:
    """The chain without the named causes."""
    for name in names:
        chain = causes()[name].without(chain)
    return chain


def _best_with(state: _State, bare: Scored, name: str) -> Scored | None:
    """The chain with the least score that adds the cause `name` to `bare`."""
    starts = _starts(causes()[name], Residual(state.scene, bare.fit))
    return next(iter(state.scored(_refined_if_promising(state, starts))), None)


def _rise_without(state: _State, larger: Scored, less: Scored) -> float:
    """Rise of the score from a chain to one with less; of the pooled score if they differ in the only slow cause."""
    if adds_first_slow_cause(larger, less) or differs_in_its_slow_cause(larger, less):
        return state.whitenings.pooled_fall(larger, less, LEAST_EVIDENCE)
    return larger.fall_from(less)


def _likelier(state: _State, other: Scored, bare: Scored, slow: bool) -> bool:
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


def _start(scene: Scene) -> Fit:
    """The fit of hysteresis and one lag."""
    part = thinned(scene)
    return refine(part, _with_best_lag(part, Chain(LAGS[0] * scene.Ts_s)))


def _with_best_lag(part: Scene, chain: Chain) -> Chain:
    """The chain with its own lag or one of LAGS, whichever leaves the least error before a refinement."""
    lags = [chain.lag_s, *(scale * part.Ts_s for scale in LAGS)]
    return _fitted(part, [dataclasses.replace(chain, lag_s=lag_s) for lag_s in lags])[0].chain


def _fitted(part: Scene, chains: Sequence[Chain]) -> list[TrainingFit]:
    """Linear least-squares fits of the chains to the rows of the scene, sorted by rms error."""
    return sorted((training_fit(part, chain) for chain in chains), key=lambda candidate: candidate.rms_um)


def _refined_from_best_lag(part: Scene, chain: Chain) -> Fit:
    """Fit of the linear and the shape parameters from a chain, with its best lag, as the starting value."""
    return refine(part, _with_best_lag(part, chain), ROUNDS)


def _refined_if_promising(state: _State, starts: Sequence[TrainingFit]) -> list[Fit]:
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
    return refine(part, _without(fit.chain, idle), ROUNDS) if idle else fit


def _without_outliers(scene: Scene, fit: Fit) -> tuple[Scene, NDArray[np.bool_]]:
    """The scene without the corrupted samples in the residual of the fit, and their flags, (n,)."""
    edges = np.cumsum([0, *(len(run.u_V) for run in scene.runs)])
    valid = np.delete(np.arange(scene.samples), scene.lost)
    error = np.interp(np.arange(scene.samples), valid, fit.error[valid])
    step_um = resolution_um(scene.y_um[scene.rows])
    predicted = scene.y_um - fit.error
    corrupted = np.concatenate(
        [outlier_flags(error[a:b], step_um, predicted[a:b]) for a, b in itertools.pairwise(edges)]
    )
    return scene.using(scene.rows[~corrupted[scene.rows]]), corrupted


def thinned(scene: Scene) -> Scene:
    """The scene on at most MOST_ROWS of its rows; `Scene.dense` still holds all of them."""
    rows = scene.rows
    if len(rows) <= MOST_ROWS:
        return scene
    # A constant stride would alias with a periodic input; a jittered stride does not.
    rng = np.random.default_rng(0)
    edges = np.linspace(0, len(rows), MOST_ROWS + 1).astype(int)
    chosen = rows[edges[:-1] + (rng.random(MOST_ROWS) * np.diff(edges)).astype(int)]
    return scene.using(np.asarray(chosen), rows)
