"""Fits of candidate chains, and the ratio of their errors on the checking rows: blocks that no fit of the search uses.

The ratio omits the one block on which the chain with more parts has its largest error, because a good chain can fail on
a stroke that is wider than all fitted strokes (`levels`).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes import causes
from hysgen.diagnosis.probe import Chain, Fit, Scene, TrainingFit, refine, rms, training_fit
from hysgen.machine.threads import in_threads
from hysgen.record.series import residual_noise

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]

BLOCKS = 24
FINAL_ROUNDS = 12
"""Gauss-Newton rounds for a chain that may replace the current chain; a candidate of forward selection has 8."""
KEEP_ABOVE = 0.85
"""Backward elimination keeps a part if the error above the noise on the checking rows is 1/0.85 times larger without
it."""
HELPS_BELOW = 0.98
"""Forward selection accepts a step if the rms error falls below this share; some causes help only in combination."""
STEP_BELOW = 0.93
"""The error above the noise must also fall below this share: smaller improvements reduce only the misfit."""

LEAST_ABOVE_NOISE = 0.25
"""Least error above the white noise that can be measured, as a share of the noise: about 2000 samples determine the
noise to 3 %."""

STABLE_BELOW = 0.25
"""A block is not omitted if the chain with more parts has less than this share of the other chain's error on it."""


def fitted(part: Scene, chains: Sequence[Chain]) -> list[TrainingFit]:
    """Linear least-squares fits of the chains to the training rows, sorted by rms error."""
    return sorted(in_threads(lambda chain: training_fit(part, chain), chains), key=lambda candidate: candidate.rms_um)


def refined(part: Scene, chains: Sequence[Chain], rounds: int = 8) -> list[Fit]:
    """Fits of the linear and the shape parameters from each chain as the starting value, in the order of the chains."""
    return in_threads(lambda chain: refine(part, chain, rounds), chains)


def chain_without(chain: Chain, names: Sequence[str]) -> Chain:
    """The chain without the parts of all named causes."""
    for name in names:
        chain = causes()[name].without(chain)
    return chain


def admissible(scene: Scene, chain: Chain) -> bool:
    """Whether the parameters of the chain are in the range that the signature of each cause requires."""
    return all(cause.admissible(scene, chain) for cause in causes().values())


def ratio_above_noise(fit: Fit, rival: Fit, checked: Rows) -> float:
    """Ratio of the errors above the white noise of two fits on the rows `checked`.

        sqrt(max(e^2 - n^2, l^2) / max(e_rival^2 - n^2, l^2)),    l = LEAST_ABOVE_NOISE n

    e, e_rival: rms errors by `levels`; n: white noise of the residual of `fit`. The ratio also measures an effect below
    the noise, because many samples contain the effect. checked: rows that were not thinned out, because the noise is
    estimated from differences between neighbours.
    """
    noise_um = residual_noise(fit.error[checked])
    least = (LEAST_ABOVE_NOISE * noise_um) ** 2
    beyond = [max(level**2 - noise_um**2, least) + 1e-300 for level in levels(fit.error[checked], rival.error[checked])]
    return float(np.sqrt(beyond[0] / beyond[1]))


def ratio(fit: Fit, rival: Fit, checked: Rows) -> float:
    """rms error of `fit` divided by the rms error of `rival` on the rows `checked`, both by `levels`."""
    level_um, rival_um = levels(fit.error[checked], rival.error[checked])
    return level_um / (rival_um + 1e-300)


def levels(richer_um: Floats, poorer_um: Floats) -> tuple[float, float]:
    """rms of two errors, (n,) each, without the one of eight blocks on which the first error is largest.

    A block on which the first error is below STABLE_BELOW times the second is never omitted: the first chain fits this
    block well, and the block may be the only one that excites the added effect.
    """
    parts = np.array_split(np.arange(len(richer_um)), BLOCKS // 3)
    off = [part for part in parts if rms(richer_um[part]) > STABLE_BELOW * rms(poorer_um[part])]
    worst = max(off, key=lambda part: rms(richer_um[part]), default=np.zeros(0, dtype=np.intp))
    return rms(np.delete(richer_um, worst)), rms(np.delete(poorer_um, worst))
