"""Finding the chain: forward while something helps, backward until everything left is needed.

Forward: every cause proposes rough chains, the best of each is refined, the one that helps most is kept. Everything is
fitted jointly again at each step, so what a first cause soaked up is given back when the second one arrives.
Backward: each cause is taken out, everything else refitted; what was not needed goes.
Helping and needing are measured on blocks of the identification part that were not fitted, less the one block on which
the richer of two chains is worst: a stroke wider than any that was fitted can throw a good chain off (`levels`).
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnose.evidence import Look, causes
from hysgen.diagnose.noise import innovation
from hysgen.diagnose.probe import Chain, Fit, Scene, linear_fit, refine, rms, side_by_side
from hysgen.diagnose.spikes import isolated

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]
Progress = Callable[[str], None]

BLOCKS = 24
KEEP_ABOVE = 0.85
"""A part stays only if the error without it, on blocks not fitted and beyond the noise, is 1/0.85 times as large."""
HELPS_BELOW = 0.98
"""A step forward is taken if the error falls below this share of what it was; two causes may need each other."""
STEP_BELOW = 0.93
"""And if what lies beyond the noise falls below this share: smaller steps are misfit, of which there is no end."""

ALIKE = (("drift", "aging"), ("drift", "creep"), ("delay", "resonance"), ("saturation", "slew"))
"""Pairs of causes of which the wrong one may come first."""

SLOW = ("creep", "drift", "aging")
"""Causes that take each other's place where one is unsound."""

SHARP = 0.25
"""Share of the white noise down to which what lies beneath it is known: its level to 3 % from some 2000 samples."""

UNDISTURBED = 0.25
"""Share of the poorer chain's error on a block below which the richer one is not thrown off there."""

MOST_STEPS = 9

MOST_ROWS = 8000


@dataclass(frozen=True, eq=False)
class Found:
    """The chain that the search ended with, its rivals without each cause, and which samples count as corrupted.

    fit: on all usable rows of the identification part; checked_rms_um: on blocks left out of the fit.
    """

    scene: Scene
    fit: Fit
    rivals: dict[str, Fit]
    needs: dict[str, float]
    corrupted: NDArray[np.bool_]


def search(scene: Scene, progress: Progress = lambda line: None) -> Found:
    """The chain that explains the scene with nothing that it does not need."""
    scene, corrupted = _without_spikes(scene, _start(scene))
    fitted, checked = _halves(scene)
    part = scene.using(fitted)
    fit = _start(part)
    for _ in range(MOST_STEPS):
        step = _best_step(part, fit, checked)
        if step is None:
            break
        progress(f"{', '.join(present(step.chain)) or 'lag'}: {1e3 * rms(step.error[checked]):.3g} nm")
        fit = step
        usable, corrupted = _without_spikes(scene, fit)
        fitted, checked = _halves(usable)
        part = scene.using(fitted)
    fit = _pruned(part, _exchanged(part, fit, checked), checked)
    fit = _pruned(part, _resigned(part, fit, checked), checked)
    fit = _sounded(part, _restarted(part, fit, checked), checked)
    usable, corrupted = _without_spikes(scene, fit)
    fitted, checked = _halves(usable)
    part = scene.using(fitted)
    names = present(fit.chain)
    rivals = dict(zip(names, _refined(part, [causes()[name].without(fit.chain) for name in names]), strict=True))
    needs = {name: 1.0 / _remaining(fit, rivals[name], checked) for name in names}
    needs |= _slow_needs(part, fit, rivals, checked)
    final = usable.using(_thinned(usable.rows))
    return Found(usable, refine(final, fit.chain), rivals, needs, corrupted)


def _slow_needs(part: Scene, fit: Fit, rivals: dict[str, Fit], checked: Rows) -> dict[str, float]:
    """How much the slow causes that are sound are needed beside each other alone, if some are not sound.

    An unsound one may be there only to take back what another one has too much of.
    """
    slow = [name for name in SLOW if name in rivals]
    look = Look.at(part, fit)
    sound = [name for name in slow if causes()[name].signature(look, rivals[name]).holds]
    if sound == slow:
        return {}
    chain = _lacking(fit.chain, [name for name in slow if name not in sound])
    alone = refine(part, chain, rounds=8)
    others = _refined(part, [causes()[name].without(chain) for name in sound])
    return {name: 1.0 / _remaining(alone, other, checked) for name, other in zip(sound, others, strict=True)}


def without(found: Found, names: Sequence[str]) -> Fit:
    """The fit to all usable rows without some of its causes, the others refined again."""
    if not names:
        return found.fit
    scene = found.scene
    return refine(scene.using(_thinned(scene.rows)), _lacking(found.fit.chain, names), rounds=8)


