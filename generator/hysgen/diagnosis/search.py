"""Search for the probe's chain by forward selection and backward elimination.

Forward selection: every cause proposes candidate chains with starting values, the best candidates of each cause are
refined, and the candidate with the smallest error is kept. Each step fits all parameters of the chain jointly, so an
effect that was first attributed to the wrong cause moves to the right one.
Backward elimination: each cause is removed and the others are fitted again; a cause is dropped if the error does not
grow without it. Between the two, a cause is swapped for a similar one if the error falls (`swaps`). All errors are
compared on checking rows: blocks of the identification part that are not fitted (`comparison`).
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes import Residual, causes, slow_causes
from hysgen.diagnosis.comparison import (
    BLOCKS,
    FINAL_ROUNDS,
    HELPS_BELOW,
    KEEP_ABOVE,
    LEAST_ABOVE_NOISE,
    STEP_BELOW,
    Rows,
    admissible,
    chain_without,
    fitted,
    ratio,
    ratio_above_noise,
    refined,
)
from hysgen.diagnosis.outlier_detection import outlier_flags
from hysgen.diagnosis.probe import Chain, Fit, Scene, linear_fit, refine, rms
from hysgen.diagnosis.swaps import (
    compare_likelihood,
    likeliest_slow_causes,
    swap_similar_causes,
    swap_slow_causes,
)
from hysgen.machine.threads import in_threads
from hysgen.record.series import residual_noise, resolution_um

Progress = Callable[[str], None]

MOST_STEPS = 9
"""Largest number of steps of forward selection."""

MOST_ROWS = 8000
"""Rows above which a scene is thinned out for a fit."""


@dataclass(frozen=True, eq=False)
class SearchResult:
    """Result of `search`.

    fit: of the final chain to all usable rows of the identification part. rivals: the best fit without each cause of
    the chain. corrupted: (n,) flags of the corrupted samples. error_growth: for each cause of the chain, the ratio of
    the errors above the white noise on the checking rows without and with the cause (`comparison.ratio_above_noise`).
    separated_by_likelihood: slow causes whose removal raises Schwarz's criterion by more than `swaps.VERY_STRONG`. Such
    a cause may be named although `error_growth` is below `Cause.needed_in`.
    """

    scene: Scene
    fit: Fit
    rivals: dict[str, Fit]
    error_growth: dict[str, float]
    corrupted: NDArray[np.bool_]
    separated_by_likelihood: tuple[str, ...] = ()


def search(scene: Scene, progress: Progress = lambda line: None) -> SearchResult:
    """The chain of the needed causes, by forward selection, swaps, restarts and backward elimination."""
    scene, corrupted = _without_outliers(scene, _start(scene))
    part, checked = split_rows(scene)
    fit = _start(part)
    for _ in range(MOST_STEPS):
        step = forward_step(part, fit, checked)
        if step is None:
            break
        progress(f"{', '.join(present(step.chain)) or 'lag'}: {1e3 * rms(step.error[checked]):.3g} nm")
        fit = step
        usable, corrupted = _without_outliers(scene, fit)
        part, checked = split_rows(usable)
    fit = eliminate_backward(part, swap_similar_causes(part, fit, checked), checked)
    fit = eliminate_backward(part, swap_slow_causes(part, fit, checked), checked)
    fit = drop_unsupported_parts(part, restart(part, fit, checked), checked)
    usable, corrupted = _without_outliers(scene, fit)
    part, checked = split_rows(usable)
    chain = likeliest_slow_causes(usable, fit)
    fit = fit if chain == fit.chain else refine(part, chain)
    names = present(fit.chain)
    rivals = dict(zip(names, refined(part, [causes()[name].without(fit.chain) for name in names]), strict=True))
    error_growth = {name: 1.0 / ratio_above_noise(fit, rivals[name], checked) for name in names}
    error_growth |= _slow_error_growth(part, fit, rivals, checked)
    final = refine(thinned(usable), fit.chain)
    return SearchResult(
        usable, final, rivals, error_growth, corrupted, tuple(compare_likelihood(usable, final, rivals))
    )


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


def _slow_error_growth(part: Scene, fit: Fit, rivals: dict[str, Fit], checked: Rows) -> dict[str, float]:
    """`error_growth` of the slow causes with evidence, in a chain without the slow causes that have none.

    Empty if all slow causes have evidence. A slow cause without evidence may only compensate the excess of another one.
    """
    slow = [name for name in slow_causes() if name in rivals]
    residual = Residual(part, fit)
    supported = [name for name in slow if causes()[name].signature(residual, rivals[name]).holds]
    if supported == slow:
        return {}
    chain = chain_without(fit.chain, [name for name in slow if name not in supported])
    reduced = refine(part, chain, rounds=8)
    others = refined(part, [causes()[name].without(chain) for name in supported])
    return {
        name: 1.0 / ratio_above_noise(reduced, other, checked) for name, other in zip(supported, others, strict=True)
    }


def without(result: SearchResult, names: Sequence[str]) -> Fit:
    """The fit of the chain without the named causes to all usable rows, with all other parameters refined again."""
    if not names:
        return result.fit
    return refine(thinned(result.scene), chain_without(result.fit.chain, names), rounds=8)


def present(chain: Chain) -> list[str]:
    """Names of the causes that the chain holds."""
    return [name for name, cause in causes().items() if cause.present(chain)]


def _start(scene: Scene) -> Fit:
    """The fit of hysteresis and one lag, from the best of three starting values of the lag."""
    lags = [scale * scene.Ts_s for scale in (0.3, 3.0, 30.0)]
    return refine(scene, fitted(scene, [Chain(lag_s) for lag_s in lags])[0].chain)


def forward_step(part: Scene, fit: Fit, checked: Rows) -> Fit | None:
    """One step of forward selection: the refined candidate with the smallest error, None if it is not accepted."""
    residual = Residual(part, fit)
    # Poor starting values are refined too: the refinement of a mode that was fitted in place of a delay changes much.
    starts = in_threads(
        lambda cause: cause.select_starts(fitted(part, cause.proposals(residual))), list(causes().values())
    )
    steps = refined(part, [start.chain for of_cause in starts for start in of_cause])
    steps = [step for step in steps if admissible(part, step.chain) or not admissible(part, fit.chain)]
    if not steps:
        return None
    best = min(steps, key=lambda candidate: ratio(candidate, fit, checked) + candidate.rms_um / fit.rms_um)
    helped = ratio(best, fit, checked) < HELPS_BELOW and ratio_above_noise(best, fit, checked) < STEP_BELOW
    # If the training residual is only noise, the fit has absorbed the missing effect: the checking rows alone decide.
    only_noise = fit.rms_um < (1.0 + LEAST_ABOVE_NOISE**2) * residual_noise(fit.error[part.dense])
    return best if helped and (only_noise or best.rms_um < HELPS_BELOW * fit.rms_um) else None


def restart(part: Scene, fit: Fit, checked: Rows) -> Fit:
    """The best fit from other starting values (`Cause.restarts`), if both the training and the checking error fall."""
    for name in present(fit.chain):
        candidates = fitted(part, causes()[name].restarts(part, fit.chain))[:2]
        for other in refined(part, [candidate.chain for candidate in candidates], rounds=FINAL_ROUNDS):
            if other.rms_um < fit.rms_um and rms(other.error[checked]) < rms(fit.error[checked]):
                fit = other
    return fit


def eliminate_backward(part: Scene, fit: Fit, checked: Rows) -> Fit:
    """Backward elimination: removes the part with the smallest growth of the error until every part is needed.

    A part is a cause, or one of several modes, lines or channels. First, a cause is replaced by a simpler form
    (`Cause.simpler_forms`) if the error does not grow by more than a factor of
    1/HELPS_BELOW.
    """
    for name in present(fit.chain):
        for chain in causes()[name].simpler_forms(fit.chain):
            plain = refine(part, chain, rounds=8)
            if ratio(fit, plain, checked) >= HELPS_BELOW:
                fit = plain
    while True:
        names = present(fit.chain)
        candidates = refined(part, [less for name in names for less in causes()[name].without_one_part(fit.chain)])
        if not candidates:
            return fit
        best = max(candidates, key=lambda candidate: ratio(fit, candidate, checked))
        if ratio_above_noise(fit, best, checked) < KEEP_ABOVE:
            return fit
        fit = best


def drop_unsupported_parts(part: Scene, fit: Fit, checked: Rows) -> Fit:
    """The fit without those of several modes, lines and channels that have no evidence.

    One part without evidence would invalidate the signature of the whole cause, and it may model the effect of another
    cause.
    """
    residual = Residual(part, fit)
    for name in present(fit.chain):
        less = causes()[name].supported(residual)
        if less == fit.chain:
            continue
        fit = refine(part, less, rounds=8)
        step = forward_step(part, fit, checked)
        if step is not None and _all_supported(part, step, present(less)):
            fit = step
        residual = Residual(part, fit)
    return fit


def _all_supported(part: Scene, fit: Fit, names: Sequence[str]) -> bool:
    """Whether every part of each named cause has evidence (`Cause.supported`)."""
    residual = Residual(part, fit)
    return all(causes()[name].supported(residual) == fit.chain for name in names)


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


def split_rows(scene: Scene) -> tuple[Scene, Rows]:
    """The scene on its training rows, and the checking rows: of each three of 24 blocks two train and one checks.

    Training rows are thinned out to MOST_ROWS. Checking rows are not thinned out, because the white noise is estimated
    from differences between neighbours.
    """
    rows = scene.rows
    block = np.arange(len(rows)) * BLOCKS // len(rows)
    return thinned(scene.using(rows[block % 3 != 1])), rows[block % 3 == 1]


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
