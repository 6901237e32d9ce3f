"""Outliers: single readings far from both neighbours.

The probe's chain has no part for outliers: the search excludes them from every fit (`outlier_detection`), the fit of
the model has weights of 0 for them, and the learner gets a gate if they are frequent (`wrong_readings.are_frequent`).
"""

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes.base import Cause, Effect, Estimate, Residual, Signature
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.probe import Fit
from hysgen.diagnosis.remedy import Advice, Motion, Seen, held
from hysgen.display import decimal
from hysgen.model.residual import LEAST_DEVIATION, local_scatter
from hysgen.record.series import MEDIAN_TO_DEVIATION
from hysgen.record.wrong_readings import are_frequent

Floats = NDArray[np.float64]

FEWEST = 2
"""Least number of places with corrupted samples: what happens once says nothing about the next record."""


class OutliersCause(Cause):
    name = "outliers"
    rank = 0
    experiment = "record with the full range of the sensor free"
    judged_by_gain = False  # on a corrupted sample the error is that of the reading, not that of the model

    on_all_rows = True

    def shown(self, residual: Residual) -> bool:
        """Whether samples are corrupted in FEWEST places and have more error power than all other samples."""
        count = int(residual.corrupted.sum())
        places = int((np.diff(residual.corrupted.astype(np.int8), prepend=0) > 0).sum())
        if places < FEWEST:
            return False
        return _size_um(residual) * math.sqrt(count / len(residual.corrupted)) > residual.fit.rms_um

    def effect(self, residual: Residual) -> Effect:
        """The least deviation of a corrupted sample."""
        scatter_um = MEDIAN_TO_DEVIATION * float(np.median(np.abs(_deviation(residual))))
        return Effect("um off the neighbours", least=LEAST_DEVIATION * scatter_um)

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """Number and size of the corrupted samples, and their size divided by the scatter of all samples."""
        hit, deviation, size_um = np.flatnonzero(residual.corrupted), _deviation(residual), _size_um(residual)
        rate = len(hit) / len(deviation)
        scatter = MEDIAN_TO_DEVIATION * float(np.median(np.abs(deviation)))
        return Signature(
            z=size_um / max(scatter, 1e-300),
            text=f"{len(hit)} of {len(deviation)} samples stand alone, {decimal(size_um, 3)} um off their neighbours "
            f"({size_um / max(scatter, 1e-300):.0f} times the scatter)",
            parameters={
                "rate": Estimate(rate, rate / np.sqrt(len(hit))),
                "size_um": Estimate(size_um, size_um / np.sqrt(2.0 * len(hit))),
            },
        )

    def advice(self, seen: Seen) -> Advice:
        rate, size_um = seen.values["rate"], seen.values["size_um"]
        return Advice(
            f"one reading in {1.0 / rate:.3g} is wrong by {size_um:.3g} um; a loop that takes it kicks by as much",
            "check connector, cable and light path of the sensor; until then a gate (the learner has one) of "
            f"{0.5 * size_um:.2g} um refuses them",
        )

    def motion(self, values: Mapping[str, float], Ts_s: float) -> Motion:
        return held(4.0 * Ts_s / values["rate"])

    def motions_um(self, motion: Motion, seen: Seen) -> tuple[Floats, Floats]:
        quiet_um = np.zeros(len(motion.levels))
        return np.where(np.arange(len(quiet_um)) % 40 == 20, seen.values["size_um"], quiet_um), quiet_um

    def extension(self, residual: Residual) -> Extension:
        gate = are_frequent(np.flatnonzero(residual.corrupted), len(residual.corrupted))
        return Extension(trust=np.where(residual.corrupted, 0.0, 1.0), gate=gate)


def _deviation(residual: Residual) -> Floats:
    """(n,) deviation of the residual from the median of its neighbours."""
    edges = np.cumsum([len(run.u_V) for run in residual.scene.runs])[:-1]
    return np.concatenate([local_scatter(part) for part in np.split(residual.fit.error, edges)])


def _size_um(residual: Residual) -> float:
    """Rms deviation of the corrupted samples."""
    return float(np.sqrt(np.mean(_deviation(residual)[residual.corrupted] ** 2)))