def _lacking(chain: Chain, names: Sequence[str]) -> Chain:
    """The chain with the parts of all these causes taken out."""
    for name in names:
        chain = causes()[name].without(chain)
    return chain


def present(chain: Chain) -> list[str]:
    """Names of the causes that the chain holds."""
    return [name for name, cause in causes().items() if cause.present(chain)]


def _start(scene: Scene) -> Fit:
    """The bare stage: hysteresis and one lag, from the best of a few lags."""
    lags = [scale * scene.Ts_s for scale in (0.3, 3.0, 30.0)]
    return refine(scene, _fitted(scene, [Chain(lag_s) for lag_s in lags])[0].chain)


def _best_step(part: Scene, fit: Fit, checked: Rows) -> Fit | None:
    """The most helpful single addition, refined; None if none helps enough."""
    look = Look.at(part, fit)
    # Each cause's best are refined, however rough they look: a mode bent around a delay has to straighten out first.
    trials = [trial for cause in causes().values() for trial in cause.promising(_fitted(part, cause.proposals(look)))]
    refined = _refined(part, [trial.chain for trial in trials])
    refined = [trial for trial in refined if _possible(part, trial.chain) or not _possible(part, fit.chain)]
    if not refined:
        return None
    best = min(refined, key=lambda trial: _ratio(trial, fit, checked) + trial.rms_um / fit.rms_um)
    helped = _ratio(best, fit, checked) < HELPS_BELOW and _remaining(best, fit, checked) < STEP_BELOW
    # Fitted rows that show nothing but noise have no say: there the fit has bent itself around what is missing.
    silent = fit.rms_um < (1.0 + SHARP**2) * innovation(fit.error[part.rows])
    return best if helped and (silent or best.rms_um < HELPS_BELOW * fit.rms_um) else None


def _possible(scene: Scene, chain: Chain) -> bool:
    return all(cause.possible(scene, chain) for cause in causes().values())


def _exchanged(part: Scene, fit: Fit, checked: Rows) -> Fit:
    """The fit with a cause exchanged for one that looks like it, where that explains more."""
    for first, second in ALIKE:
        for old, new in ((first, second), (second, first)):
            if not causes()[old].present(fit.chain) or causes()[new].present(fit.chain):
                continue
            other = _replacement(part, linear_fit(part, causes()[old].without(fit.chain)), new)
            if other is not None and _ratio(other, fit, checked) < HELPS_BELOW:
                fit = other
    return fit


def _resigned(part: Scene, fit: Fit, checked: Rows) -> Fit:
    """The fit with a cause whose own signature does not hold exchanged for the best of those that are slow like it.

    It explains no more than what it replaces, or `_exchanged` would have taken it; but it is sound. If one that is
    there already becomes sound without its neighbour, the neighbour just goes.
    """
    for old in SLOW:
        if not causes()[old].present(fit.chain):
            continue
        bare = refine(part, causes()[old].without(fit.chain), rounds=8)
        look, bare_look = Look.at(part, fit), Look.at(part, bare)
        if causes()[old].signature(look, bare).holds:
            continue
        beside = [causes()[name] for name in SLOW if name != old and causes()[name].present(fit.chain)]
        if any(not one.signature(look, bare).holds and one.signature(bare_look, bare).holds for one in beside):
            fit = bare
            continue
        others = [name for name in SLOW if name != old and not causes()[name].present(fit.chain)]
        trials = [_replacement(part, bare, name) for name in others]
        sound = [
            trial
            for name, trial in zip(others, trials, strict=True)
            if trial is not None and causes()[name].signature(Look.at(part, trial), bare).holds
        ]
        best = min(sound, key=lambda trial: _ratio(trial, bare, checked), default=bare)
        if _ratio(best, bare, checked) < KEEP_ABOVE:
            fit = best
    return fit


def _replacement(part: Scene, bare: Fit, name: str) -> Fit | None:
    """The best fit with the cause `name` added to `bare`."""
    trials = _fitted(part, causes()[name].proposals(Look.at(part, bare)))
    return refine(part, trials[0].chain) if trials else None


def _restarted(part: Scene, fit: Fit, checked: Rows) -> Fit:
    """The fit from the best of other starts, where that explains more."""
    for name in present(fit.chain):
        trials = _fitted(part, causes()[name].restarts(part, fit.chain))[:2]
        for other in side_by_side(lambda trial: refine(part, trial.chain), trials):
            if other.rms_um < fit.rms_um and rms(other.error[checked]) < rms(fit.error[checked]):
                fit = other
    return fit


