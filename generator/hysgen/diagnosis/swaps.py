"""Exchanging a cause of a chain for one that looks like it: where that explains more, is sound, or is far likelier."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

from hysgen.diagnosis.causes import Residual, causes, in_ladder_order, slow_causes
from hysgen.diagnosis.comparison import (
    FINAL_ROUNDS,
    HELPS_BELOW,
    KEEP_ABOVE,
    Rows,
    admissible,
    chain_without,
    fitted,
    ratio,
    refined,
)
from hysgen.diagnosis.probe import Chain, Fit, Scene, WhitenedScene, linear_fit, refine, schwarz

VERY_STRONG = 10.0
"""Difference of Schwarz's criterion from which on the evidence is very strong (Kass and Raftery, 1995)."""


def swap_similar_causes(part: Scene, fit: Fit, checked: Rows) -> Fit:
    """The fit with a cause exchanged for one that looks like it, where that explains more."""
    pairs = [(name, other) for name in reversed(in_ladder_order(causes())) for other in causes()[name].mistaken_for]
    for first, second in pairs:
        for old, new in ((first, second), (second, first)):
            if not causes()[old].present(fit.chain) or causes()[new].present(fit.chain):
                continue
            other = best_with(part, linear_fit(part, causes()[old].without(fit.chain)), new)
            if other is None or not admissible(part, other.chain):
                continue
            # Both halves of the rows have their say, as in a step forward.
            if 0.5 * (ratio(other, fit, checked) + other.rms_um / fit.rms_um) < HELPS_BELOW:
                fit = other
    return fit


def swap_slow_causes(part: Scene, fit: Fit, checked: Rows) -> Fit:
    """The fit with a cause whose own signature does not hold exchanged for the best of those that are slow like it.

    It explains no more than what it replaces, or `exchanged` would have taken it; but it is sound. If one that is
    there already becomes sound without its neighbour, the neighbour just goes.
    """
    for old in slow_causes():
        if not causes()[old].present(fit.chain):
            continue
        bare = refine(part, causes()[old].without(fit.chain), rounds=8)
        residual, bare_residual = Residual(part, fit), Residual(part, bare)
        if causes()[old].signature(residual, bare).holds:
            continue
        beside = [causes()[name] for name in slow_causes() if name != old and causes()[name].present(fit.chain)]
        if any(not one.signature(residual, bare).holds and one.signature(bare_residual, bare).holds for one in beside):
            fit = bare
            continue
        others = [name for name in slow_causes() if name != old and not causes()[name].present(fit.chain)]
        candidates = [best_with(part, bare, name) for name in others]
        sound = [
            candidate
            for name, candidate in zip(others, candidates, strict=True)
            if candidate is not None and causes()[name].signature(Residual(part, candidate), bare).holds
        ]
        best = min(sound, key=lambda candidate: ratio(candidate, bare, checked), default=bare)
        if ratio(best, bare, checked) < KEEP_ABOVE:
            fit = best
    return fit


def likeliest_slow_causes(scene: Scene, fit: Fit) -> Chain:
    """The chain with its slow causes exchanged for others that are sound, where these are likelier.

    Those that are sound go only for others that are far likelier, those that are not all sound for the likeliest that
    are, unless these are far less likely. Two are looked for where two are there, or one that is not sound. All are
    fitted to one scene, whitened for what the best of them leaves; a cause pays for each of its parameters.
    """
    there = _slow(fit.chain)
    if not there:
        return fit.chain
    sound = _evidence_holds(scene, fit, there)
    bare: tuple[str, ...] = ()
    fits = {bare: linear_fit(scene, chain_without(fit.chain, there)), there: refine(scene, fit.chain)}
    for size in (1, 2) if len(there) > 1 or not sound else (1,):
        for names in itertools.combinations(slow_causes(), size):
            beside = fits.get(names[:-1])
            other = best_with(scene, beside, names[-1]) if beside is not None and names != there else None
            if other is not None:
                fits[names] = other
    del fits[bare]
    white = WhitenedScene.of(scene, min(fits.values(), key=lambda one: one.rms_um))
    worth = {names: schwarz(white, refine(white, one.chain)) for names, one in fits.items()}
    most = worth[there] + (-VERY_STRONG if sound else VERY_STRONG)
    for names in sorted(fits, key=worth.__getitem__):
        if (names == there and sound) or worth[names] > most:
            break
        if names != there and _evidence_holds(scene, fits[names], names):
            return fits[names].chain
    return fit.chain


def compare_likelihood(scene: Scene, fit: Fit, rivals: Mapping[str, Fit]) -> list[str]:
    """Those of several slow causes beside which the chain is far likelier than without them.

    On blocks left out, what is free beside creep does much of a drift's work. rivals: the best fit without each cause.
    """
    there = _slow(fit.chain)
    if len(there) < 2:
        return []
    white = WhitenedScene.of(scene, fit)
    least = schwarz(white, refine(white, fit.chain)) + VERY_STRONG
    return [name for name in there if schwarz(white, refine(white, rivals[name].chain)) > least]


def _slow(chain: Chain) -> tuple[str, ...]:
    """Names of the slow causes that the chain holds."""
    return tuple(name for name in slow_causes() if causes()[name].present(chain))


def _evidence_holds(scene: Scene, fit: Fit, names: Sequence[str]) -> bool:
    """Whether each of these causes shows evidence of its own."""
    residual = Residual(scene, fit)
    return all(causes()[name].signature(residual, fit).holds for name in names)


def best_with(part: Scene, bare: Fit, name: str) -> Fit | None:
    """The best fit with the cause `name` added to `bare`."""
    cause = causes()[name]
    candidates = cause.select_starts(fitted(part, cause.proposals(Residual(part, bare))))
    found = refined(part, [candidate.chain for candidate in candidates], rounds=FINAL_ROUNDS)
    return min(found, key=lambda candidate: candidate.rms_um, default=None)
