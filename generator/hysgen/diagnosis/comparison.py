"""Trials of the search: fits of several chains, and how they compare on blocks of the record that were not fitted.

The one block on which the richer of two chains is worst is left out: a stroke wider than any that was fitted can throw
a good chain off (`levels`).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes import causes
from hysgen.diagnosis.probe import Chain, Fit, Scene, linear_fit, refine, rms
from hysgen.machine.threads import in_threads
from hysgen.record.series import residual_noise

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]

BLOCKS = 24
FINAL_ROUNDS = 12
"""Rounds of the fit of a chain that is to take the place of another, where a step of the search has 8."""
KEEP_ABOVE = 0.85
"""A part stays only if the error without it, on blocks not fitted and beyond the noise, is 1/0.85 times as large."""
HELPS_BELOW = 0.98
"""A step forward is taken if the error falls below this share of what it was; two causes may need each other."""
STEP_BELOW = 0.93
"""And if what lies beyond the noise falls below this share: smaller steps are misfit, of which there is no end."""

SHARP = 0.25
"""Share of the white noise down to which what lies beneath it is known: its level to 3 % from some 2000 samples."""

UNDISTURBED = 0.25
"""Share of the poorer chain's error on a block below which the richer one is not thrown off there."""


def fitted(part: Scene, chains: Sequence[Chain]) -> list[Fit]:
    """Linear fits of the chains, the best first."""
    return sorted(in_threads(lambda chain: linear_fit(part, chain), chains), key=lambda trial: trial.rms_um)


def refined(part: Scene, chains: Sequence[Chain], rounds: int = 8) -> list[Fit]:
    """The best fit from each chain, in their order."""
    return in_threads(lambda chain: refine(part, chain, rounds), chains)


def chain_without(chain: Chain, names: Sequence[str]) -> Chain:
    """The chain with the parts of all these causes taken out."""
    for name in names:
        chain = causes()[name].without(chain)
    return chain


def admissible(scene: Scene, chain: Chain) -> bool:
    """Whether the numbers in the chain let the signature of each of its causes hold."""
    return all(cause.admissible(scene, chain) for cause in causes().values())


def remaining(fit: Fit, rival: Fit, checked: Rows) -> float:
    """What `fit` leaves beyond the white noise, as a share of what `rival` leaves beyond it, on the rows `checked`.

    A cause smaller than the noise is still there in many samples at once. Below SHARP of the noise nothing is known.
    checked: not thinned out, for the white noise is told from neighbours.
    """
    noise_um = residual_noise(fit.error[checked])
    least = (SHARP * noise_um) ** 2
    beyond = [max(level**2 - noise_um**2, least) + 1e-300 for level in levels(fit.error[checked], rival.error[checked])]
    return float(np.sqrt(beyond[0] / beyond[1]))


def ratio(fit: Fit, rival: Fit, checked: Rows) -> float:
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