def _pruned(part: Scene, fit: Fit, checked: Rows) -> Fit:
    """The fit without what it does not need, least needed first; each mode, line and channel for itself.

    Before that, every cause takes its simpler form if that explains as much.
    """
    for name in present(fit.chain):
        for chain in causes()[name].simpler(fit.chain):
            plain = refine(part, chain, rounds=8)
            if _ratio(fit, plain, checked) >= HELPS_BELOW:
                fit = plain
    while True:
        names = present(fit.chain)
        trials = _refined(part, [less for name in names for less in causes()[name].lessened(fit.chain)])
        if not trials:
            return fit
        best = max(trials, key=lambda trial: _ratio(fit, trial, checked))
        if _remaining(fit, best, checked) < KEEP_ABOVE:
            return fit
        fit = best


def _sounded(part: Scene, fit: Fit, checked: Rows) -> Fit:
    """The fit without the modes, lines and channels, of several, that show no evidence of their own.

    One such part would deny the whole cause its signature, and may stand where another cause should.
    """
    look = Look.at(part, fit)
    for name in present(fit.chain):
        less = causes()[name].sound(look)
        if less == fit.chain:
            continue
        fit = refine(part, less, rounds=8)
        step = _best_step(part, fit, checked)
        if step is not None and _all_sound(part, step, present(less)):
            fit = step
        look = Look.at(part, fit)
    return fit


def _all_sound(part: Scene, fit: Fit, names: Sequence[str]) -> bool:
    """Whether every part of each of these causes shows evidence of its own."""
    look = Look.at(part, fit)
    return all(causes()[name].sound(look) == fit.chain for name in names)


def _remaining(fit: Fit, rival: Fit, checked: Rows) -> float:
    """What `fit` leaves beyond the white noise, as a share of what `rival` leaves beyond it, on the rows `checked`.

    A cause smaller than the noise is still there in many samples at once. Below SHARP of the noise nothing is known.
    """
    noise_um = innovation(fit.error[checked])
    least = (SHARP * noise_um) ** 2
    beyond = [max(level**2 - noise_um**2, least) + 1e-300 for level in levels(fit.error[checked], rival.error[checked])]
    return float(np.sqrt(beyond[0] / beyond[1]))


def _ratio(fit: Fit, rival: Fit, checked: Rows) -> float:
    """What `fit` leaves as a share of what `rival` leaves, on the rows `checked`."""
    level_um, rival_um = levels(fit.error[checked], rival.error[checked])
    return level_um / (rival_um + 1e-300)


def levels(richer_um: Floats, poorer_um: Floats) -> tuple[float, float]:
    """rms of two errors of the same blocks, (n,) each, less the one block of eight on which the first is worst.

    A block on which the first leaves less than UNDISTURBED of what the second leaves stays: nothing threw it off there,
    and it may be the only one that excites what it explains.
    """
    parts = np.array_split(np.arange(len(richer_um)), BLOCKS // 3)
    off = [part for part in parts if rms(richer_um[part]) > UNDISTURBED * rms(poorer_um[part])]
    worst = max(off, key=lambda part: rms(richer_um[part]), default=np.zeros(0, dtype=np.intp))
    return rms(np.delete(richer_um, worst)), rms(np.delete(poorer_um, worst))


def _fitted(part: Scene, chains: Sequence[Chain]) -> list[Fit]:
    """Linear fits of the chains, the best first."""
    return sorted(side_by_side(lambda chain: linear_fit(part, chain), chains), key=lambda trial: trial.rms_um)


def _refined(part: Scene, chains: Sequence[Chain]) -> list[Fit]:
    """The best fit from each chain, in their order."""
    return side_by_side(lambda chain: refine(part, chain, rounds=8), chains)


def _without_spikes(scene: Scene, fit: Fit) -> tuple[Scene, NDArray[np.bool_]]:
    """The scene's rows less the corrupted samples that the fit's error shows, and those samples, (n,)."""
    edges = np.cumsum([0, *(len(run.u_V) for run in scene.runs)])
    corrupted = np.concatenate([isolated(fit.error[a:b]) for a, b in itertools.pairwise(edges)])
    return scene.using(scene.rows[~corrupted[scene.rows]]), corrupted


def _halves(scene: Scene) -> tuple[Rows, Rows]:
    """Rows to fit and rows to check, in alternating blocks, two to one; thinned out if there are very many."""
    rows = scene.rows
    block = np.arange(len(rows)) * BLOCKS // len(rows)
    fitted, checked = rows[block % 3 != 1], rows[block % 3 == 1]
    return _thinned(fitted), _thinned(checked)


def _thinned(rows: Rows) -> Rows:
    if len(rows) <= MOST_ROWS:
        return rows
    # An even stride would alias with a periodic input; a jittered one does not.
    rng = np.random.default_rng(0)
    edges = np.linspace(0, len(rows), MOST_ROWS + 1).astype(int)
    return np.asarray(rows[edges[:-1] + (rng.random(MOST_ROWS) * np.diff(edges)).astype(int)])
