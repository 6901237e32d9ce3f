"""Outliers: readings that stand alone, far from both neighbours; the chain has no part for them, the fit a gate."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes.base import Estimate, Signature
from hysgen.diagnosis.probe import Fit, Scene
from hysgen.diagnosis.spikes import local_scatter

FEWEST = 3


def outliers_signature(scene: Scene, fit: Fit, corrupted: NDArray[np.bool_]) -> Signature | None:
    """How many samples are corrupted and by how much, against the scatter of the others; None if there is none.

    Outliers matter if they carry more of the error than all the rest that the probe leaves.
    """
    hit = np.flatnonzero(corrupted)
    if len(hit) == 0:
        return None
    stand = np.concatenate(
        [local_scatter(part) for part in np.split(fit.error, np.cumsum([len(r.u_V) for r in scene.runs])[:-1])]
    )
    size_um = float(np.sqrt(np.mean(stand[hit] ** 2)))
    rate = len(hit) / len(stand)
    share_um = size_um * np.sqrt(rate)
    scatter = 1.4826 * float(np.median(np.abs(stand)))
    return Signature(
        holds=len(hit) >= FEWEST and share_um > fit.rms_um,
        z=size_um / max(scatter, 1e-300),
        text=f"{len(hit)} of {len(stand)} samples stand alone, {1e3 * size_um:.3g} nm off their neighbours "
        f"({size_um / max(scatter, 1e-300):.0f} times the scatter)",
        parameters={
            "rate": Estimate(rate, rate / np.sqrt(len(hit))),
            "size_um": Estimate(size_um, size_um / np.sqrt(2.0 * len(hit))),
        },
    )
