"""Finding the chain: forward while something helps, backward until everything left is needed.

Forward: every cause proposes rough chains, the best of each is refined, the one that helps most is kept. Everything is
fitted jointly again at each step, so what a first cause soaked up is given back when the second one arrives.
Backward: each cause is taken out, everything else refitted; what was not needed goes.
In between, a cause gives way to a similar one where that explains more (`swaps`). Both measures are taken on blocks of
the identification part that were not fitted (`comparison`).
"""

from __future__ import annotations

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
    SHARP,
    STEP_BELOW,
    Rows,
    admissible,
    chain_without,
    fitted,
    ratio,
    refined,
    remaining,
)
from hysgen.diagnosis.probe import Chain, Fit, Scene, refine, rms
from hysgen.diagnosis.spikes import isolated
from hysgen.diagnosis.swaps import (
    compare_likelihood,
    likeliest_slow_causes,
    swap_similar_causes,
    swap_slow_causes,
)
from hysgen.record.series import residual_noise

Progress = Callable[[str], None]

MOST_STEPS = 9

MOST_ROWS = 8000


@dataclass(frozen=True, eq=False)
class Found:
    """The chain that the search ended with, its rivals without each cause, and which samples count as corrupted.

    fit: on all usable rows of the identification part. needs: how many times the error beyond the white noise, on
    blocks left out of the fit, grows without a cause, as measured (`comparison.remaining`).
    separated_by_likelihood: those of several slow causes with which Schwarz's criterion finds the chain far likelier.
    Such a cause may be named although the error grows less than `Cause.needed` without it.
    """

    scene: Scene
    fit: Fit
    rivals: dict[str, Fit]
    needs: dict[str, float]
    corrupted: NDArray[np.bool_]
    separated_by_likelihood: tuple[str, ...] = ()


def search(scene: Scene, progress: Progress = lambda line: None) -> Found:
    """The chain that explains the scene with nothing that it does not need."""
    scene, corrupted = _without_spikes(scene, _start(scene))
    part, checked = halves(scene)
    fit = _start(part)
    for _ in range(MOST_STEPS):
        step = forward_step(part, fit, checked)
        if step is None:
            break
        progress(f"{', '.join(present(step.chain)) or 'lag'}: {1e3 * rms(step.error[checked]):.3g} nm")
        fit = step
        usable, corrupted = _without_spikes(scene, fit)
        part, checked = halves(usable)
    fit = eliminate_backward(part, swap_similar_causes(part, fit, checked), checked)
    fit = eliminate_backward(part, swap_slow_causes(part, fit, checked), checked)
    fit = drop_unsupported_parts(part, restart(part, fit, checked), checked)
    usable, corrupted = _without_spikes(scene, fit)
    part, checked = halves(usable)
    chain = likeliest_slow_causes(usable, fit)
    fit = fit if chain == fit.chain else refine(part, chain)
    names = present(fit.chain)
    rivals = dict(zip(names, refined(part, [causes()[name].without(fit.chain) for name in names]), strict=True))
    needs = {name: 1.0 / remaining(fit, rivals[name], checked) for name in names}
    needs |= _slow_needs(part, fit, rivals, checked)
    final = refine(thinned(usable), fit.chain)
    return Found(usable, final, rivals, needs, corrupted, tuple(compare_likelihood(usable, final, rivals)))


def _slow_needs(part: Scene, fit: Fit, rivals: dict[str, Fit], checked: Rows) -> dict[str, float]:
    """How much the slow causes that are sound are needed beside each other alone, if some are not sound.

    An unsound one may be there only to take back what another one has too much of.
    """
    slow = [name for name in slow_causes() if name in rivals]
    residual = Residual(part, fit)
    sound = [name for name in slow if causes()[name].signature(residual, rivals[name]).holds]
    if sound == slow:
        return {}
    chain = chain_without(fit.chain, [name for name in slow if name not in sound])
    alone = refine(part, chain, rounds=8)
    others = refined(part, [causes()[name].without(chain) for name in sound])
    return {name: 1.0 / remaining(alone, other, checked) for name, other in zip(sound, others, strict=True)}


def without(found: Found, names: Sequence[str]) -> Fit:
    """The fit to all usable rows without some of its causes, the others refined again."""
    if not names:
        return found.fit
    return refine(thinned(found.scene), chain_without(found.fit.chain, names), rounds=8)


def present(chain: Chain) -> list[str]:
    """Names of the causes that the chain holds."""
    return [name for name, cause in causes().items() if cause.present(chain)]


def _start(scene: Scene) -> Fit:
    """The bare stage: hysteresis and one lag, from the best of a few lags."""
    lags = [scale * scene.Ts_s for scale in (0.3, 3.0, 30.0)]
    return refine(scene, fitted(scene, [Chain(lag_s) for lag_s in lags])[0].chain)


