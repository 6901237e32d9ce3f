"""Swaps of a cause of a chain for a similar cause.

Criteria: a smaller error (`swap_similar_causes`), a signature that holds (`swap_slow_causes`), or a likelihood that is
much larger (`likeliest_slow_causes`).
"""

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
"""Least difference of Schwarz's criterion that is very strong evidence (Kass and Raftery, 1995)."""


def swap_similar_causes(part: Scene, fit: Fit, checked: Rows) -> Fit:
    """The fit after each swap of two similar causes (`Cause.mistaken_for`) that lowers the error below HELPS_BELOW."""
    pairs = [(name, other) for name in reversed(in_ladder_order(causes())) for other in causes()[name].mistaken_for]
    for first, second in pairs:
        for old, new in ((first, second), (second, first)):
            if not causes()[old].present(fit.chain) or causes()[new].present(fit.chain):
                continue
            other = best_with(part, linear_fit(part, causes()[old].without(fit.chain)), new)
            if other is None or not admissible(part, other.chain):
                continue
            # The mean of the ratios on the checking rows and on the training rows, as in forward selection.
            if 0.5 * (ratio(other, fit, checked) + other.rms_um / fit.rms_um) < HELPS_BELOW:
                fit = other
    return fit


def swap_slow_causes(part: Scene, fit: Fit, checked: Rows) -> Fit:
    """The fit with each slow cause whose signature does not hold swapped for the best slow cause whose signature holds.

    The new cause must lower the error of the chain without the old one below KEEP_ABOVE; it need not be better than the
    old one. If the signature of another slow cause of the chain holds only without the old cause, the old cause is
    removed and not replaced.
    """
    for old in slow_causes():
        if not causes()[old].present(fit.chain):
            continue
        bare = refine(part, causes()[old].without(fit.chain), rounds=8)
        residual, bare_residual = Residual(part, fit), Residual(part, bare)
        if causes()[old].signature(residual, bare).holds:
            continue
        companions = [causes()[name] for name in slow_causes() if name != old and causes()[name].present(fit.chain)]
        if any(
            not one.signature(residual, bare).holds and one.signature(bare_residual, bare).holds for one in companions
        ):
            fit = bare
            continue
        others = [name for name in slow_causes() if name != old and not causes()[name].present(fit.chain)]
        candidates = [best_with(part, bare, name) for name in others]
        supported = [
            candidate
            for name, candidate in zip(others, candidates, strict=True)
            if candidate is not None and causes()[name].signature(Residual(part, candidate), bare).holds
        ]
        best = min(supported, key=lambda candidate: ratio(candidate, bare, checked), default=bare)
        if ratio(best, bare, checked) < KEEP_ABOVE:
            fit = best
    return fit


def likeliest_slow_causes(scene: Scene, fit: Fit) -> Chain:
    """The chain with its slow causes swapped for the set of slow causes with the smallest Schwarz's criterion.

    Candidates are all sets of one slow cause, and of two if the chain has several slow causes or one whose signature
    does not hold. Only a set whose signatures all hold is accepted. If the signatures of the present set all hold, the
    criterion must fall by VERY_STRONG; if they do not, it must not rise by more than VERY_STRONG. The criterion
    penalises each parameter; all fits use one scene, whitened for the residual of the fit with the smallest error.
    """
    present = _slow(fit.chain)
    if not present:
        return fit.chain
    supported = _evidence_holds(scene, fit, present)
    bare: tuple[str, ...] = ()
    fits = {bare: linear_fit(scene, chain_without(fit.chain, present)), present: refine(scene, fit.chain)}
    for size in (1, 2) if len(present) > 1 or not supported else (1,):
        for names in itertools.combinations(slow_causes(), size):
            smaller = fits.get(names[:-1])
            larger = best_with(scene, smaller, names[-1]) if smaller is not None and names != present else None
            if larger is not None:
                fits[names] = larger
    del fits[bare]
    white = WhitenedScene.of(scene, min(fits.values(), key=lambda one: one.rms_um))
    criterion = {names: schwarz(white, refine(white, one.chain)) for names, one in fits.items()}
    most = criterion[present] + (-VERY_STRONG if supported else VERY_STRONG)
    for names in sorted(fits, key=criterion.__getitem__):
        if (names == present and supported) or criterion[names] > most:
            break
        if names != present and _evidence_holds(scene, fits[names], names):
            return fits[names].chain
    return fit.chain


def compare_likelihood(scene: Scene, fit: Fit, rivals: Mapping[str, Fit]) -> list[str]:
    """The slow causes whose removal raises Schwarz's criterion by more than VERY_STRONG; empty with fewer than two.

    On checking rows the error may hardly grow without a drift, because the free parameters beside the creep fit much
    of the drift. rivals: the best fit without each cause.
    """
    present = _slow(fit.chain)
    if len(present) < 2:
        return []
    white = WhitenedScene.of(scene, fit)
    least = schwarz(white, refine(white, fit.chain)) + VERY_STRONG
    return [name for name in present if schwarz(white, refine(white, rivals[name].chain)) > least]


def _slow(chain: Chain) -> tuple[str, ...]:
    """Names of the slow causes in the chain."""
    return tuple(name for name in slow_causes() if causes()[name].present(chain))


def _evidence_holds(scene: Scene, fit: Fit, names: Sequence[str]) -> bool:
    """Whether the signature of each named cause holds."""
    residual = Residual(scene, fit)
    return all(causes()[name].signature(residual, fit).holds for name in names)


def best_with(part: Scene, bare: Fit, name: str) -> Fit | None:
    """The best fit of `bare` with the cause `name` added; None if the cause proposes no chain."""
    cause = causes()[name]
    candidates = cause.select_starts(fitted(part, cause.proposals(Residual(part, bare))))
    fits = refined(part, [candidate.chain for candidate in candidates], rounds=FINAL_ROUNDS)
    return min(fits, key=lambda candidate: candidate.rms_um, default=None)
