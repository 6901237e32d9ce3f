"""Search for the chain with the least score (`score`): parts are added, dropped and exchanged while the score falls.

    add       every cause proposes chains with one more part at starting values; the best few are fitted and scored
    drop      a part, a form of a part, a cause, all slow causes, if the score rises by less than LEAST_EVIDENCE a cause
    exchange  a part for a similar one (`Cause.mistaken_for`, slow causes for each other), if the score falls

A part is added if the score falls by LEAST_EVIDENCE, several at once if it falls by as many times that. Each step fits
all parameters of the chain jointly, so an effect that was first attributed to the wrong cause moves to the right one.
Every scored chain counts in the confidences.
"""

import dataclasses
import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes import Residual
from hysgen.diagnosis.probe import (
    Chain,
    Fit,
    Scene,
    refine,
    rms,
    single_fit,
)
from hysgen.diagnosis.score import Scored, confidences, present, structure
from hysgen.diagnosis.search_steps import (
    LAGS,
    ROUNDS,
    State,
    best_additions,
    chains_without_a_cause,
    fall_of_addition,
    leaves_out_a_cause,
    next_step,
    rise_without,
    with_best_lag,
)
from hysgen.diagnosis.slow_evidence import Whitenings, slow_part
from hysgen.model.residual import outlier_flags
from hysgen.record.series import resolution_um

Progress = Callable[[str], None]

MOST_STEPS = 20
"""Largest number of steps; no structure is taken twice with the same error, so the search also ends without it."""

BETTER = 0.01
"""Least fall of the rms error by which a structure is taken again: the second fit found another minimum."""

MOST_ROWS = 8000
"""Rows above which a scene is thinned out for a fit."""


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

    @property
    def residual(self) -> Residual:
        """That of the final chain on the rows of the search, without the flags of corrupted samples."""
        return Residual(self.scene, self.fit)


def search(scene: Scene, progress: Progress = lambda line: None) -> SearchResult:
    """The chain with the least score, from the hysteresis and one lag on."""
    fit = start(scene)
    usable, corrupted = _without_outliers(scene, fit)
    part = thinned(usable)
    state = _begin(part, refine(part, fit.chain))
    added: dict[str, Scored] = {}
    # A search may come back to a structure: causes are exchanged by another measure than they are added and dropped by,
    # and a part that was dropped again may have led the fit out of a local minimum.
    least_um = {structure(state.current.chain): state.current.fit.rms_um}
    for _ in range(MOST_STEPS):
        added = best_additions(state)
        step = next_step(state, added)
        if step is None:
            break
        if step.fit.rms_um > (1.0 - BETTER) * least_um.get(structure(step.chain), np.inf):
            if leaves_out_a_cause(state, step):
                # No addition to this chain is known, but it holds nothing that is not evident.
                state.current, added = step, {}
            break
        least_um[structure(step.chain)] = step.fit.rms_um
        progress(f"{', '.join(present(step.chain)) or 'lag'}: {rms(step.fit.error[part.rows]):.3g} um")
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
    fit = single_fit(thinned(whole), found.fit.chain)
    usable, corrupted = _without_outliers(whole, fit)
    if len(usable.rows) < len(whole.rows):
        fit = single_fit(thinned(usable), found.fit.chain)
    # Without the columns of all rows, which a scene keeps.
    return Residual(usable.bare(), dataclasses.replace(fit, rms_um=rms(fit.error[usable.rows])), corrupted)


def _begin(part: Scene, fit: Fit) -> State:
    current = Scored.of(part, fit)
    return State(part, current, Whitenings(part), [current])


def _result(usable: Scene, corrupted: NDArray[np.bool_], state: State, added: dict[str, Scored]) -> SearchResult:
    """The final fit with what the scores around it say."""
    current, names = state.current, present(state.current.chain)
    less = state.fits_of_smaller(chains_without_a_cause(state))
    without = state.scored(less, bounded=False)[::-1]
    rivals = {name: one for one in without for name in names if name not in present(one.chain)}
    falls = {name: fall_of_addition(one, current) for name, one in added.items() if name not in names}
    bayes = {name: rise_without(state, current, one) for name, one in rivals.items()}
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


def _confidences(state: State, rivals: dict[str, Scored], bayes: dict[str, float]) -> dict[str, float]:
    """Posterior probability of each cause; that of an only slow cause by the pooled score."""
    current, slow = state.current, slow_part(state.current)
    if len(slow) != 1:
        return confidences(state.visited, current)
    (name,) = slow
    alike = [one for one in state.visited if slow_part(one) == slow]
    first = state.whitenings.confidence(current, rivals[name], bayes[name], state.visited)
    return confidences(alike, current) | {name: first}


def start(scene: Scene) -> Fit:
    """The fit of hysteresis and one lag."""
    part = thinned(scene)
    return refine(part, with_best_lag(part, Chain(LAGS[0] * scene.Ts_s)))


def _without_outliers(scene: Scene, fit: Fit) -> tuple[Scene, NDArray[np.bool_]]:
    """The scene without the corrupted samples in the residual of the fit, and their flags, (n,)."""
    corrupted = corrupted_samples(scene, fit)
    return scene.using(scene.rows[~corrupted[scene.rows]]), corrupted


def corrupted_samples(scene: Scene, fit: Fit) -> NDArray[np.bool_]:
    """(n,) flags of the corrupted samples in the residual of the fit.

    Samples before the first fitted row of a run are not judged: what rang down before it is extrapolated there.
    """
    edges = np.cumsum([0, *(len(run.u_V) for run in scene.runs)])
    valid = np.delete(np.arange(scene.samples), scene.lost)
    error = np.interp(np.arange(scene.samples), valid, fit.error[valid])
    step_um = resolution_um(scene.y_um[scene.rows])
    predicted = scene.y_um - fit.error
    corrupted = np.zeros(scene.samples, dtype=np.bool_)
    for begin, end in itertools.pairwise(edges):
        first = int(scene.rows[(scene.rows >= begin) & (scene.rows < end)].min(initial=end))
        corrupted[first:end] = outlier_flags(error[first:end], step_um, predicted[first:end])
    return corrupted


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
