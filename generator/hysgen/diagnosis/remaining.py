"""What is left: the model's own figure on the held-out rows, that of the probe on the same rows, and why they differ.

The chain of the search has its linear weights fitted to the identification part and is simulated over the whole record;
what no model can know is taken out of both errors (`hysgen.model.remaining`), the same jumps and wrong readings.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.ladder import left_by
from hysgen.diagnosis.prepare import Prepared
from hysgen.diagnosis.probe import Chain
from hysgen.diagnosis.probe.solve import training_fit
from hysgen.diagnosis.search import thinned
from hysgen.model.remaining import Remaining, Taken

Floats = NDArray[np.float64]

AT_THE_NOISE = 1.5
"""Own figure over the noise up to which nothing is left, and over that of the probe up to which both are as good."""

WITHOUT = {"past": "state before the rows", "periodic": "phase of the lines", "aging": "course of the aging",
           "drift": "course of the drift", "jump": "jumps", "gain step": "steps of the gain",
           "outliers": "wrong readings"}  # fmt: skip
"""What is taken out, in words, by cause."""


@dataclass(frozen=True)
class Left:
    """The model's own figure on the held-out rows.

    rms_um: of the model; in_noise: over the noise floor; probe_rms_um: of the probe on the same rows. reason: where the
    difference lies. taken: what was taken out of the error of the model.
    """

    rms_um: float
    in_noise: float
    probe_rms_um: float
    reason: str
    taken: tuple[Taken, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "rms_um": self.rms_um,
            "in_noise": self.in_noise,
            "probe_rms_um": self.probe_rms_um,
            "reason": self.reason,
            "taken_out": list(dict.fromkeys(taken.cause for taken in self.taken)),
            "taken_out_in_words": [taken.text for taken in self.taken],
        }

    def line(self) -> str:
        """One sentence for people."""
        causes = dict.fromkeys(WITHOUT.get(taken.cause, taken.cause) for taken in self.taken)
        without = f" without what no model can know ({', '.join(causes)})" if causes else ""
        return (
            f"Left{without}: {self.rms_um:.3g} um, {self.in_noise:.3g} times the noise; a finer model (the probe) "
            f"leaves {self.probe_rms_um:.3g} um on the same rows: {self.reason}."
        )

    @property
    def sudden(self) -> str:
        """Jumps and steps of the gain in the held-out rows, in words; "" if there are none."""
        found = [taken.text for taken in self.taken if taken.cause in ("jump", "gain step")]
        return f"in the held-out rows {', '.join(found)}: taken out of what is left" if found else ""


def left_over(
    prepared: Prepared, chain: Chain, extensions: Mapping[str, Extension], model: Remaining, noise_um: float
) -> Left:
    """What is left. chain: of the search; extensions: of all causes in it; model: what the last rung leaves."""
    probe = left_by(prepared, extensions, _probe_error_um(prepared, chain), model, finer=True)
    return Left(
        model.rms_um,
        model.rms_um / max(noise_um, 1e-300),
        probe.rms_um,
        _reason(model.rms_um, probe.rms_um, noise_um),
        model.taken,
    )


def _probe_error_um(prepared: Prepared, chain: Chain) -> Floats:
    """(n,) yhat - y of a chain over all rows, its weights fitted to the identification part.

    Slow changes that the models are fitted without are parts of the chain, and so are no part of this error.
    """
    scene = prepared.scene(whole=True)
    known = scene.rows[scene.rows < prepared.cut]
    fit = training_fit(thinned(scene.using(known)), chain)
    return np.asarray(scene.seen(scene.moved_paths(chain, fit.weights), chain, fit.weights) - scene.y_um)


def _reason(rms_um: float, probe_um: float, noise_um: float) -> str:
    """Where the difference between the model, the probe and the noise lies."""
    if rms_um <= AT_THE_NOISE * noise_um:
        return "the model is at the noise"
    if rms_um > AT_THE_NOISE * probe_um:
        return "the difference is the form of the model, not the record"
    if probe_um <= AT_THE_NOISE * noise_um:
        return "both are close to the noise"
    return "what is left has a cause that no model here has, or the record is too short to determine it"