def forward_step(part: Scene, fit: Fit, checked: Rows) -> Fit | None:
    """The most helpful single addition, refined; None if none helps enough."""
    residual = Residual(part, fit)
    # Poor starts are refined too: a mode that was fitted in place of a delay changes much in its refinement.
    trials = [
        trial for cause in causes().values() for trial in cause.select_starts(fitted(part, cause.proposals(residual)))
    ]
    steps = refined(part, [trial.chain for trial in trials])
    steps = [step for step in steps if admissible(part, step.chain) or not admissible(part, fit.chain)]
    if not steps:
        return None
    best = min(steps, key=lambda trial: ratio(trial, fit, checked) + trial.rms_um / fit.rms_um)
    helped = ratio(best, fit, checked) < HELPS_BELOW and remaining(best, fit, checked) < STEP_BELOW
    # Fitted rows that show nothing but noise have no say: there the fit has bent itself around what is missing.
    silent = fit.rms_um < (1.0 + SHARP**2) * residual_noise(fit.error[part.dense])
    return best if helped and (silent or best.rms_um < HELPS_BELOW * fit.rms_um) else None


def restart(part: Scene, fit: Fit, checked: Rows) -> Fit:
    """The fit from the best of other starts, where that explains more."""
    for name in present(fit.chain):
        trials = fitted(part, causes()[name].restarts(part, fit.chain))[:2]
        for other in refined(part, [trial.chain for trial in trials], rounds=FINAL_ROUNDS):
            if other.rms_um < fit.rms_um and rms(other.error[checked]) < rms(fit.error[checked]):
                fit = other
    return fit


def eliminate_backward(part: Scene, fit: Fit, checked: Rows) -> Fit:
    """The fit without what it does not need, least needed first; each mode, line and channel for itself.

    Before that, every cause takes its simpler form if that explains as much.
    """
    for name in present(fit.chain):
        for chain in causes()[name].simpler_forms(fit.chain):
            plain = refine(part, chain, rounds=8)
            if ratio(fit, plain, checked) >= HELPS_BELOW:
                fit = plain
    while True:
        names = present(fit.chain)
        trials = refined(part, [less for name in names for less in causes()[name].without_one_part(fit.chain)])
        if not trials:
            return fit
        best = max(trials, key=lambda trial: ratio(fit, trial, checked))
        if remaining(fit, best, checked) < KEEP_ABOVE:
            return fit
        fit = best


def drop_unsupported_parts(part: Scene, fit: Fit, checked: Rows) -> Fit:
    """The fit without the modes, lines and channels, of several, that show no evidence of their own.

    One such part would deny the whole cause its signature, and may stand where another cause should.
    """
    residual = Residual(part, fit)
    for name in present(fit.chain):
        less = causes()[name].supported(residual)
        if less == fit.chain:
            continue
        fit = refine(part, less, rounds=8)
        step = forward_step(part, fit, checked)
        if step is not None and _all_sound(part, step, present(less)):
            fit = step
        residual = Residual(part, fit)
    return fit


def _all_sound(part: Scene, fit: Fit, names: Sequence[str]) -> bool:
    """Whether every part of each of these causes shows evidence of its own."""
    residual = Residual(part, fit)
    return all(causes()[name].supported(residual) == fit.chain for name in names)


def _without_spikes(scene: Scene, fit: Fit) -> tuple[Scene, NDArray[np.bool_]]:
    """The scene's rows less the corrupted samples that the fit's error shows, and those samples, (n,)."""
    edges = np.cumsum([0, *(len(run.u_V) for run in scene.runs)])
    heard = np.delete(np.arange(scene.samples), scene.lost)
    error = np.interp(np.arange(scene.samples), heard, fit.error[heard])
    corrupted = np.concatenate([isolated(error[a:b]) for a, b in itertools.pairwise(edges)])
    return scene.using(scene.rows[~corrupted[scene.rows]]), corrupted


def halves(scene: Scene) -> tuple[Scene, Rows]:
    """The scene on the rows to fit, and the rows to check, in alternating blocks, two to one.

    Rows to fit are thinned out if there are very many. Rows to check are not: they cost next to nothing, and the white
    noise is told from neighbours alone.
    """
    rows = scene.rows
    block = np.arange(len(rows)) * BLOCKS // len(rows)
    return thinned(scene.using(rows[block % 3 != 1])), rows[block % 3 == 1]


def thinned(scene: Scene) -> Scene:
    """The scene on MOST_ROWS of its rows at most; it keeps all of them as `dense`."""
    rows = scene.rows
    if len(rows) <= MOST_ROWS:
        return scene
    # An even stride would alias with a periodic input; a jittered one does not.
    rng = np.random.default_rng(0)
    edges = np.linspace(0, len(rows), MOST_ROWS + 1).astype(int)
    chosen = rows[edges[:-1] + (rng.random(MOST_ROWS) * np.diff(edges)).astype(int)]
    return scene.using(np.asarray(chosen), rows)
